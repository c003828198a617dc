-- Lesson 2: a ball is thrown; its speed and angle are parameters, and say how far it flies.
local feder = require "feder"

local speed = feder.param("speed", 10, { min = 2, max = 30, help = "of the throw, m/s" })
local angle = feder.param("angle", 45, { min = 10, max = 80, help = "above the ground, degrees" })

local radius, gravity = 0.3, 9.81

return feder.scene {
  title = "2 A throw",
  seconds = 8,
  picture = 0.7,
  camera = { target = { 5, 1.8, 0 }, distance = 8, yaw = feder.deg(20), pitch = feder.deg(10) },
  world = { gravity = { 0, -gravity, 0 } },

  build = function(world, scene)
    world:body { name = "ground", type = "static", shape = feder.plane() }
    scene.ball = world:body { name = "ball", shape = feder.sphere(radius), color = "orange",
      position = { 0, radius + 0.01, 0 },
      velocity = { speed * math.cos(feder.deg(angle)), speed * math.sin(feder.deg(angle)), 0 } }
    scene.ball:on("hit", function(e)
      if scene.distance then return end  -- only the first landing counts
      scene.distance = e.x
      print(("landed %.2f m away after %.2f s"):format(e.x, world:time()))
    end)
  end,

  check = function(world, scene, expect)
    local want = speed ^ 2 * math.sin(2 * feder.deg(angle)) / gravity
    expect(scene.distance, "the ball never landed")
    expect(math.abs(scene.distance - want) < 0.02 * want + 0.1,
      ("landed at %.2f m, the formula says %.2f m"):format(scene.distance, want))
  end,
}
