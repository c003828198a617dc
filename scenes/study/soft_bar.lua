-- A free bar of rubber rings along: its first mode, of which the middle stands still, has the frequency sqrt(E/rho)/(2 L)
-- where Poisson's ratio is 0 (Rayleigh, The Theory of Sound, art. 150). Backward Euler damps it by h w^2/2.
local feder = require "feder"
local problem = require "feder.problem"

local solvers = feder.choices("soft.solver")
local solver = feder.param("solver", solvers[1], { choices = solvers })
local cells = feder.param("cells", 20, { min = 10, max = 100, step = 10, help = "along 1 m, a tenth of them across" })
local young = feder.param("young", 1e5, { min = 1e2, max = 1e9, help = "Pa" })
local quantity = problem.swing_quantity()
local seconds = feder.param("t_end", 0.5, { min = 0.1, max = 60, help = "s" })
local iterations = feder.param("iterations", 0, { min = 0, max = 1000, step = 1, help = "in a substep; 0: the solver's own" })

local density, height = 1000, 0.002  -- kg/m^3; m, of the swing of either end
local frequency = math.pi * math.sqrt(young / density)

local bar, places, first, times, values

-- The share of the mode in what points have moved.
local function swing()
  local x, sum, square = bar:points(), 0, 0
  for i, at in ipairs(places) do
    local shape = math.sin(math.pi * at)
    sum, square = sum + (x[3 * i - 2] - at) * shape, square + shape * shape
  end
  return sum / square
end

return feder.scene {
  title = "Ringing bar",
  seconds = seconds,
  world = { gravity = { 0, 0, 0 }, dt = 1 / 240, substeps = 8, sleeping = false },

  study = {
    observe = function() return swing() / height end,
    reference = function(t) return first / height * math.cos(frequency * t) end,
    error = function() return problem.swing_error(quantity, times, values, frequency) end,
    constraint = function() return math.abs(bar:volume() / bar:rest_volume() - 1) end,
    interpolate = false,
    scale = { length = 1, velocity = frequency },
    certainty = { source = "waves along a thin bar, by the damped swing next to the run",
      uncertainty = math.pi * height,  -- of swings that are not small
      resolution = (math.pi / cells) ^ 2 / 4 },  -- of waves on cells
    ladders = problem.soft_ladders(solvers, seconds, 240, { 1, 2, 4, 8, 16 }),
    sweeps = math.max(1, iterations),
  },

  build = function(world)
    bar = world:soft(problem.soft(solver, iterations, { name = "bar", shape = feder.box(1, 0.1, 0.1), resolution = cells,
      density = density, young = young, poisson = 0, damping = 0 }))
    places = {}
    for i = 1, bar:count() do
      local x, y, z = bar:rest_point(i)
      places[i] = x
      bar:set_point(i, x + height * math.sin(math.pi * x), y, z)
    end
    first = swing()
    times, values = { 0 }, { first }
  end,

  update = function(world) times[#times + 1], values[#values + 1] = world:time(), swing() end,

  check = function(world, _, expect)
    expect(world:is_finite())
    expect(bar:inverted() == 0)
    expect.error(problem.swing_error("period", times, values, frequency), "<", 0.02, "period")
  end,
}
