-- A closed sphere of cloth under pressure: its skin bears p R/2 in all directions (Laplace 1806). The tension T is that of
-- the growth e of its links, which as a lattice have Young's modulus `stretch` and Poisson's ratio 1/3.
local feder = require "feder"
local cloth = require "feder.cloth"
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

local function scaled(size) return (cloth.sphere(size, level, 20)) end
local _, triangles = cloth.sphere(radius, level, 20)
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
