-- A clamped strip of cloth bends under its own weight: the moment at each vertex bends its hinge, the elastica in
-- segments (Romero et al., Physical Validation of Simulators in Computer Graphics, 2021).
local feder = require "feder"
local problem = require "feder.problem"

local solvers = feder.choices("cloth.solver")
local solver = feder.param("solver", solvers[1], { choices = solvers })
local segments = feder.param("segments", 20, { min = 4, max = 100, step = 1, help = "of 1 m together" })
local gamma = feder.param("gamma", 10,
  { min = 0.01, max = 100, help = "weight by bending stiffness, area_density g L^3/bend" })
local seconds = feder.param("t_end", 1, { min = 0.1, max = 60, help = "s" })
local iterations = feder.param("iterations", 0, { min = 0, max = 1000, step = 1, help = "in a substep; 0: the solver's own" })

local g, density = 9.81, 1
local link = 1 / segments
local width = 2 * link
local weight = density * link * width * g
local hinge = density * g / gamma * width / link  -- N m per rad

-- Angles of the segments, from that of the free end to the clamp. `below`: weight beyond the vertex; the last is half.
local function shoot(tip)
  local angles, moment, below, angle = {}, 0, 0.5 * weight, tip
  for i = segments, 1, -1 do
    angles[i] = angle
    moment, below = moment + below * link * math.cos(angle), below + weight
    angle = angle - moment / (i > 1 and hinge or 2 * hinge)
  end
  return angle, angles  -- the slope behind the clamp is 0
end

local _, angles = shoot(problem.root(shoot, 0, math.pi / 2))

local rest = {}
for j = -1, 1 do
  local x, y = 0, 0
  for i = 1, segments + 1 do
    rest[#rest + 1] = { x, y, j * link }
    if i <= segments then x, y = x + link * math.cos(angles[i]), y - link * math.sin(angles[i]) end
  end
end

local strip, energy

return feder.scene {
  title = "Cantilever",
  seconds = seconds,
  world = { gravity = { 0, -g, 0 }, dt = 1 / 60, substeps = 32, sleeping = false },

  study = problem.of_cloth(function() return strip end, rest, function() return energy end, iterations, {
    scale = { length = 1, velocity = math.sqrt(g), energy = density * width * g },
    -- stretch is not in it
    certainty = { source = "moments at the vertices, inextensible", uncertainty = 1e-4, rounding = 10 },
    ladders = problem.cloth_ladders(solvers, seconds, { 4, 8, 16, 32, 64, 128, 256 }),
  }),

  build = function(world)
    strip = world:cloth(problem.cloth(solver, iterations, { name = "strip", size = { 1, width },
      resolution = { segments + 1, 3 }, position = { 0.5, 0, 0 }, area_density = density, stretch = 1e5,
      bend = density * g / gamma, pins = "left_clamped" }))
    problem.place(strip, rest)
    energy = problem.energy(world)
  end,

  check = function(_, _, expect)
    if solver == "mass_spring" then return end  -- its springs across hinges do not bend like a plate
    expect.error(problem.distance(strip, rest), "<", 0.05, "vertices")
  end,
}
