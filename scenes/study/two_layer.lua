-- The internal wave between two layers of fluid under a free surface: the slower root of
--   (r coth(k h) coth(k H) + s) w^4 - r (coth(k h) + coth(k H)) g k w^2 + (r - s) g^2 k^2 = 0,
-- r, h of the lower layer, s, H of the upper one, k = pi / L (Lamb, Hydrodynamics, art. 231). Without viscosity it should
-- keep its period and its height, and the layers should not mix.
local feder = require "feder"
local problem = require "feder.problem"

local p = problem.fluid(40, 5)
local ratio = feder.param("ratio", 2, { min = 1.25, max = 30, help = "density of the lower layer over that of the upper one" })
local quantity = problem.swing_quantity()

local g, depth, k = 9.81, 0.25, math.pi  -- depth of each layer
local height = 2 * p.spacing
local sinh, cosh = math.sinh(k * depth), math.cosh(k * depth)
local coth = cosh / sinh

local frequency
do
  local a, b, c = ratio * coth * coth + 1, 2 * ratio * coth * g * k, (ratio - 1) * g * g * k * k
  frequency = math.sqrt((b - math.sqrt(b * b - 4 * a * c)) / (2 * a))
end

-- Layers of ten spacings; dfsph loses .27 with the options as they are.
local within = { period = { pbf = 0.09, wcsph = 0.09 }, loss = { pbf = 0.9, wcsph = 0.95 } }

local heavy, light, first, times, values

-- By the height of the lower layer, as in slosh.lua.
local function wave()
  local x, sum = heavy:positions(), 0
  for i = 1, #x, 3 do sum = sum + math.cos(k * x[i]) end
  return 2 * p.spacing ^ 2 * sum / height
end

-- Velocities by that of the interface at the crest: in the upper layer such that its surface is free.
local function flow(x, y)
  if y < depth then return -math.sin(k * x) * math.cosh(k * y) / sinh, math.cos(k * x) * math.sinh(k * y) / sinh end
  local w2, up = frequency ^ 2, k * (y - depth)
  local share = (g * k * cosh - w2 * sinh) / (w2 * cosh - g * k * sinh)
  return -math.sin(k * x) * (share * math.cosh(up) + math.sinh(up)),
    math.cos(k * x) * (share * math.sinh(up) + math.cosh(up))
end

local function give_flow(fluid)
  fluid:set_velocities(function(x, y)
    local u, v = flow(x, y)
    return height * frequency * u, height * frequency * v, 0
  end)
end

return feder.scene {
  title = "Two layers",
  seconds = p.seconds,
  world = p.world,

  study = problem.of_fluid(p, function() return heavy end, {
    observe = wave,
    reference = function(t) return first * math.cos(frequency * t) + math.sin(frequency * t) end,
    error = function() return problem.swing_error(quantity, times, values, frequency) end,
    scale = { length = 1, velocity = frequency },
    certainty = { source = "Lamb's two layers, by the damped swing next to the run",
      uncertainty = (height * k) ^ 2 / 8,  -- of waves that are not small (Stokes)
      resolution = 0.5 * p.spacing },
  }),

  build = function(world)
    problem.tank(world, 1)
    heavy = problem.water(world, p, { name = "heavy", density = 1000 * ratio, artificial_viscosity = 0 })
    light = problem.water(world, p, { name = "light", artificial_viscosity = 0 })
    heavy:fill { box = { { 0, 0 }, { 1, depth } } }
    light:fill { box = { { 0, depth }, { 1, 2 * depth } } }
    give_flow(heavy)
    give_flow(light)
    first = wave()
    times, values = { 0 }, { first }
  end,

  update = function(world) times[#times + 1], values[#values + 1] = world:time(), wave() end,

  check = function(world, _, expect)
    expect(world:is_finite())
    local period, loss = problem.period_and_loss(times, values, frequency)
    expect.error(math.abs(period - 1), "<", within.period[p.solver] or 0.05, "period")
    expect.error(loss, "<", within.loss[p.solver] or 0.65, "share of the height lost in a period")
  end,
}
