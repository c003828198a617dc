-- Slender columns of unit cubes, 3 m apart: they stand only when the solver does not pump sideways motion.
local feder = require "feder"

local height = feder.param("height", 20, { min = 1, max = 40, step = 1 })
local side = feder.param("side", 5, { min = 1, max = 10, step = 1, help = "columns along an edge of the square" })

return feder.scene {
  title = "Columns",
  seconds = 10,
  world = { gravity = { 0, -10, 0 }, dt = 1 / 60, substeps = 4, sleeping = false },

  build = function(world, scene)
    world:body { type = "static", shape = feder.plane(), friction = 0.6 }
    local box = feder.box(1, 1, 1)
    scene.cubes = {}
    for i = 1, side do
      for j = 1, side do
        for k = 1, height do
          local at = { 3 * i, k - 0.5, 3 * j }
          scene.cubes[#scene.cubes + 1] =
            { at = at, body = world:body { shape = box, position = at, density = 100, friction = 0.6 } }
        end
      end
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    local drift, sink = 0, 0
    for _, cube in ipairs(scene.cubes) do
      local x, y, z = cube.body:position()
      drift = math.max(drift, math.abs(x - cube.at[1]), math.abs(z - cube.at[3]))
      sink = math.max(sink, cube.at[2] - y)
    end
    expect(drift < 0.01, "columns drift by " .. drift .. " m")
    expect(sink < 0.006 * height, "columns sink by " .. sink .. " m")
  end,
}
