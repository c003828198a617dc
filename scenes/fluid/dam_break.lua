-- A column of water is let go in a tank: its front runs along the floor as Martin and Moyce measured in 1952, hits
-- the far wall, and no particle gets out.
local feder = require "feder"
local fluid = require "feder.fluid"

local spacing = feder.param("spacing", 0.05, { min = 0.02, max = 0.1, help = "m; half of it is eight times the particles" })
local solver = feder.param("solver", "pbf", { choices = { "pbf", "dfsph", "wcsph" } })

local a, depth, length = 1, 0.4, 3.2  -- column a x a, tank, m
local wall = 0.2

-- front / a over t sqrt(g / a); tests/fluid/test_dam_break.cpp says why and by how much the films start late
local delay = fluid.diaphragm_delay

return feder.scene {
  title = "Dam break",
  seconds = 3,
  camera = { yaw = feder.deg(14), pitch = feder.deg(14) },
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    fluid.tank(world, length, 2, depth, wall)
    scene.water = world:fluid { name = "water", spacing = spacing, solver = solver,
      viscosity = 0.073 }  -- the Reynolds number of the 5.7 cm column that was measured
    scene.count = scene.water:fill { box = { { 0, 0, 0 }, { a, a, depth } } }
    scene.run = {}
  end,

  -- how far the front has come, once per step
  update = function(world, scene)
    if world:time() > 0.7 then return end
    scene.run[#scene.run + 1] = { world:time() * math.sqrt(9.81 / a) + delay, fluid.front(scene.water) / a }
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.water:count() == scene.count, "particles are missing")
    local x = scene.water:positions()
    for i = 1, #x, 3 do
      expect(x[i] > 0 and x[i] < length and x[i + 1] > 0 and x[i + 2] > 0 and x[i + 2] < depth,
        ("particle %d is outside the tank at %.3f, %.3f, %.3f"):format((i + 2) // 3, x[i], x[i + 1], x[i + 2]))
    end
    local tolerance = 0.08
    for _, m in ipairs(fluid.martin_moyce) do
      for k = 2, #scene.run do
        local p, q = scene.run[k - 1], scene.run[k]
        if p[1] <= m[1] and q[1] > m[1] then
          local z = p[2] + (q[2] - p[2]) * (m[1] - p[1]) / (q[1] - p[1])
          expect(math.abs(z / m[2] - 1) < tolerance, ("the front is at %.2f instead of %.2f at T = %.2f"):format(z, m[2], m[1]))
        end
      end
    end
    local mean, most = scene.water:density_error()
    expect(mean < 0.05, ("compressed by %.1f %% on average"):format(100 * mean))
  end,
}
