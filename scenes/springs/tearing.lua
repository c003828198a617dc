-- A net torn by a falling ball: its threads break where they are stretched too far, each of them once, and the ball
-- goes through the hole. A second ball, light enough to be held, stays in the other net.
local feder = require "feder"
local build = require "feder.build"

local ball_mass = feder.param("ball_mass", 60, { min = 30, max = 200, help = "kg of the ball that falls through" })
local break_strain = feder.param("break_strain", 0.5, { min = 0.3, max = 0.8 })

local count, size, radius = 21, 2, 0.03

return feder.scene {
  title = "Tearing",
  seconds = 3,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 120, substeps = 8 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), position = { 0, -3, 0 } }
    scene.broken = {}
    scene.events = 0
    for side = -1, 1, 2 do
      local points, springs, faces = build.grid {
        count = { count, count }, size = { size, size }, position = { 1.5 * side, 1, 0 },
        stiffness = 2000, damping = 1, break_strain = break_strain, shear = false, tension_only = true,
      }
      local net = world:net { name = side < 0 and "torn" or "whole", points = points, springs = springs, faces = faces,
        masses = 0.02, radius = radius, friction = 0.3, damping = 0.5 }
      for i = 1, count do
        net:pin(i)
        net:pin((count - 1) * count + i)
        net:pin((i - 1) * count + 1)
        net:pin(i * count)
      end
      local ball = world:body { name = side < 0 and "heavy" or "light", shape = feder.sphere(0.25),
        mass = side < 0 and ball_mass or 2, position = { 1.5 * side, side < 0 and 3 or 1.5, 0 } }
      scene[side < 0 and "torn" or "whole"] = net
      scene[side < 0 and "heavy" or "light"] = ball
    end
    world:on("spring_break", function(e)
      scene.events = scene.events + 1
      local key = e.object:name() .. e.index
      scene.broken[key] = (scene.broken[key] or 0) + 1
      scene.weakest = math.min(scene.weakest or math.huge, e.force)
    end)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    local _, heavy = scene.heavy:position()
    local _, light = scene.light:position()
    expect(heavy < 0, ("the heavy ball hangs at %.3f m"):format(heavy))
    expect(light > 0.2 and light < 1.2, ("the light ball is at %.3f m, not in its net"):format(light))

    -- each thread breaks once, beyond its strain, and only in the torn net
    expect(scene.events >= 8, ("%d threads broke"):format(scene.events))
    for name, times in pairs(scene.broken) do
      expect(times == 1, ("%s broke %d times"):format(name, times))
      expect(name:sub(1, 4) == "torn", name .. " broke")
    end
    local rest = size / (count - 1)
    expect(scene.weakest >= 2000 * break_strain * rest * 0.999,
      ("a thread broke at %.1f N, below %.1f N"):format(scene.weakest, 2000 * break_strain * rest))
    local _, threads = scene.torn:count()
    local gone = 0
    for k = 1, threads do
      local strain = scene.torn:strain(k)
      expect(strain <= break_strain, ("thread %d bears a strain of %.3f"):format(k, strain))
      if scene.broken["torn" .. k] then
        gone = gone + 1
        expect(strain == 0, ("thread %d broke and still pulls"):format(k))
      end
    end
    expect(gone == scene.events, ("%d events, %d threads gone"):format(scene.events, gone))
  end,
}
