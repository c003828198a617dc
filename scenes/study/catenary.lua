-- A strip of cloth hung at both ends, 1 m apart: equal links with equal masses hang in a polygon of constant horizontal
-- tension (Leibniz, Huygens and Johann Bernoulli 1691, of their limit).
local feder = require "feder"
local problem = require "feder.problem"

local solvers = feder.choices("cloth.solver")
local solver = feder.param("solver", solvers[1], { choices = solvers })
local links = feder.param("links", 40, { min = 4, max = 200, step = 2, help = "along the strip, an even number" })
local length = feder.param("length", 1.5, { min = 1.05, max = 10, help = "m, the ends are 1 m apart" })
local stiffness = feder.param("stiffness", 2000, { min = 1, max = 1e8, help = "N/m, stretch" })
local seconds = feder.param("t_end", 1, { min = 0.1, max = 60, help = "s" })
local iterations = feder.param("iterations", 0, { min = 0, max = 1000, step = 1, help = "in a substep; 0: the solver's own" })
assert(links % 2 == 0, "links: expected an even number, got " .. links)

local g, area_density = 9.81, 0.2
local link = length / links
local width = 2 * link
local weight, k = area_density * link * width * g, stiffness * width / link

-- Half the strip from its middle: link i carries the weight of i - 1/2 masses, as one hangs in the middle.
local function half(tension)
  local places, x, y = { { 0, 0 } }, 0, 0
  for i = 1, links // 2 do
    local down = (i - 0.5) * weight
    local pull = math.sqrt(tension * tension + down * down)
    local size = link + pull / k
    x, y = x + size * tension / pull, y + size * down / pull
    places[i + 1] = { x, y }
  end
  return places, x, y
end

local logarithm = problem.root(function(t)
  local _, x = half(math.exp(t))
  return x - 0.5
end, math.log(1e-9 * weight), math.log(1e9 * weight))
local places, _, depth = half(math.exp(logarithm))

local rest = {}
for j = -1, 1 do
  for i = 0, links do
    local side = i - links // 2
    local at = places[math.abs(side) + 1]
    rest[#rest + 1] = { side < 0 and -at[1] or at[1], at[2] - depth, j * link }
  end
end

local strip, energy

return feder.scene {
  title = "Catenary",
  seconds = seconds,
  world = { gravity = { 0, -g, 0 }, dt = 1 / 60, substeps = 16, sleeping = false },

  study = problem.of_cloth(function() return strip end, rest, function() return energy end, iterations, {
    scale = { length = depth, velocity = math.sqrt(depth * g), energy = area_density * length * width * g * depth },
    certainty = { source = "polygon of links with one horizontal tension", uncertainty = 1e-9, rounding = 10 },
    ladders = problem.cloth_ladders(solvers, seconds, { 2, 4, 8, 16, 32, 64, 128 }),
  }),

  build = function(world)
    strip = world:cloth(problem.cloth(solver, iterations, { name = "strip", size = { length, width },
      resolution = { links + 1, 3 }, area_density = area_density, stretch = stiffness, shear = 0, bend = 0,
      pins = { "left", "right" } }))
    problem.place(strip, rest)
    energy = problem.energy(world)
  end,

  check = function(_, _, expect)
    expect.error(problem.distance(strip, rest), "<", 0.01 * depth, "vertices")
  end,
}
