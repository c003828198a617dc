-- A pyramid of unit boxes, the benchmark of Box2D and Box3D: row i holds base - i boxes.
local feder = require "feder"

local base = feder.param("base", 12, { min = 1, max = 200, step = 1, help = "boxes in the lowest row" })

return feder.scene {
  title = "Pyramid",
  seconds = 200 / 60,
  world = { gravity = { 0, -10, 0 }, dt = 1 / 60, substeps = 4, sleeping = false },

  build = function(world, scene)
    world:body { name = "ground", type = "static", shape = feder.box(4 * base, 2, 40), position = { 0, -1, 0 }, friction = 0.6 }
    local box = feder.box(1, 1, 1)
    scene.boxes = {}
    for i = 0, base - 1 do
      for j = i, base - 1 do
        scene.boxes[#scene.boxes + 1] = world:body {
          shape = box, density = 100, friction = 0.6,
          position = { 0.5 * (i + 1) + (j - i) - base / 2, i + 0.5, 0 },
        }
      end
    end
    scene.top = scene.boxes[#scene.boxes]
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    local x, y, z = scene.top:position()
    expect(y >= (base - 0.5) - 0.007 * base, "the top sank from " .. base - 0.5 .. " to " .. y)
    expect(math.abs(x - 0) < 0.1 + 0.01 * base and math.abs(z) < 0.1 + 0.01 * base, "the top moved to x = " .. x .. ", z = " .. z)
    expect(world:max_penetration() < 0.03, "boxes overlap by " .. world:max_penetration())
  end,
}
