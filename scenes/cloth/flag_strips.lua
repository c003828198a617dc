-- A flag of strips that hang together at stitches, in wind that rises to a storm: seams give way from the fly on until each
-- strip streams by itself, and the ends fly off in shreds; when the storm is over what is left hangs from the pole.
local feder = require "feder"

local storm = feder.param("storm", 26, { min = 0, max = 36, help = "m/s, of the wind at its height" })
local strength = feder.param("strength", 0.2, { min = 0.05, max = 1, help = "strain at which it tears" })

local width, height, top = 1.6, 1.0, 3.2  -- m
local strips, cells, columns = 5, 3, 28  -- rows of cells in a strip, columns of cells
local stitch, slit = 7, 0.008  -- columns between stitches; how far seams gape between them, m

-- A mesh in the xy plane whose seams are slits, but for a vertex at each stitch; returns vertices, triangles, pins,
-- and for each stitch a corner of a triangle above it and one of a triangle below it.
local function sewn()
  local vertices, triangles, pins, stitches = {}, {}, {}, {}
  local function add(x, y)
    vertices[#vertices + 1] = { x, y, 0 }
    return #vertices
  end
  local last  -- the lower border of the strip above
  for s = 1, strips do
    local rows = {}
    for j = 0, cells do
      rows[j] = {}
      for i = 0, columns do
        local x, y = width * i / columns, top - height * (s - 1 + j / cells) / strips
        local seam = (j == 0 and s > 1 and 1) or (j == cells and s < strips and -1) or 0
        local open = i % stitch ~= 0
        if seam == 1 and not open then
          rows[j][i] = last[i]
        else
          rows[j][i] = add(x, y - (open and seam * slit / 2 or 0))
          if i == 0 then pins[#pins + 1] = rows[j][i] end
        end
      end
    end
    for j = 0, cells - 1 do
      for i = 0, columns - 1 do
        local a, b, c, d = rows[j][i], rows[j][i + 1], rows[j + 1][i], rows[j + 1][i + 1]
        if (i + j) % 2 == 0 then
          triangles[#triangles + 1], triangles[#triangles + 2] = { a, c, d }, { a, d, b }
        else
          triangles[#triangles + 1], triangles[#triangles + 2] = { a, c, b }, { b, c, d }
        end
      end
    end
    for i = stitch, s > 1 and columns or 0, stitch do
      stitches[#stitches + 1] = { vertex = rows[0][i] }
    end
    last = rows[cells]
  end
  -- corners count through the triangles: strips come one after another, so the first is above and the last below
  for _, s in ipairs(stitches) do
    for t, corners in ipairs(triangles) do
      for k, v in ipairs(corners) do
        if v == s.vertex then s.above, s.below = s.above or 3 * (t - 1) + k, 3 * (t - 1) + k end
      end
    end
  end
  return vertices, triangles, pins, stitches
end

return feder.scene {
  title = "Flag that tears",
  seconds = 13,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },
  camera = { target = { 0.8, 1.8, 0 }, distance = 5, yaw = feder.deg(10), pitch = feder.deg(10) },
  picture = 6,

  build = function(world, scene)
    world:body { name = "ground", type = "static", shape = feder.plane(), friction = 0.6 }
    world:body { name = "pole", type = "static", shape = feder.cylinder(0.03, top + 0.2), color = "#8a8f96",
      position = { -0.045, (top + 0.2) / 2, 0 } }
    local vertices, triangles, pins
    vertices, triangles, pins, scene.stitches = sewn()
    scene.flag = world:cloth { name = "flag", vertices = vertices, triangles = triangles, pins = pins,
      area_density = 0.15, stretch = 12000, shear = 1500, bend = 1e-5, damping = 0.004,
      thickness = 0.01, tear_strain = strength, color = "#c8402f" }
    scene.tears = 0
    scene.flag:on("tear", function()
      scene.tears, scene.first = scene.tears + 1, scene.first or world:time()
    end)
    -- from a breeze to the storm in 8 s, over at 9 s
    local blowing
    for k = 0, 16 do
      world:after(math.max(0.001, k / 2), function()
        if blowing then blowing:destroy() end
        local v = 4 + (storm - 4) * k / 16
        blowing = world:force { kind = "wind", velocity = { v, 0, 0.15 * v }, gust = 0.4, gust_hertz = 0.6 }
      end)
    end
    world:after(9, function() blowing:destroy() end)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    local kinetic = world:energy()
    expect(kinetic < 0.01, ("it still moves: %.3f J"):format(kinetic))
    for i = 1, (scene.flag:count()) do
      local _, y = scene.flag:point(i)
      expect(y > -0.01 and y < top + 0.1, ("vertex %d is at height %.2f m"):format(i, y))
    end
    -- what holds at the pole, and which stitches are open
    local corner, held = scene.flag:triangles(), 0
    for i = 1, (scene.flag:count()) do held = held + (scene.flag:pinned(i) and 1 or 0) end
    expect(held == strips * cells + 1, ("%d vertices are pinned"):format(held))
    local open = 0
    for _, s in ipairs(scene.stitches) do
      if corner[s.above] ~= corner[s.below] then open = open + 1 end
    end
    if storm <= 8 then expect(scene.tears == 0, ("%d tears in a breeze"):format(scene.tears)) end
    if storm < 24 or strength > 0.22 then return end
    expect(scene.first > 2, ("it tears after %.1f s, in a breeze"):format(scene.first))
    expect(scene.tears > 30, ("%d tears only"):format(scene.tears))
    expect(open >= strips - 1, ("%d stitches are open: fewer than seams"):format(open))
    expect(open < #scene.stitches, "no stitch holds")
  end,
}
