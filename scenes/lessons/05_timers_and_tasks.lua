-- Lesson 5: time: a timer drops balls, another stops it, and a task runs a lift: up, wait, down.
local feder = require "feder"

local height = feder.param("height", 2, { min = 0.5, max = 4, help = "how far the lift goes up, m" })
local speed = 1  -- of the lift, m/s

return feder.scene {
  title = "5 Timers and tasks",
  seconds = 10,
  picture = 3.5,
  camera = { target = { 0.5, 1.4, 0 }, distance = 7.5, yaw = feder.deg(20), pitch = feder.deg(14) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }

    -- every half second a ball, until three seconds have passed
    scene.balls = 0
    local dropper = world:every(0.5, function()
      scene.balls = scene.balls + 1
      world:body { name = "ball" .. scene.balls, shape = feder.sphere(0.2), color = "gold",
        position = { 2.5 + 0.01 * scene.balls, 3, 0 } }
    end)
    world:after(3.2, function() dropper:disconnect() end)

    -- a kinematic body goes where the script says, and pushes and carries what it meets
    local lift = world:body { name = "lift", type = "kinematic", shape = feder.box(2, 0.2, 2), color = "steel",
      position = { 0, 0.1, 0 } }
    scene.crate = world:body { name = "crate", shape = feder.box(0.8, 0.8, 0.8), color = "wood",
      position = { 0, 0.6, 0 } }

    -- a task reads from top to bottom like a recipe; feder.wait lets the world go on
    world:task(function()
      feder.wait(1)
      lift:set_velocity(0, speed, 0)
      feder.wait(height / speed)
      lift:set_velocity(0, 0, 0)
      feder.wait(0.5)
      scene.top = select(2, scene.crate:position())
      lift:set_velocity(0, -speed, 0)
      feder.wait(height / speed)
      lift:set_velocity(0, 0, 0)
      scene.done = world:time()
    end)
  end,

  check = function(world, scene, expect)
    expect(scene.balls == 6, ("%d balls were dropped"):format(scene.balls))
    expect(scene.done, "the lift is still on its way")
    expect(math.abs(scene.top - (0.6 + height)) < 0.05, ("at the top the crate was at %.2f m"):format(scene.top or 0))
    local x, y = scene.crate:position()
    expect(math.abs(y - 0.6) < 0.05 and math.abs(x) < 0.05, ("the crate ended at %.2f, %.2f"):format(x, y))
  end,
}
