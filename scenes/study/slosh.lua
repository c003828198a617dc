-- The first standing wave of a tank: w^2 = g k tanh(k h), k = pi / L (Lamb, Hydrodynamics, art. 228). Without viscosity
-- it should keep its period and its height.
local feder = require "feder"
local problem = require "feder.problem"

local p = problem.fluid(40, 3.6)
-- Velocities leave the lattice of still water as it is; a raised wave is one only to the first order of its height, and
-- its lattice is sheared.
local start = feder.param("start", "velocity", { choices = { "velocity", "shape" },
  help = "still water that is given the velocities of the wave, or the raised wave at rest" })
local quantity = problem.swing_quantity()

local g, depth, k = 9.81, 0.5, math.pi
local height = 2 * p.spacing
local frequency = math.sqrt(g * k * math.tanh(k * depth))

-- What is not reached yet; the aim is 0.01 and 0.08.
local within = { period = { pbf = 0.011, wcsph = 0.02 }, loss = { pbf = 0.42, wcsph = 0.26 } }

local water, first, times, values

-- By its height: the integral of cos(k x) over the water is L / 2 times that of the wave, however high it is.
local function wave()
  local x, sum = water:positions(), 0
  for i = 1, #x, 3 do sum = sum + math.cos(k * x[i]) end
  return 2 * p.spacing ^ 2 * sum / height
end

-- Velocities by that of the surface at the crest.
local function flow(x, y)
  local scale = math.sinh(k * depth)
  return -math.sin(k * x) * math.cosh(k * y) / scale, math.cos(k * x) * math.sinh(k * y) / scale
end

-- Where a particle of the still water is in the raised wave: carried by the flow, which changes no volume.
local function raised(x, y)
  local h = height / 16
  for _ = 1, 16 do
    local u, v = flow(x, y)
    u, v = flow(x + u * h / 2, y + v * h / 2)
    x, y = x + u * h, y + v * h
  end
  return x, y
end

return feder.scene {
  title = "Slosh",
  seconds = p.seconds,
  world = p.world,

  study = problem.of_fluid(p, function() return water end, {
    observe = wave,
    reference = function(t)
      return first * math.cos(frequency * t) + (start == "velocity" and math.sin(frequency * t) or 0)
    end,
    error = function() return problem.swing_error(quantity, times, values, frequency) end,
    scale = { length = 1, velocity = frequency },
    certainty = { source = "w^2 = g k tanh(k h) of the first mode, by the damped swing next to the run",
      uncertainty = (height * k) ^ 2 / 8,  -- of waves that are not small (Stokes)
      resolution = 0.5 * p.spacing },
  }),

  build = function(world)
    problem.tank(world, 1)
    water = problem.water(world, p, { name = "water", artificial_viscosity = 0 })
    local columns, rows, points = math.floor(1 / p.spacing + 0.5), math.floor(depth / p.spacing + 0.5), {}
    for j = 1, rows do
      for i = 1, columns do
        local x, y = (i - 0.5) / columns, (j - 0.5) * depth / rows
        if start == "shape" then x, y = raised(x, y) end
        points[#points + 1] = { x, y, 0 }
      end
    end
    water:fill { points = points }
    if start == "velocity" then
      water:set_velocities(function(x, y)
        local u, v = flow(x, y)
        return height * frequency * u, height * frequency * v, 0
      end)
    end
    first = wave()
    times, values = { 0 }, { first }
  end,

  update = function(world) times[#times + 1], values[#values + 1] = world:time(), wave() end,

  check = function(world, _, expect)
    expect(world:is_finite())
    local period, loss = problem.period_and_loss(times, values, frequency)
    expect.error(math.abs(period - 1), "<", within.period[p.solver] or 0.01, "period")
    expect.error(loss, "<", within.loss[p.solver] or 0.08, "share of the height lost in a period")
  end,
}
