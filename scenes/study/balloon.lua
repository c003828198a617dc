-- A closed sphere of cloth under pressure: its skin bears p R/2 in all directions (Laplace 1806). The tension T is that of
-- the growth e of its links, which as a lattice have Young's modulus `stretch` and Poisson's ratio 1/3.
local feder = require "feder"
local problem = require "feder.problem"

local solvers = feder.choices("cloth.solver")
local solver = feder.param("solver", solvers[1], { choices = solvers })
local level = feder.param("level", 3, { min = 1, max = 5, step = 1, help = "how often the triangles of an icosahedron are divided" })
local pressure = feder.param("pressure", 400, { min = 10, max = 1000, help = "inside over outside, Pa" })
local seconds = feder.param("t_end", 1, { min = 0.1, max = 60, help = "s" })
local iterations = feder.param("iterations", 0, { min = 0, max = 1000, step = 1, help = "in a substep; 0: the solver's own" })

local radius, stretch, area_density = 0.5, 3000, 0.15

-- T = 3/2 stretch e/(1 + e) = p R (1 + e)/2, by its fixed point
local growth = 0
for _ = 1, 100 do growth = pressure * radius * (1 + growth) ^ 2 / (3 * stretch) end

-- An icosahedron whose triangles are divided and drawn onto a sphere: nearly equal links, nearly equal angles.
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
        local volume = p[1] * (q[2] * r[3] - q[3] * r[2]) + p[2] * (q[3] * r[1] - q[1] * r[3]) + p[3] * (q[1] * r[2] - q[2] * r[1])
        triangles[#triangles + 1] = volume > 0 and { i, j, k } or { i, k, j }
      end
    end
  end
end
for _ = 1, level do
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

local function scaled(size)
  local list = {}
  for i, p in ipairs(points) do list[i] = { size * p[1], size * p[2], size * p[3] } end
  return list
end
local rest = scaled(radius * (1 + growth))

-- Area and volume of the mesh with its points one after the other in `x`.
local function area_and_volume(x)
  local area, volume = 0, 0
  for _, t in ipairs(triangles) do
    local p = {}
    for k = 1, 3 do p[k] = { x[3 * t[k] - 2], x[3 * t[k] - 1], x[3 * t[k]] } end
    local a, b = {}, {}
    for k = 1, 3 do a[k], b[k] = p[2][k] - p[1][k], p[3][k] - p[1][k] end
    local nx, ny, nz = a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1]
    area = area + math.sqrt(nx * nx + ny * ny + nz * nz) / 2
    volume = volume + (p[1][1] * nx + p[1][2] * ny + p[1][3] * nz) / 6
  end
  return area, volume
end

local flat = {}
for _, p in ipairs(scaled(radius)) do table.move(p, 1, 3, #flat + 1, flat) end
local area_at_rest = area_and_volume(flat)

local balloon, energy

local function own_substeps(options)
  options.substeps = nil
  return options
end

-- Tension over p R/2, of a radius of three volumes over the area, less 1.
local function tension_error()
  local area, volume = area_and_volume(balloon:positions())
  local e = math.sqrt(area / area_at_rest) - 1
  return math.abs(1.5 * stretch * e / (1 + e) / (pressure * 3 * volume / area / 2) - 1)
end

local study = problem.of_cloth(function() return balloon end, rest, function() return energy end, iterations, {
  scale = { length = radius, velocity = math.sqrt(stretch / area_density), energy = pressure * radius ^ 3 },
  certainty = { source = "Laplace's law and the growth of a lattice of equal links", uncertainty = 0.01 },
  ladders = problem.cloth_ladders(solvers, seconds, { 2, 4, 8, 16, 32 }),
})
study.error = tension_error
study.energy = nil

return feder.scene {
  title = "Balloon at rest",
  seconds = seconds,
  world = { gravity = { 0, 0, 0 }, dt = 1 / 60, substeps = 8, sleeping = false, air_density = 0 },
  study = study,

  build = function(world)
    balloon = world:cloth(own_substeps(problem.cloth(solver, iterations, { name = "balloon", vertices = scaled(radius), triangles = triangles,
      area_density = area_density, stretch = stretch, pressure = pressure })))
    problem.place(balloon, rest)
    energy = problem.energy(world)
  end,

  check = function(world, _, expect)
    expect(world:is_finite())
    expect.error(tension_error(), "<", 0.03, "tension over p R/2")
  end,
}
