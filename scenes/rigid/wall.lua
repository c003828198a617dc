-- A wall of 20 rows of 40 cubes in running bond; odd rows are closed by half cubes.
local feder = require "feder"

local rows = feder.param("rows", 20, { min = 1, max = 40, step = 1 })
local length = feder.param("length", 40, { min = 2, max = 100, step = 1 })

return feder.scene {
  title = "Wall",
  seconds = 10,
  world = { gravity = { 0, -10, 0 }, dt = 1 / 60, substeps = 4, sleeping = false },

  build = function(world, scene)
    world:body { type = "static", shape = feder.plane(), friction = 0.6 }
    local cube, half = feder.box(1, 1, 1), feder.box(0.5, 1, 1)
    scene.cubes = {}
    local function add(shape, x, y)
      scene.cubes[#scene.cubes + 1] =
        { x = x, y = y, body = world:body { shape = shape, position = { x, y, 0 }, density = 100, friction = 0.6 } }
    end
    for row = 0, rows - 1 do
      local y = row + 0.5
      if row % 2 == 0 then
        for i = 0, length - 1 do add(cube, i + 0.5, y) end
      else
        add(half, 0.25, y)
        for i = 1, length - 1 do add(cube, i, y) end
        add(half, length - 0.25, y)
      end
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    local drift, sink = 0, 0
    for _, cube in ipairs(scene.cubes) do
      local x, y, z = cube.body:position()
      drift = math.max(drift, math.abs(x - cube.x), math.abs(z))
      sink = math.max(sink, cube.y - y)
    end
    expect(drift < 0.05, "the wall drifts by " .. drift .. " m")
    expect(sink < 0.006 * rows, "the wall sinks by " .. sink .. " m")
  end,
}
