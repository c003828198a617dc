-- A drop without gravity, drawn out to an ellipse: surface tension makes it swing with the frequency that Rayleigh
-- found, omega^2 = n (n^2 - 1) sigma / (rho R^3) with n = 2 in the plane.
local feder = require "feder"
local fluid = require "feder.fluid"

local radius, sigma, density = 0.1, 1, 1000  -- m, N/m, kg/m^2
local spacing = feder.param("spacing", 0.008, { min = 0.005, max = 0.012 })
local stretch = 1.15

local period = 2 * math.pi / fluid.swing(sigma, density, radius)

return feder.scene {
  title = "Droplet",
  seconds = 3,
  world = { gravity = { 0, 0 }, dt = 1 / 60, substeps = 4, dimension = 2 },

  build = function(world, scene)
    scene.water = world:fluid { name = "drop", spacing = spacing, density = density, surface_tension = sigma,
      solver = "wcsph", viscosity = 0, artificial_viscosity = 0 }  -- what damps them lets the particles freeze to a lattice
    scene.count = scene.water:fill { points = fluid.drop(radius, spacing, stretch) }
    scene.swing = {}
  end,

  -- how long it is against how wide: the second moments
  update = function(world, scene)
    scene.swing[#scene.swing + 1] = { world:time(), fluid.elongation(scene.water) }
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.water:count() == scene.count, "particles are missing")
    -- half a period between the passages through the circle
    local passages = {}
    for k = 2, #scene.swing do
      local p, q = scene.swing[k - 1], scene.swing[k]
      if p[2] * q[2] <= 0 then passages[#passages + 1] = p[1] + (q[1] - p[1]) * p[2] / (p[2] - q[2]) end
    end
    expect(#passages >= 2, ("the drop passes its circle %d times in %.1f s"):format(#passages, world:time()))
    local measured = 2 * (passages[2] - passages[1])
    expect(math.abs(measured / period - 1) < 0.15, ("period %.2f s, expected %.2f s"):format(measured, period))
    local px, py = world:momentum()
    expect(math.abs(px) + math.abs(py) < 1e-4, "the drop moves as a whole")
  end,
}
