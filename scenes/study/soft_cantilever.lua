-- A beam clamped at one end swings down under its own weight and comes to rest. What its end drops by at rest is known of
-- thin beams (the elastica; Bisshopp and Drucker 1945 for its moments); shear of a thick one adds to it, cells that are few
-- across take from it. Runs are compared with the same mesh in many substeps.
local feder = require "feder"
local problem = require "feder.problem"

local solvers = feder.choices("soft.solver")
local solver = feder.param("solver", solvers[1], { choices = solvers })
local cells = feder.param("cells", 20, { min = 10, max = 100, step = 10, help = "along 1 m, a tenth of them across" })
local gamma = feder.param("gamma", 1, { min = 0.01, max = 100, help = "weight by bending stiffness, rho A g L^3/(E I)" })
local poisson = feder.param("poisson", 0.3, { min = 0, max = 0.49, help = "Poisson's ratio" })
local seconds = feder.param("t_end", 1, { min = 0.1, max = 60, help = "s" })
local iterations = feder.param("iterations", 0, { min = 0, max = 1000, step = 1, help = "in a substep; 0: the solver's own" })

local g, density, side = 9.81, 1000, 0.1
local young = 12 * density * g / (gamma * side ^ 2)

local beam, tip

-- Of the middle of the free end, m.
local function height()
  local x, sum = beam:points(), 0
  for _, i in ipairs(tip) do sum = sum + x[3 * i - 1] end
  return sum / #tip
end

return feder.scene {
  title = "Soft cantilever",
  seconds = seconds,
  world = { gravity = { 0, -g, 0 }, dt = 1 / 60, substeps = 8, sleeping = false },

  study = {
    observe = function() return { 0, height(), 0 } end,
    measure = height,
    reference = "self",
    refined_substeps = 64,
    error = function(_, refined) return math.abs(height() - refined[1]) end,
    constraint = function() return math.abs(beam:volume() / beam:rest_volume() - 1) end,
    interpolate = false,
    scale = { length = 1, velocity = math.sqrt(g) },
    certainty = { source = "height of the free end" },
    ladders = problem.soft_ladders(solvers, seconds, 60, { 2, 4, 8, 16, 32 }),
    sweeps = math.max(1, iterations),
  },

  build = function(world)
    beam = world:soft(problem.soft(solver, iterations, { name = "beam", shape = feder.box(1, side, side),
      resolution = cells, density = density, young = young, poisson = poisson, damping = 0.02 }))
    tip = {}
    for i = 1, beam:count() do
      local x = beam:rest_point(i)
      if x < -0.5 + 1e-4 then beam:pin(i) end
      if x > 0.5 - 1e-4 then tip[#tip + 1] = i end
    end
  end,

  check = function(world, _, expect)
    expect(world:is_finite())
    expect(beam:inverted() == 0)
    expect(height() < -0.05, "the beam does not bend")
  end,
}
