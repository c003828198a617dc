-- Lesson 7: nets: points with mass and springs between them: one spring by hand, and a trampoline from a builder.
local feder = require "feder"
local build = require "feder.build"

local stiffness = feder.param("stiffness", 200, { min = 20, max = 1000, help = "of the hanging spring, N/m" })
local mass = 2

return feder.scene {
  title = "7 Nets",
  seconds = 6,
  picture = 0.9,
  camera = { target = { 0, 1.1, 0 }, distance = 5.5, yaw = feder.deg(25), pitch = feder.deg(16) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }

    -- by hand: point 1 is pinned, point 2 hangs on a spring. A point with a radius is seen, and collides
    scene.spring = world:net { name = "spring", points = { { -1.7, 2.2, 0 }, { -1.7, 1.7, 0 } }, masses = mass,
      radius = 0.08, springs = { { 1, 2, stiffness = stiffness, damping = 5 } }, pins = { 1 }, color = "red" }

    -- a builder returns points, springs and faces of a shape; faces make it a surface
    local points, springs, faces = build.grid { count = { 13, 13 }, size = { 2, 2 }, position = { 0.4, 0.8, 0 },
      stiffness = 600, damping = 1 }
    scene.trampoline = world:net { name = "trampoline", points = points, springs = springs, faces = faces,
      masses = 0.05, radius = 0.02, color = "blue" }
    for i = 1, #points do
      local x, _, z = scene.trampoline:point(i)
      if math.abs(x - 0.4) > 0.99 or math.abs(z) > 0.99 then scene.trampoline:pin(i) end
    end
    scene.ball = world:body { name = "ball", shape = feder.sphere(0.25), density = 150, color = "yellow",
      position = { 0.4, 2, 0 } }
    scene.lowest, scene.apex = 1, 0
  end,

  update = function(world, scene)
    local _, y = scene.ball:position()
    scene.lowest = math.min(scene.lowest, y)
    if scene.lowest < 0.8 then scene.apex = math.max(scene.apex, y) end  -- after the first bounce
    feder.plot("ball", y)
  end,

  check = function(world, scene, expect)
    -- at rest a spring is longer by m g / k
    local _, y = scene.spring:point(2)
    local want = mass * 9.81 / stiffness
    expect(math.abs(1.7 - y - want) < 0.02, ("the spring is longer by %.3f m, not %.3f"):format(1.7 - y, want))
    expect(scene.lowest > 0.25 and scene.lowest < 0.8, ("the ball went down to %.2f m"):format(scene.lowest))
    expect(scene.apex > 1.1, ("the ball bounced up to %.2f m only"):format(scene.apex))
  end,
}
