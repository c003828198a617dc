-- Crates of different weight are dropped into a basin. The light ones float with the draught that their density says,
-- the heavy one sinks.
local feder = require "feder"
local fluid = require "feder.fluid"

local spacing = feder.param("spacing", 0.05, { min = 0.03, max = 0.06 })
local length, depth, level, size = 1.8, 0.7, 0.5, 0.3

return feder.scene {
  title = "Floating crates",
  seconds = 4,
  camera = { yaw = feder.deg(20), pitch = feder.deg(20) },
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    fluid.tank(world, length, 1.2, depth, 0.2)
    scene.water = world:fluid { name = "water", spacing = spacing, viscosity = 2 }
    scene.count = scene.water:fill { box = { { 0, 0, 0 }, { length, level, depth } } }
    scene.crates = {}
    for k, density in ipairs { 200, 500, 800, 2000 } do
      scene.crates[k] = world:body { name = "crate" .. k, shape = feder.box(size, size, size), density = density,
        position = { (k - 0.5) * length / 4, level + size, depth / 2 } }
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.water:count() == scene.count, "particles are missing")
    local surface, n = 0, 0
    for k = 0, 4 do
      local y = scene.water:height_at(k * length / 4 + (k == 0 and 0.05 or k == 4 and -0.05 or 0), 0.1)
      if y then surface, n = surface + y, n + 1 end
    end
    surface = surface / n
    for k, crate in ipairs(scene.crates) do
      local _, y = crate:position()
      if k == 4 then
        expect(y < size, "the heavy crate does not lie on the floor")
      else
        -- upright or not, the immersed share of the volume is its density
        local share = ({ 0.2, 0.5, 0.8 })[k]
        local draught = surface - (y - size / 2)
        expect(math.abs(draught - share * size) < 1.5 * spacing,
          ("crate %d lies %.3f m deep, expected %.3f"):format(k, draught, share * size))
      end
    end
  end,
}
