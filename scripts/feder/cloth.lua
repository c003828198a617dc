-- Cloth for scenes: materials, and meshes other than the sheet that world:cloth makes by itself.
--   local cloth = require "feder.cloth"
--   world:cloth(cloth.of("silk", { size = { 1, 1 }, resolution = { 30, 30 } }))
-- Stretch and shear are in N/m, bend in N m, area_density in kg/m^2. The figures are of the order of measured fabrics
-- (Kawabata's system); stretch is lower than theirs, as far as a picture shows.
local cloth = {}

cloth.materials = {
  silk    = { area_density = 0.06, stretch = 2000, shear = 30, bend = 3e-6, thickness = 0.006 },
  cotton  = { area_density = 0.15, stretch = 4000, shear = 120, bend = 1e-5, thickness = 0.008 },
  wool    = { area_density = 0.25, stretch = 3000, shear = 80, bend = 2e-5, thickness = 0.012 },
  denim   = { area_density = 0.40, stretch = 8000, shear = 600, bend = 8e-5, thickness = 0.012 },
  leather = { area_density = 0.80, stretch = 12000, shear = 3000, bend = 1e-3, thickness = 0.014 },
}

local function names()
  local list = {}
  for name in pairs(cloth.materials) do list[#list + 1] = name end
  table.sort(list)
  return table.concat(list, ", ")
end

-- of(material, options): the options with the material's numbers where they name none.
function cloth.of(material, options)
  local m = cloth.materials[material]
  if not m then error(("cloth.of: unknown material '%s'; known: %s"):format(tostring(material), names()), 2) end
  local out = {}
  for k, v in pairs(m) do out[k] = v end
  for k, v in pairs(options or {}) do out[k] = v end
  return out
end

local function whole(where, value, least)
  if math.type(value) ~= "integer" or value < least then
    error(("%s: expected a whole number of at least %d, got %s"):format(where, least, tostring(value)), 3)
  end
  return value
end

-- disc(radius, rings): a round sheet in the xz plane; returns vertices, triangles. Ring k has 6 k vertices; the rim
-- is the last 6 rings vertices.
function cloth.disc(radius, rings)
  whole("disc.rings", rings, 1)
  local vertices, triangles = { { 0, 0, 0 } }, {}
  local first = { [0] = 1 }
  for k = 1, rings do
    first[k] = #vertices + 1
    for i = 0, 6 * k - 1 do
      local a = 2 * math.pi * i / (6 * k)
      vertices[#vertices + 1] = { radius * k / rings * math.cos(a), 0, radius * k / rings * math.sin(a) }
    end
  end
  for k = 1, rings do
    for side = 0, 5 do
      for i = 0, k - 1 do
        local function outer(n) return first[k] + n % (6 * k) end
        local function inner(n) return k == 1 and 1 or first[k - 1] + n % (6 * (k - 1)) end
        local o, n = side * k + i, side * (k - 1) + i
        triangles[#triangles + 1] = { inner(n), outer(o + 1), outer(o) }
        if i < k - 1 then triangles[#triangles + 1] = { inner(n), inner(n + 1), outer(o + 1) } end
      end
    end
  end
  return vertices, triangles
end

-- tube(radius, height, around, along): an open cylinder about y; returns vertices, triangles.
function cloth.tube(radius, height, around, along)
  whole("tube.around", around, 3)
  whole("tube.along", along, 2)
  local vertices, triangles = {}, {}
  for j = 0, along - 1 do
    for i = 0, around - 1 do
      local a = 2 * math.pi * i / around
      vertices[#vertices + 1] = { radius * math.cos(a), height * (0.5 - j / (along - 1)), radius * math.sin(a) }
    end
  end
  for j = 0, along - 2 do
    for i = 0, around - 1 do
      local a, b = j * around + i + 1, j * around + (i + 1) % around + 1
      local c, d = a + around, b + around
      if (i + j) % 2 == 0 then
        triangles[#triangles + 1] = { a, b, d }
        triangles[#triangles + 1] = { a, d, c }
      else
        triangles[#triangles + 1] = { a, b, c }
        triangles[#triangles + 1] = { b, d, c }
      end
    end
  end
  return vertices, triangles
end

-- The points and triangles of the octahedron (8 faces) and the icosahedron (20), on the unit sphere.
local function solid(faces)
  if faces == 8 then
    return { { 1, 0, 0 }, { -1, 0, 0 }, { 0, 1, 0 }, { 0, -1, 0 }, { 0, 0, 1 }, { 0, 0, -1 } },
      { { 1, 3, 5 }, { 3, 2, 5 }, { 2, 4, 5 }, { 4, 1, 5 }, { 3, 1, 6 }, { 2, 3, 6 }, { 4, 2, 6 }, { 1, 4, 6 } }
  end
  local points, triangles, golden = {}, {}, (1 + math.sqrt(5)) / 2
  for _, a in ipairs { 1, -1 } do
    for _, b in ipairs { golden, -golden } do
      for _, p in ipairs { { 0, a, b }, { a, b, 0 }, { b, 0, a } } do
        for k = 1, 3 do p[k] = p[k] / math.sqrt(1 + golden ^ 2) end
        points[#points + 1] = p
      end
    end
  end
  local function near(p, q) return (p[1] - q[1]) ^ 2 + (p[2] - q[2]) ^ 2 + (p[3] - q[3]) ^ 2 < 1.2 end
  for i = 1, 12 do
    for j = i + 1, 12 do
      for k = j + 1, 12 do
        local p, q, r = points[i], points[j], points[k]
        if near(p, q) and near(q, r) and near(r, p) then
          local volume = p[1] * (q[2] * r[3] - q[3] * r[2]) + p[2] * (q[3] * r[1] - q[1] * r[3])
            + p[3] * (q[1] * r[2] - q[2] * r[1])
          triangles[#triangles + 1] = volume > 0 and { i, j, k } or { i, k, j }
        end
      end
    end
  end
  return points, triangles
end

-- sphere(radius, levels, faces): a closed sphere, from an octahedron (faces = 8) or an icosahedron (20: nearly equal
-- edges and angles) whose triangles are divided into four `levels` times; returns vertices, triangles.
function cloth.sphere(radius, levels, faces)
  whole("sphere.levels", levels, 0)
  if faces ~= 8 and faces ~= 20 then
    error(("sphere.faces: expected 8 or 20, got %s"):format(tostring(faces)), 2)
  end
  local points, triangles = solid(faces)
  for _ = 1, levels do
    local known, finer = {}, {}
    local function middle(a, b)
      local key = math.min(a, b) * 1000000 + math.max(a, b)
      if not known[key] then
        local p, q = points[a], points[b]
        local x, y, z = p[1] + q[1], p[2] + q[2], p[3] + q[3]
        local size = math.sqrt(x * x + y * y + z * z)
        points[#points + 1] = { x / size, y / size, z / size }
        known[key] = #points
      end
      return known[key]
    end
    for _, t in ipairs(triangles) do
      local a, b, c = t[1], t[2], t[3]
      local ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
      for _, n in ipairs { { a, ab, ca }, { ab, b, bc }, { ca, bc, c }, { ab, bc, ca } } do finer[#finer + 1] = n end
    end
    triangles = finer
  end
  for _, p in ipairs(points) do p[1], p[2], p[3] = radius * p[1], radius * p[2], radius * p[3] end
  return points, triangles
end

return cloth
