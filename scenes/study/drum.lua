-- A square of cloth stretched in a frame swings as a membrane: w^2 = (T/m) (kx^2 + ky^2) (Rayleigh, The Theory of
-- Sound, art. 194), with the tension T that its stretch makes. Solver substeps are the cloth's own choice.
local feder = require "feder"
local problem = require "feder.problem"

local solvers = feder.choices("cloth.solver")
local solver = feder.param("solver", solvers[1], { choices = solvers })
local cells = feder.param("cells", 20, { min = 4, max = 100, step = 1, help = "along a side of 1 m" })
local strain = feder.param("strain", 0.02, { min = 1e-3, max = 0.03, help = "by which the frame is larger than the cloth" })
local p = feder.param("p", 1, { min = 1, max = 9, step = 1, help = "half waves along x" })
local q = feder.param("q", 1, { min = 1, max = 9, step = 1, help = "half waves along z" })
local quantity = problem.swing_quantity()
local seconds = feder.param("t_end", 0.5, { min = 0.1, max = 60, help = "s" })
local iterations = feder.param("iterations", 0, { min = 0, max = 1000, step = 1, help = "in a substep; 0: the solver's own" })

local stretch, shear, density = 2000, 200, 0.2  -- N/m, N/m, kg/m^2
local height = 0.002  -- m, of the swing

-- Rows and both diagonals of the cells as springs: rows give so much less that Young's modulus is `stretch`; by its size
-- at rest the frame has a side of 1 m and the cloth the density.
local rows = (stretch + math.sqrt(stretch ^ 2 + 4 * shear ^ 2)) / 2 - shear
local function wave(n) return 2 * cells * math.sin(math.pi * n / (2 * cells)) end
local straight = wave(p) ^ 2 + wave(q) ^ 2
-- a diagonal sees both waves: its second difference is that of a row, less the product of both
local slant = straight - wave(p) ^ 2 * wave(q) ^ 2 / (2 * cells ^ 2)
local frequency = math.sqrt(strain / (1 + strain) / density * (rows * straight + 2 * shear * slant))

local sheet, first, times, values

local function shape(i)
  local column, row = (i - 1) % (cells + 1), (i - 1) // (cells + 1)
  return math.sin(math.pi * p * column / cells) * math.sin(math.pi * q * row / cells)
end

local function swing()
  local x, sum = sheet:positions(), 0
  for i = 1, #x // 3 do sum = sum + x[3 * i - 1] * shape(i) end
  return sum * 4 / cells ^ 2
end

return feder.scene {
  title = "Drum",
  seconds = seconds,
  world = { gravity = { 0, 0, 0 }, dt = 1 / 60, sleeping = false },

  study = {
    observe = function() return swing() / height end,
    reference = function(t) return first / height * math.cos(frequency * t) end,
    error = function() return problem.swing_error(quantity, times, values, frequency) end,
    constraint = function() return math.max(0, sheet:stretch()) end,
    interpolate = false,
    scale = { length = 1, velocity = frequency },
    certainty = { source = "modes of a lattice of springs under tension, by the damped swing next to the run",
      uncertainty = (height * math.pi) ^ 2 / (8 * strain) },  -- of swings that are not small: they stretch it more
    ladders = problem.cloth_ladders(solvers, seconds, { 2, 4, 8, 16, 32 }),
    sweeps = math.max(1, iterations),
  },

  build = function(world)
    sheet = world:cloth { name = "drum", size = { 1, 1 }, resolution = { cells + 1, cells + 1 }, area_density = density,
      stretch = stretch, shear = shear, pins = { "top", "bottom", "left", "right" }, solver = solver,
      solver_options = iterations > 0 and { iterations = iterations } or nil }
    local x = sheet:positions()
    for i = 1, #x // 3 do
      sheet:set_point(i, (1 + strain) * x[3 * i - 2], height * shape(i), (1 + strain) * x[3 * i])
    end
    first = swing()
    times, values = { 0 }, { first }
  end,

  update = function(world) times[#times + 1], values[#values + 1] = world:time(), swing() end,

  check = function(world, _, expect)
    expect(world:is_finite())
    -- springs across two cells, which stand for bending in mass_spring, are stretched too
    expect.error(problem.swing_error("period", times, values, frequency), "<", solver == "mass_spring" and 0.03 or 0.02,
      "period")
  end,
}
