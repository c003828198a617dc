-- A tarpaulin over two posts, held by pegs along its hems, in a storm: it drums, and stands.
local feder = require "feder"

local storm = feder.param("storm", 18, { min = 0, max = 30, help = "m/s" })

local length, slope, ridge, base = 3, 2.0, 1.5, 1.25  -- m: along the ridge, of a side, height, half width

return feder.scene {
  title = "Tent in a storm",
  seconds = 6,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { type = "static", shape = feder.plane(), friction = 0.6 }
    for _, x in ipairs { -length / 2, length / 2 } do
      world:body { name = "post", type = "static", shape = feder.cylinder(0.03, ridge - 0.02), color = "#6f5a3c",
        position = { x, (ridge - 0.02) / 2, 0 } }
    end
    -- a mesh in its pitched shape: columns along the ridge, rows from hem to hem
    local columns, rows = 25, 17
    local points, triangles, pins = {}, {}, {}
    for j = 0, rows - 1 do
      local s = 2 * j / (rows - 1) - 1
      for i = 0, columns - 1 do
        points[#points + 1] = { length * (i / (columns - 1) - 0.5), ridge * (1 - math.abs(s)) + 0.02, base * s }
        if (j == 0 or j == rows - 1) and i % 6 == 0 then pins[#pins + 1] = #points end
        if j == (rows - 1) // 2 and (i == 0 or i == columns - 1) then pins[#pins + 1] = #points end
      end
    end
    for j = 0, rows - 2 do
      for i = 1, columns - 1 do
        local a = j * columns + i
        local b, c, d = a + 1, a + columns, a + columns + 1
        if (i + j) % 2 == 0 then
          triangles[#triangles + 1], triangles[#triangles + 2] = { a, d, b }, { a, c, d }
        else
          triangles[#triangles + 1], triangles[#triangles + 2] = { a, c, b }, { b, c, d }
        end
      end
    end
    scene.tent = world:cloth { name = "tarpaulin", vertices = points, triangles = triangles, pins = pins,
      area_density = 0.5, warp = 30000, weft = 30000, bend = 1e-3, damping = 0.003, self_collision = false,
      color = "#7f8f5a" }
    scene.middle = (rows // 4) * columns + columns // 2 + 1
    world:after(1, function()
      world:force { kind = "wind", velocity = { storm * 0.2, 0, storm }, gust = 0.5, gust_hertz = 0.7 }
    end)
    scene.lowest, scene.highest = 10, -10
  end,

  update = function(world, scene)
    if world:time() < 1 then return end
    local _, y = scene.tent:point(scene.middle)
    scene.lowest, scene.highest = math.min(scene.lowest, y), math.max(scene.highest, y)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.tent:stretch() < 0.1, ("the tarpaulin is stretched by %.1f %%"):format(100 * scene.tent:stretch()))
    expect(scene.highest - scene.lowest > 0.01, ("its side moves by %.3f m"):format(scene.highest - scene.lowest))
    expect(scene.lowest > 0.2, ("its side is pressed down to %.2f m"):format(scene.lowest))
    for i = 1, (scene.tent:count()) do
      local x, y, z = scene.tent:point(i)
      expect(y > -0.03 and y < ridge + 0.6 and math.abs(z) < 2, "the tent has blown away")
    end
  end,
}
