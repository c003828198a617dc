-- Two dimensions: squares, discs and triangles in the xy plane. Nothing leaves it.
local feder = require "feder"

local rows = feder.param("rows", 10, { min = 1, max = 40, step = 1 })

return feder.scene {
  title = "Planar stack",
  seconds = 6,
  world = { dimension = 2, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { name = "ground", type = "static", shape = feder.plane(), friction = 0.6 }
    scene.squares, scene.discs = {}, {}
    for row = 0, rows - 1 do
      for i = 0, rows - 1 - row do
        scene.squares[#scene.squares + 1] = world:body {
          shape = feder.polygon { { -0.5, -0.5 }, { 0.5, -0.5 }, { 0.5, 0.5 }, { -0.5, 0.5 } }, density = 100, friction = 0.6,
          position = { i - (rows - 1 - row) / 2, row + 0.5, 0 },
        }
      end
    end
    for i = 1, 5 do
      scene.discs[i] = world:body {
        name = "disc" .. i, shape = feder.circle(0.5), density = 100, position = { rows + 2 * i, 0.5, 0 }, velocity = { i, 0, 0 },
      }
    end
    scene.triangle = world:body {
      name = "triangle", shape = feder.polygon { { -0.6, -0.4 }, { 0.6, -0.4 }, { 0, 0.8 } }, density = 100,
      position = { -rows - 3, 2, 0 }, rotation = { axis = { 0, 0, 1 }, angle = 0.4 },
    }
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    for _, square in ipairs(scene.squares) do
      local x, y, z = square:position()
      expect(z == 0, "a square left the plane: z = " .. z)
      local wx, wy = square:angular_velocity()
      expect(wx == 0 and wy == 0, "a square turned out of the plane")
    end
    local _, top = scene.squares[#scene.squares]:position()
    expect(top > rows - 0.5 - 0.01 * rows, "the stack sank: top at " .. top)
    local _, y = scene.triangle:position()
    expect(math.abs(y - 0.4) < 0.02, "the triangle does not lie on its base: " .. y)
    for i, disc in ipairs(scene.discs) do
      -- a disc set sliding on the plane ends up rolling with 2/3 of its speed
      local vx = disc:velocity()
      expect(math.abs(vx - 2 / 3 * i) < 0.03 * i, disc:name() .. " rolls at " .. vx)
    end
  end,
}
