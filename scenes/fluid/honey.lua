-- Honey runs off as thick fluids do: a heap of it spreads with the fifth root of time, x = 1.411 (g q^3 t / (3 nu))^(1/5),
-- q what lies on either side (Huppert, The propagation of two-dimensional viscous gravity currents, JFM 121, 1982).
local feder = require "feder"

local spacing = feder.param("spacing", 0.005, { min = 0.004, max = 0.01, help = "m" })
local viscosity = feder.param("viscosity", 10, { min = 6, max = 1000, help = "Pa s" })
local solver = feder.param("solver", "dfsph", { choices = { "dfsph", "pbf", "wcsph" } })

local density, half, high = 1400, 0.1, 0.2  -- kg/m^2, m

return feder.scene {
  title = "Honey",
  seconds = 3,
  world = { gravity = { 0, -9.81 }, dt = 1 / 60, substeps = 4, dimension = 2 },

  build = function(world, scene)
    world:body { type = "static", shape = feder.plane() }
    scene.honey = world:fluid { name = "honey", spacing = spacing, density = density, viscosity = viscosity,
      solver = solver, color = "#d08a20" }
    scene.count = scene.honey:fill { box = { { -half, 0 }, { half, high } } }
    world:on("warning", function(e) scene.said = e.message end)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(not scene.said, scene.said)
    expect(scene.honey:count() == scene.count, "particles are missing")
    local x, far = scene.honey:positions(), 0
    for i = 1, #x, 3 do far = math.max(far, math.abs(x[i])) end
    local law = 1.411 * (9.81 * (half * high) ^ 3 * world:time() / (3 * viscosity / density)) ^ 0.2
    -- the law holds once the heap has forgotten its start: four times as wide
    if law < 4 * half then return end
    expect(math.abs(far / law - 1) < 0.1, ("the front is at %.3f m, the law says %.3f"):format(far, law))
  end,
}
