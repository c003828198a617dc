-- Water swings in a U tube: w^2 = 2 g / L (Newton, Principia II, prop. 44), L the length of the tube along its middle;
-- in a bend of two dimensions the flow goes as 1 / r, and is as long as its angle times width / ln(outer / inner
-- radius).
local feder = require "feder"
local problem = require "feder.problem"

local p = problem.fluid(50, 4.2)
local quantity = problem.swing_quantity()

local g, inner, outer, arm = 9.81, 0.3, 0.5, 0.4  -- m, radii of the bend, and how far the arms are filled
local bore, rise = outer - inner, 4 * p.spacing
local long = 2 * arm + math.pi * bore / math.log(outer / inner)
local frequency = math.sqrt(2 * g / long)

local water, first, times, values

-- How far the right level is above rest, by `rise`: what rises there moves the centre of mass by a tube's width and the
-- gap.
local function swing()
  local x, sum = water:positions(), 0
  for i = 1, #x, 3 do sum = sum + x[i] end
  return sum * p.spacing ^ 2 / (bore * (inner + outer) * rise)
end

return feder.scene {
  title = "U tube",
  seconds = p.seconds,
  world = p.world,

  study = problem.of_fluid(p, function() return water end, {
    observe = swing,
    reference = function(t) return first * math.cos(frequency * t) end,
    error = function() return problem.swing_error(quantity, times, values, frequency) end,
    scale = { length = 1, velocity = frequency },
    certainty = { source = "w^2 = 2 g / L, by the damped swing next to the run", uncertainty = 1e-3,
      resolution = 0.5 * p.spacing / bore },
  }),

  build = function(world)
    -- the bend of the outer wall: planes that leave as much room as its half circle
    local parts = 12
    for i = 0, parts do
      local turn, half = math.pi * i / parts, math.pi / (2 * parts)
      local r = (i == 0 or i == parts) and outer or outer * math.sqrt(half / math.tan(half))
      world:body { type = "static", shape = feder.plane(math.cos(turn), math.sin(turn), 0, -r) }
    end
    world:body { type = "static", shape = feder.circle(inner) }
    world:body { type = "static", shape = feder.box(2 * inner, 4 * arm, 1), position = { 0, 2 * arm, 0 } }
    water = problem.water(world, p, { name = "water", artificial_viscosity = 0 })
    local points, rings = {}, math.floor(bore / p.spacing + 0.5)
    for j = 1, rings do
      local r = inner + (j - 0.5) * bore / rings
      local n = math.floor(math.pi * r / p.spacing + 0.5)
      for i = 1, n do
        local turn = math.pi * (i - 0.5) / n
        points[#points + 1] = { -r * math.cos(turn), -r * math.sin(turn), 0 }
      end
    end
    water:fill { points = points }
    problem.fill(water, bore, arm - rise, -outer, 0)
    problem.fill(water, bore, arm + rise, inner, 0)
    first = swing()
    times, values = { 0 }, { first }
  end,

  update = function(world) times[#times + 1], values[#values + 1] = world:time(), swing() end,

  check = function(world, _, expect)
    expect(world:is_finite())
    local x = water:positions()
    for i = 1, #x, 3 do
      local r = x[i + 1] > 0 and math.abs(x[i]) or math.sqrt(x[i] ^ 2 + x[i + 1] ^ 2)
      if r < inner or r > outer + 0.5 * p.spacing then expect(false, "water is out of the tube") end
    end
    local period, loss = problem.period_and_loss(times, values, frequency)
    expect.error(math.abs(period - 1), "<", 0.03, "period")
    expect.error(loss, "<", 0.27, "share of the height lost in a period")
  end,
}
