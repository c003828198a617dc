-- A siphon that swings: a tube leads over a rim, which is above the water in the two vessels that it joins, as wide as it.
-- The difference of their levels goes as cos(w t), w^2 = 2 g / L as in a U tube (Newton, Principia II, prop. 44), as long
-- as the water bears suction; where it tears it falls back to both sides. L is that of potential flow.
local feder = require "feder"
local problem = require "feder.problem"

local p = problem.fluid(60, 4, { "dfsph" })  -- others bear no suction
local quantity = problem.swing_quantity()

-- From the middle of a bend to its post and to its walls, which are square; what it counts as in L (finite volumes), m.
local g, inner, outer, bent = 9.81, 0.15, 0.35, 0.6827
local arm, rim, rise, lid = 0.25, 0.4, 0.075, 0.05  -- m: levels and rim above the lower bends; how far levels are off
local bore, pitch = outer - inner, outer + inner
local frequency = math.sqrt(2 * g / (2 * (arm + rim) + 3 * bent))

local water, first, times, values, least

-- How far the right level is above rest, by `rise`: what rises there came from the left, three pitches away.
local function swing()
  local x, sum = water:positions(), 0
  for i = 1, #x, 3 do sum = sum + x[i] end
  return sum * p.spacing ^ 2 / (3 * pitch * bore * rise)
end

-- The water of a bend, above y or below it: rings about the post, and what is left in the corners. Where particles lack,
-- suction begins to tear it.
local function fill_bend(x, y, side)
  local points, d = {}, p.spacing
  for j = 1, math.floor(bore / d + 0.5) do
    local r = inner + (j - 0.5) * d
    local n = math.floor(math.pi * r / d + 0.5)
    for i = 1, n do
      local turn = math.pi * (i - 0.5) / n
      points[#points + 1] = { x + r * math.cos(turn), y + side * r * math.sin(turn), 0 }
    end
  end
  local n = math.floor(outer / d + 0.5)
  for k = 0, n * n - 1 do
    local dx, dy = outer - (k % n + 0.5) * d, outer - (k // n + 0.5) * d
    if dx * dx + dy * dy > outer * outer then
      points[#points + 1], points[#points + 2] = { x + dx, y + side * dy, 0 }, { x - dx, y + side * dy, 0 }
    end
  end
  water:fill { points = points }
end

return feder.scene {
  title = "Swinging siphon",
  seconds = p.seconds,
  world = p.world,

  study = problem.of_fluid(p, function() return water end, {
    observe = swing,
    reference = function(t) return first * math.cos(frequency * t) end,
    error = function() return problem.swing_error(quantity, times, values, frequency) end,
    scale = { length = 1, velocity = frequency },
    certainty = { source = "w^2 = 2 g / L of potential flow, by the damped swing next to the run",
      uncertainty = 2e-3,  -- a quarter of the height lost in a period: (0.29 / 2 pi)^2 / 2
      resolution = 0.5 * p.spacing / bore },
  }),

  build = function(world)
    local function post(x, low, high)  -- round at its ends
      world:body { type = "static", shape = feder.capsule(inner, high - low), position = { x, (high + low) / 2, 0 } }
    end
    world:body { type = "static", shape = feder.plane(0, 1, 0, -outer) }
    world:body { type = "static", shape = feder.box(2 * outer, lid, 1), position = { 0, rim + outer + lid / 2, 0 } }
    post(0, -pitch, rim + inner)
    water = problem.water(world, p, { name = "water", artificial_viscosity = 0, negative_pressure = 1 })
    fill_bend(0, rim, 1)
    for _, side in ipairs { -1, 1 } do
      post(side * pitch, -inner, rim + pitch + outer)
      world:body { type = "static", shape = feder.plane(-side, 0, 0, -pitch - outer) }
      fill_bend(side * pitch, 0, -1)
      problem.fill(water, bore, rim, side * pitch / 2 - bore / 2, 0)
      problem.fill(water, bore, arm + side * rise, side * 1.5 * pitch - bore / 2, 0)
    end
    first = swing()
    times, values, least = { 0 }, { first }, 0
  end,

  update = function(world)
    times[#times + 1], values[#values + 1] = world:time(), swing()
    least = math.min(least, water:pressure_at(0, rim + pitch / 2, 0))
  end,

  check = function(world, _, expect)
    expect(world:is_finite())
    expect(least < -1000 * g * (rim + inner - arm), "over the rim the water bears no suction")
    local period, loss = problem.period_and_loss(times, values, frequency)
    expect.error(math.abs(period - 1), "<", 0.03, "period")
    expect.error(loss, "<", 0.4, "share of the height lost in a period")
  end,
}
