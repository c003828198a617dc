-- Lesson 4: events: three balls bounce on a floor, each hit is counted, a gate counts who passes, and rest is noticed.
local feder = require "feder"

local bounce = feder.param("bounce", 0.7, { min = 0, max = 0.8, help = "share of the speed that a ball keeps" })

return feder.scene {
  title = "4 Events",
  seconds = 12,
  picture = 0.9,
  camera = { target = { 0, 1.2, 0 }, distance = 9, yaw = feder.deg(20), pitch = feder.deg(12) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    scene.hits, scene.loudest, scene.passed, scene.asleep = 0, 0, 0, 0

    for i, color in ipairs { "red", "yellow", "blue" } do
      world:body { name = color, tags = { "ball" }, shape = feder.sphere(0.3), restitution = bounce, color = color,
        position = { 2 * (i - 2), 1 + i, 0 } }
    end

    -- all hits of at least 0.5 m/s; in a handler the event e says who, where and how hard
    world:on("hit", { min_speed = 0.5 }, function(e)
      scene.hits = scene.hits + 1
      scene.loudest = math.max(scene.loudest, e.speed)
      print(("%5.2f s  %s and %s, %.1f m/s"):format(world:time(), e.a:name(), e.b:name(), e.speed))
    end)

    -- a region is a sensor: a gate a metre above the floor, through which all three fall
    local gate = world:region { name = "gate", box = { { -3, 0.9, -1 }, { 3, 1.1, 1 } } }
    gate:on("sensor_enter", { tag = "ball" }, function(e)
      if not scene[e.other:name()] then scene.passed = scene.passed + 1 end
      scene[e.other:name()] = true
    end)

    -- what rests falls asleep and costs nothing until something wakes it
    world:on("sleep", function(e)
      scene.asleep = scene.asleep + 1
      print(("%5.2f s  %s is asleep"):format(world:time(), e.object:name()))
    end)
  end,

  check = function(world, scene, expect)
    expect(scene.passed == 3, ("%d balls passed the gate"):format(scene.passed))
    expect(scene.asleep >= 3, ("%d times something fell asleep"):format(scene.asleep))
    -- the highest ball falls 3.7 m: v = sqrt(2 g h)
    local want = math.sqrt(2 * 9.81 * 3.7)
    expect(math.abs(scene.loudest - want) < 0.1, ("the hardest hit was %.2f m/s, not %.2f"):format(scene.loudest, want))
    if bounce >= 0.5 then expect(scene.hits >= 9, ("only %d hits"):format(scene.hits)) end
  end,
}
