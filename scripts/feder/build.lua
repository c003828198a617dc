-- Builders of nets: local build = require "feder.build"
--
-- Every builder takes one options table and returns three lists for world:net{ ... }, all counting from 1:
--   points   { {x, y, z}, ... }
--   springs  { {i, j, stiffness =, damping =, break_strain =, tension_only =}, ... }   rest lengths: as built
--   faces    { {i, j, k}, ... }   triangles, counter-clockwise from outside (grid: from above; chain: none)
--
--   local points, springs, faces = build.lattice { count = { 4, 4, 4 }, size = { 1, 1, 1 }, stiffness = 2000 }
--   local jelly = world:net { points = points, springs = springs, masses = 0.05, radius = 0.1 }
--
-- Options of all builders: stiffness (N/m), damping (N s/m along the spring), break_strain (elongation / rest length),
-- tension_only (true: strings, slack below their rest length).
-- What is left out stays out of the spring rows, so the net's own defaults apply.
local build = {}

local function fail(message)
  error(message, 4) -- the line that called the builder
end

local function describe(value)
  if type(value) == "string" then return "'" .. value .. "'" end
  if type(value) == "number" or type(value) == "boolean" then return tostring(value) end
  return type(value)
end

local COMMON = { stiffness = true, damping = true, break_strain = true, tension_only = true }

local function check_options(name, options, known)
  if type(options) ~= "table" then fail(name .. ": expected a table of options, got " .. describe(options)) end
  local unknown, words = {}, {}
  for key in pairs(options) do
    if not (known[key] or COMMON[key]) then unknown[#unknown + 1] = tostring(key) end
  end
  if #unknown == 0 then return end
  table.sort(unknown)
  for key in pairs(known) do words[#words + 1] = key end
  for key in pairs(COMMON) do words[#words + 1] = key end
  table.sort(words)
  fail(name .. ": unknown option '" .. unknown[1] .. "'; known: " .. table.concat(words, ", "))
end

local function is_finite(value)
  return type(value) == "number" and value == value and value > -math.huge and value < math.huge
end

local function number(name, options, key, default, lowest)
  local value = options[key]
  if value == nil then value = default end
  if not is_finite(value) or value < lowest then
    fail(("%s.%s: expected a number of at least %g, got %s"):format(name, key, lowest, describe(value)))
  end
  return value
end

local function whole(name, what, value, lowest)
  if not is_finite(value) or value ~= math.floor(value) or value < lowest or value > 10000000 then
    fail(("%s.%s: expected a whole number of at least %d, got %s"):format(name, what, lowest, describe(value)))
  end
  return math.floor(value)
end

local function vector(name, what, value, default)
  if value == nil then value = default end
  local ok = type(value) == "table" and is_finite(value[1]) and is_finite(value[2]) and is_finite(value[3])
  if not ok then fail(("%s.%s: expected {x, y, z}, got %s"):format(name, what, describe(value))) end
  return value[1], value[2], value[3]
end

-- `count` numbers of at least `lowest` each.
local function list(name, what, value, count, lowest, integers)
  if type(value) ~= "table" or #value ~= count then
    fail(("%s.%s: expected %d numbers, got %s"):format(name, what, count,
      type(value) == "table" and "a list of " .. #value or describe(value)))
  end
  local out = {}
  for k = 1, count do
    local v = value[k]
    if not is_finite(v) or v < lowest or (integers and v ~= math.floor(v)) then
      fail(("%s.%s[%d]: expected a %s of at least %g, got %s"):format(name, what, k,
        integers and "whole number" or "number", lowest, describe(v)))
    end
    out[k] = integers and math.floor(v) or v
  end
  return out
end

local function joiner(name, options, springs)
  local stiffness = options.stiffness ~= nil and number(name, options, "stiffness", nil, 0) or nil
  local damping = options.damping ~= nil and number(name, options, "damping", nil, 0) or nil
  local break_strain = options.break_strain ~= nil and number(name, options, "break_strain", nil, 0) or nil
  local tension_only = options.tension_only
  if tension_only ~= nil and type(tension_only) ~= "boolean" then
    fail(name .. ".tension_only: expected true or false, got " .. describe(tension_only))
  end
  return function(i, j, scale)
    springs[#springs + 1] = {
      i, j, stiffness = stiffness and stiffness * (scale or 1), damping = damping, break_strain = break_strain,
      tension_only = tension_only,
    }
  end
end

-- chain{ from = {0,0,0}, to (required), count (points, at least 2, required), bend = 0 }
-- A straight row of points. bend > 0 also joins second neighbours, with bend times the stiffness.
function build.chain(options)
  check_options("chain", options, { from = true, to = true, count = true, bend = true })
  local x0, y0, z0 = vector("chain", "from", options.from, { 0, 0, 0 })
  local x1, y1, z1 = vector("chain", "to", options.to)
  local count = whole("chain", "count", options.count, 2)
  local bend = number("chain", options, "bend", 0, 0)
  if x0 == x1 and y0 == y1 and z0 == z1 then
    error("chain: expected two different ends, got the same point twice", 2)
  end
  local points, springs = {}, {}
  local join = joiner("chain", options, springs)
  for i = 1, count do
    local t = (i - 1) / (count - 1)
    points[i] = { x0 + t * (x1 - x0), y0 + t * (y1 - y0), z0 + t * (z1 - z0) }
  end
  for i = 1, count - 1 do join(i, i + 1) end
  if bend > 0 then
    for i = 1, count - 2 do join(i, i + 2, bend) end
  end
  return points, springs, {}
end

-- grid{ size = {1, 1}, count = {nx, ny} (points, required), position = {0,0,0} (centre), plane = "xz"|"xy",
--       shear = true (diagonals of the cells), bend = 0 (second neighbours, times the stiffness) }
-- Point (i, j), i = 1..nx along x, has the number (j - 1) nx + i.
function build.grid(options)
  check_options("grid", options,
    { size = true, count = true, position = true, plane = true, shear = true, bend = true })
  local count = list("grid", "count", options.count, 2, 2, true)
  local size = list("grid", "size", options.size or { 1, 1 }, 2, 1e-6)
  local px, py, pz = vector("grid", "position", options.position, { 0, 0, 0 })
  local bend = number("grid", options, "bend", 0, 0)
  local plane = options.plane or "xz"
  if plane ~= "xz" and plane ~= "xy" then
    error("grid.plane: expected 'xz' or 'xy', got " .. describe(plane), 2)
  end
  local nx, ny = count[1], count[2]
  local points, springs, faces = {}, {}, {}
  local join = joiner("grid", options, springs)
  local function at(i, j) return (j - 1) * nx + i end
  for j = 1, ny do
    for i = 1, nx do
      local u = ((i - 1) / (nx - 1) - 0.5) * size[1]
      local v = ((j - 1) / (ny - 1) - 0.5) * size[2]
      points[at(i, j)] = plane == "xz" and { px + u, py, pz + v } or { px + u, py + v, pz }
    end
  end
  for j = 1, ny do
    for i = 1, nx do
      if i < nx then join(at(i, j), at(i + 1, j)) end
      if j < ny then join(at(i, j), at(i, j + 1)) end
      if bend > 0 and i + 2 <= nx then join(at(i, j), at(i + 2, j), bend) end
      if bend > 0 and j + 2 <= ny then join(at(i, j), at(i, j + 2), bend) end
      if i < nx and j < ny then
        local a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
        if options.shear ~= false then
          join(a, c)
          join(b, d)
        end
        if plane == "xz" then -- normal +y
          faces[#faces + 1] = { a, c, b }
          faces[#faces + 1] = { a, d, c }
        else -- normal +z
          faces[#faces + 1] = { a, b, c }
          faces[#faces + 1] = { a, c, d }
        end
      end
    end
  end
  return points, springs, faces
end

-- The outside of a box of nx x ny x nz points as triangles.
local function box_faces(nx, ny, nz, at)
  local faces = {}
  local function quad(a, b, c, d)
    faces[#faces + 1] = { a, b, c }
    faces[#faces + 1] = { a, c, d }
  end
  for j = 1, ny - 1 do
    for i = 1, nx - 1 do
      quad(at(i, j, 1), at(i, j + 1, 1), at(i + 1, j + 1, 1), at(i + 1, j, 1))
      quad(at(i, j, nz), at(i + 1, j, nz), at(i + 1, j + 1, nz), at(i, j + 1, nz))
    end
  end
  for k = 1, nz - 1 do
    for i = 1, nx - 1 do
      quad(at(i, 1, k), at(i + 1, 1, k), at(i + 1, 1, k + 1), at(i, 1, k + 1))
      quad(at(i, ny, k), at(i, ny, k + 1), at(i + 1, ny, k + 1), at(i + 1, ny, k))
    end
    for j = 1, ny - 1 do
      quad(at(1, j, k), at(1, j, k + 1), at(1, j + 1, k + 1), at(1, j + 1, k))
      quad(at(nx, j, k), at(nx, j + 1, k), at(nx, j + 1, k + 1), at(nx, j, k + 1))
    end
  end
  return faces
end

-- lattice{ count = {nx, ny, nz} (points, required), size = {1, 1, 1}, position = {0,0,0} (centre),
--          shear = true (diagonals of the cell faces), body = true (diagonals through the cells) }
-- Cubes: structural springs along the axes, shear and body diagonals. Point (i, j, k) has the number
-- ((k - 1) ny + j - 1) nx + i.
function build.lattice(options)
  check_options("lattice", options, { size = true, count = true, position = true, shear = true, body = true })
  local count = list("lattice", "count", options.count, 3, 2, true)
  local size = list("lattice", "size", options.size or { 1, 1, 1 }, 3, 1e-6)
  local px, py, pz = vector("lattice", "position", options.position, { 0, 0, 0 })
  local nx, ny, nz = count[1], count[2], count[3]
  local points, springs = {}, {}
  local join = joiner("lattice", options, springs)
  local function at(i, j, k) return ((k - 1) * ny + j - 1) * nx + i end
  -- half of the 26 directions to neighbours: the other half is the same springs from the other end
  local directions = {
    { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 },
    { 1, 1, 0 }, { 1, -1, 0 }, { 1, 0, 1 }, { 1, 0, -1 }, { 0, 1, 1 }, { 0, 1, -1 },
    { 1, 1, 1 }, { 1, 1, -1 }, { 1, -1, 1 }, { 1, -1, -1 },
  }
  local first, last = { 1, 4, 10 }, { 3, 9, 13 }
  local wanted = { true, options.shear ~= false, options.body ~= false }
  for k = 1, nz do
    for j = 1, ny do
      for i = 1, nx do
        points[at(i, j, k)] = {
          px + ((i - 1) / (nx - 1) - 0.5) * size[1],
          py + ((j - 1) / (ny - 1) - 0.5) * size[2],
          pz + ((k - 1) / (nz - 1) - 0.5) * size[3],
        }
      end
    end
  end
  for group = 1, 3 do
    for d = first[group], wanted[group] and last[group] or 0 do
      local di, dj, dk = directions[d][1], directions[d][2], directions[d][3]
      for k = 1, nz do
        for j = 1, ny do
          for i = 1, nx do
            local a, b, c = i + di, j + dj, k + dk
            if a >= 1 and a <= nx and b >= 1 and b <= ny and c >= 1 and c <= nz then join(at(i, j, k), at(a, b, c)) end
          end
        end
      end
    end
  end
  return points, springs, box_faces(nx, ny, nz, at)
end

-- The icosahedron: 12 points on the unit sphere, 20 triangles counter-clockwise from outside.
local function icosahedron()
  local a, b = 0.5257311121191336, 0.8506508083520399
  local points = {
    { -a, b, 0 }, { a, b, 0 }, { -a, -b, 0 }, { a, -b, 0 }, { 0, -a, b }, { 0, a, b },
    { 0, -a, -b }, { 0, a, -b }, { b, 0, -a }, { b, 0, a }, { -b, 0, -a }, { -b, 0, a },
  }
  local faces = {
    { 1, 12, 6 }, { 1, 6, 2 }, { 1, 2, 8 }, { 1, 8, 11 }, { 1, 11, 12 }, { 2, 6, 10 }, { 6, 12, 5 },
    { 12, 11, 3 }, { 11, 8, 7 }, { 8, 2, 9 }, { 4, 10, 5 }, { 4, 5, 3 }, { 4, 3, 7 }, { 4, 7, 9 },
    { 4, 9, 10 }, { 5, 10, 6 }, { 3, 5, 12 }, { 7, 3, 11 }, { 9, 7, 8 }, { 10, 9, 2 },
  }
  return points, faces
end

-- One number per pair of points, whichever comes first.
local function pair_key(i, j, count)
  if i > j then i, j = j, i end
  return i * (count + 1) + j
end

-- Kuhn's six tetrahedra of a unit cube: from its corner (0, 0, 0) to (1, 1, 1), one axis after another.
local KUHN = { { 1, 2, 3 }, { 1, 3, 2 }, { 2, 1, 3 }, { 2, 3, 1 }, { 3, 1, 2 }, { 3, 2, 1 } }

-- ball{ radius = 0.5, position = {0,0,0}, layers = 2 (1..12: 13, 55, 147, 309, 561 ... points) }
-- A ball of tetrahedra: the icosahedron cut into 20 tetrahedra from its middle, each cut into layers^3 smaller ones, and
-- every layer of points moved out to a sphere. The first point is the middle, the last layer comes last. Also returns
-- the tetrahedra, { {a, b, c, d}, ... } with (b - a) x (c - a) . (d - a) > 0, and the number of points inside.
function build.ball(options)
  check_options("ball", options, { radius = true, position = true, layers = true })
  local radius = number("ball", options, "radius", 0.5, 1e-6)
  local px, py, pz = vector("ball", "position", options.position, { 0, 0, 0 })
  local n = options.layers == nil and 2 or whole("ball", "layers", options.layers, 1)
  if n > 12 then error("ball.layers: expected a whole number from 1 to 12, got " .. n, 2) end
  local corners, triangles = icosahedron()

  -- points: sums of corners with whole weights; those of layer s have the total weight s
  local points, place = { { px, py, pz } }, {}
  local function point_at(triangle, a, b, c)
    if a == 0 then return 1 end
    -- a >= b >= c: weights a - b, b - c, c of the three corners
    local weights = { a - b, b - c, c }
    local key, x, y, z = "", 0, 0, 0
    for k = 1, 3 do
      if weights[k] > 0 then
        local corner = corners[triangle[k]]
        key = key .. triangle[k] .. "*" .. weights[k] .. " "
        x, y, z = x + weights[k] * corner[1], y + weights[k] * corner[2], z + weights[k] * corner[3]
      end
    end
    if not place[key] then
      local scale = radius * a / n / math.sqrt(x * x + y * y + z * z)
      points[#points + 1] = { px + scale * x, py + scale * y, pz + scale * z, layer = a }
      place[key] = #points
    end
    return place[key]
  end

  -- tetrahedra: Kuhn's of the cubes in n >= a >= b >= c >= 0. With the corners in ascending order they fit together.
  local cells = {}
  for _, t in ipairs(triangles) do
    local sorted = { t[1], t[2], t[3] }
    table.sort(sorted)
    for a = 0, n - 1 do
      for b = 0, a do
        for c = 0, b do
          for _, axes in ipairs(KUHN) do
            local at, cell, inside = { a, b, c }, {}, true
            for k = 0, 3 do
              if k > 0 then at[axes[k]] = at[axes[k]] + 1 end
              inside = inside and at[1] >= at[2] and at[2] >= at[3]
              if inside then cell[k + 1] = point_at(sorted, at[1], at[2], at[3]) end
            end
            if inside then cells[#cells + 1] = cell end
          end
        end
      end
    end
  end

  -- by layer, so that the skin comes last
  local order, new = {}, {}
  for i = 1, #points do order[i] = i end
  table.sort(order, function(i, j)
    local a, b = points[i].layer or 0, points[j].layer or 0
    if a ~= b then return a < b end
    return i < j
  end)
  local placed = {}
  for i, old in ipairs(order) do new[old], placed[i] = i, { points[old][1], points[old][2], points[old][3] } end
  for _, cell in ipairs(cells) do
    for k = 1, 4 do cell[k] = new[cell[k]] end
    if build.volume(placed, cell) < 0 then cell[3], cell[4] = cell[4], cell[3] end
  end
  local tetrahedra = { points = placed, cells = cells }
  for key in pairs(COMMON) do tetrahedra[key] = options[key] end
  local out, springs, faces = build.tetrahedra(tetrahedra)
  return out, springs, faces, cells, #out - (10 * n * n + 2)
end

-- Signed volume of a tetrahedron {a, b, c, d} of point numbers, m3.
function build.volume(points, cell)
  local a, b, c, d = points[cell[1]], points[cell[2]], points[cell[3]], points[cell[4]]
  local ux, uy, uz = b[1] - a[1], b[2] - a[2], b[3] - a[3]
  local vx, vy, vz = c[1] - a[1], c[2] - a[2], c[3] - a[3]
  local wx, wy, wz = d[1] - a[1], d[2] - a[2], d[3] - a[3]
  return ((uy * vz - uz * vy) * wx + (uz * vx - ux * vz) * wy + (ux * vy - uy * vx) * wz) / 6
end

-- tetrahedra{ points = { {x,y,z}, ... }, cells = { {a, b, c, d}, ... } }
-- A net from a tetrahedral mesh: one spring per edge; faces are the triangles that belong to one cell only, turned
-- outwards. Points are copied.
function build.tetrahedra(options)
  check_options("tetrahedra", options, { points = true, cells = true })
  if type(options.points) ~= "table" or #options.points < 4 then
    error("tetrahedra.points: expected at least four {x, y, z}, got " .. describe(options.points), 2)
  end
  if type(options.cells) ~= "table" or #options.cells == 0 then
    error("tetrahedra.cells: expected a list of {a, b, c, d}, got " .. describe(options.cells), 2)
  end
  local points, springs = {}, {}
  for i, p in ipairs(options.points) do
    local x, y, z = vector("tetrahedra", "points[" .. i .. "]", p)
    points[i] = { x, y, z }
  end
  local join = joiner("tetrahedra", options, springs)
  local count, joined, uses, order = #points, {}, {}, {}

  local function add_edge(i, j)
    local key = pair_key(i, j, count)
    if joined[key] then return end
    joined[key] = true
    join(i, j)
  end
  local function add_face(a, b, c, opposite)
    local sorted = { a, b, c }
    table.sort(sorted)
    local key = sorted[1] .. " " .. sorted[2] .. " " .. sorted[3]
    if not uses[key] then
      uses[key] = { count = 0, face = { a, b, c }, opposite = opposite }
      order[#order + 1] = key
    end
    uses[key].count = uses[key].count + 1
  end

  for n, cell in ipairs(options.cells) do
    local t = list("tetrahedra", "cells[" .. n .. "]", cell, 4, 1, true)
    for k = 1, 4 do
      if t[k] > count then
        error(("tetrahedra.cells[%d][%d]: expected a point number from 1 to %d, got %d"):format(n, k, count, t[k]), 2)
      end
      for m = k + 1, 4 do
        if t[k] == t[m] then error(("tetrahedra.cells[%d]: expected four different points"):format(n), 2) end
      end
    end
    for k = 1, 3 do
      for m = k + 1, 4 do add_edge(t[k], t[m]) end
    end
    add_face(t[1], t[2], t[3], t[4])
    add_face(t[1], t[2], t[4], t[3])
    add_face(t[1], t[3], t[4], t[2])
    add_face(t[2], t[3], t[4], t[1])
  end

  local faces = {}
  for _, key in ipairs(order) do
    local use = uses[key]
    if use.count == 1 then
      local a, b, c, o = points[use.face[1]], points[use.face[2]], points[use.face[3]], points[use.opposite]
      local ux, uy, uz = b[1] - a[1], b[2] - a[2], b[3] - a[3]
      local vx, vy, vz = c[1] - a[1], c[2] - a[2], c[3] - a[3]
      local side = (uy * vz - uz * vy) * (o[1] - a[1]) + (uz * vx - ux * vz) * (o[2] - a[2])
        + (ux * vy - uy * vx) * (o[3] - a[3])
      faces[#faces + 1] = side < 0 and use.face or { use.face[1], use.face[3], use.face[2] }
    end
  end
  return points, springs, faces
end

return build
