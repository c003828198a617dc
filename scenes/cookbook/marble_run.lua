-- A marble run: twelve marbles roll down five chutes, one every half second, and a sensor counts them into a tray.
local feder = require "feder"

local marbles = feder.param("marbles", 12, { min = 1, max = 40 })
local slope = feder.param("slope", 9, { min = 6, max = 12, help = "of the chutes, degrees" })

local chutes, length, drop = 5, 2.4, 0.62  -- how many, how long, and how far below each other, m
local colors = { "red", "orange", "yellow", "green", "teal" }

-- A chute is one body of four boxes: floor, two rails, and a stop at its upper end, on the left (-1) or the right (1).
local function chute(upper)
  return feder.compound {
    { shape = feder.box(length, 0.04, 0.3) },
    { shape = feder.box(length, 0.14, 0.03), position = { 0, 0.05, 0.165 } },
    { shape = feder.box(length, 0.14, 0.03), position = { 0, 0.05, -0.165 } },
    { shape = feder.box(0.03, 0.34, 0.36), position = { upper * length / 2, 0.15, 0 } },
  }
end

return feder.scene {
  title = "Marble run",
  seconds = 14 + marbles / 2,
  picture = 8,
  camera = { target = { 0, 1.6, 0 }, distance = 6.4, yaw = feder.deg(18), pitch = feder.deg(14) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    for i = 1, chutes do
      -- they slope to the right and to the left in turn, each shifted to catch what falls from the one above
      local upper = i % 2 == 1 and -1 or 1
      world:body { name = "chute" .. i, type = "static", shape = chute(upper), color = colors[i],
        position = { 0.22 * upper, 0.7 + drop * (chutes - i), 0 },
        rotation = { axis = { 0, 0, 1 }, angle = upper * feder.deg(slope) } }
    end
    for _, x in ipairs { -0.9, 0.9 } do
      world:body { name = "post", type = "static", shape = feder.cylinder(0.04, 3.6), color = "brown",
        position = { x, 1.8, -0.23 } }
    end
    world:body { name = "tray", type = "static", color = "wood", shape = feder.compound {
      { shape = feder.box(0.9, 0.04, 0.9), position = { 0, 0.02, 0 } },
      { shape = feder.box(0.04, 0.3, 0.9), position = { -0.45, 0.15, 0 } },
      { shape = feder.box(0.04, 1, 0.9), position = { 0.45, 0.5, 0 } },  -- high: some bounce off the others
      { shape = feder.box(0.9, 0.5, 0.04), position = { 0, 0.25, -0.45 } },
      { shape = feder.box(0.9, 0.5, 0.04), position = { 0, 0.25, 0.45 } },
    }, position = { length / 2, 0, 0 } }

    -- a region is a sensor: it pushes nothing, and says who comes and who goes
    local goal = world:region { name = "goal", box = { { 0.8, 0.04, -0.4 }, { 1.6, 1, 0.4 } } }
    scene.arrived = 0
    local seen = {}  -- one that bounces out and comes back counts once
    goal:on("sensor_enter", { tag = "marble" }, function(e)
      local name = e.other:name()
      if seen[name] then return end
      seen[name] = true
      scene.arrived = scene.arrived + 1
      print(("%4.1f s: %s is number %d"):format(world:time(), name, scene.arrived))
    end)

    -- a task may wait: the rest of the world goes on meanwhile
    world:task(function()
      for i = 1, marbles do
        world:body { name = "marble" .. i, tags = { "marble" }, shape = feder.sphere(0.07), density = 2500,
          rolling_friction = 0.0005, color = colors[i % #colors + 1],
          position = { -length / 2, 0.7 + drop * (chutes - 1) + 0.45, 0 } }
        feder.wait(0.5)
      end
    end)
  end,

  update = function(world, scene) feder.plot("arrived", scene.arrived) end,

  check = function(world, scene, expect)
    -- now and then two meet on a chute, and one leaps over the rail
    expect(scene.arrived >= 0.75 * marbles, ("%d of %d marbles arrived"):format(scene.arrived, marbles))
  end,
}
