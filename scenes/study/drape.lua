-- A square sheet falls on a ball and drapes over it. No closed form: folds buckle, and have many equilibria, so only the
-- height of the sheet's middle is compared (as good as its potential energy), against the same run with many substeps.
local feder = require "feder"
local problem = require "feder.problem"

local solvers = feder.choices("cloth.solver")
local solver = feder.param("solver", solvers[1], { choices = solvers })
local cells = feder.param("cells", 12, { min = 4, max = 60, step = 1, help = "along a side of 1 m" })
local stiffness = feder.param("stiffness", 1000, { min = 1, max = 1e6, help = "N/m, stretch; shear is a tenth of it" })
local bend = feder.param("bend", 0, { min = 0, max = 1, help = "N m; solvers differ in what they make of it" })
local friction = feder.param("friction", 0.5, { min = 0, max = 2, help = "of the sheet on the ball" })
local seconds = feder.param("t_end", 2, { min = 0.5, max = 60, help = "s" })
local iterations = feder.param("iterations", 0, { min = 0, max = 1000, step = 1, help = "in a substep; 0: the solver's own" })

local g, side, radius = 9.81, 1, 0.25  -- m

local sheet, heights

local function height()
  local x, sum = sheet:positions(), 0
  for i = 2, #x, 3 do sum = sum + x[i] end
  return sum / (#x // 3)
end

-- Mean over the last quarter: it swings.
local function late()
  local first, sum = #heights * 3 // 4, 0
  for k = first + 1, #heights do sum = sum + heights[k] end
  return sum / (#heights - first)
end

return feder.scene {
  title = "Drape",
  seconds = seconds,
  world = { gravity = { 0, -g, 0 }, dt = 1 / 60, substeps = 8, sleeping = false },

  study = {
    observe = function() return { 0, height(), 0 } end,
    measure = late,
    reference = "self",
    refined_substeps = 128,
    error = function(_, refined) return math.abs(late() - refined[1]) / side end,
    constraint = function() return math.max(0, sheet:stretch()) end,
    interpolate = false,
    scale = { length = side, velocity = math.sqrt(g * side) },
    certainty = { source = "mean height over the last quarter, by the side" },
    ladders = problem.cloth_ladders(solvers, seconds, { 2, 4, 8, 16, 32 }),
    sweeps = math.max(1, iterations),
  },

  build = function(world)
    world:body { type = "static", shape = feder.sphere(radius), friction = friction }
    sheet = world:cloth(problem.cloth(solver, iterations, { name = "sheet", size = { side, side },
      resolution = { cells + 1, cells + 1 }, position = { 0, radius + 0.05, 0 }, stretch = stiffness, bend = bend,
      friction = friction }))
    heights = {}
  end,

  update = function() heights[#heights + 1] = height() end,

  check = function(world, _, expect)
    expect(world:is_finite())
    local y = late()
    expect(y < 0.2 and y > -0.2, ("the middle of the sheet hangs at %.3f m"):format(y))
    local x = sheet:positions()
    local inside = 0
    for i = 1, #x, 3 do
      inside = math.max(inside, radius - math.sqrt(x[i] ^ 2 + x[i + 1] ^ 2 + x[i + 2] ^ 2))
    end
    expect.error(inside, "<", 0.005, "vertices in the ball")
  end,
}
