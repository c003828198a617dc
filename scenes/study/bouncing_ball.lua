-- A ball dropped with restitution e: with t1 the first impact, impact n is at t1 (1 + 2 e (1 - e^(n-1))/(1 - e)), an
-- infinity of them before t1 (1 + e)/(1 - e), then rest (Newton's law of impact, 1687). The event is the time of the
-- first three impacts.
local feder = require "feder"
local problem = require "feder.problem"

local g, radius = 9.81, 0.1

local e = feder.param("e", 0.5, { min = 0, max = 1, help = "restitution" })
local drop = feder.param("drop", 1, { min = 1e-3, max = 1e3, help = "height of the fall, m" })
local first = math.sqrt(2 * drop / g)
local seconds = feder.param("t_end", math.ceil(2 * first), { min = 1e-3, max = 100, help = "s" })

local ball, before, impacts, event

-- Height of the centre and velocity. Flights below a nanometre count as rest.
local function course(t)
  if t < first then return radius + drop - 0.5 * g * t * t, -g * t end
  local impact, up = first, e * g * first  -- of the flight: when it began, speed then
  while up * up > 2e-9 * g and t > impact + 2 * up / g do impact, up = impact + 2 * up / g, up * e end
  if up * up <= 2e-9 * g then return radius, 0 end
  local s = t - impact
  return radius + up * s - 0.5 * g * s * s, up - g * s
end

return feder.scene {
  title = "Bouncing ball",
  seconds = seconds,
  picture = 1,
  world = { gravity = { 0, -g, 0 }, dt = 1 / 60, substeps = 4, sleeping = false },

  study = {
    reference = function(t)
      local y, v = course(t)
      return { x = { 0, y, 0 }, v = { 0, v, 0 } }
    end,
    energy = function(t)
      local y, v = course(t)
      return v * v / 2 + g * y
    end,
    event = function() return event end,
    constraint = function(world) return math.max(0, world:max_penetration()) / (2 * radius) end,
    scale = { length = drop, velocity = g * first, energy = g * drop },
    certainty = { source = "sum of the flights" },
    axes = { dt = problem.steps(seconds, 60 * seconds, 6) },
  },

  build = function(world)
    world:body { type = "static", shape = feder.plane(), friction = 0 }
    ball = world:body { name = "ball", shape = feder.sphere(radius), position = { 0, drop + radius, 0 }, mass = 1,
      friction = 0, restitution = e }
    before, impacts, event = { t = 0, y = drop + radius, v = 0 }, 0, nil
  end,

  -- an impact is at the end of the fall from the state before the step
  update = function(world)
    local _, y = ball:position()
    local _, v = ball:velocity()
    local was = before
    before = { t = world:time(), y = y, v = v }
    if impacts >= 3 or not (was.v < 0) or v - was.v < -0.5 * was.v then return end
    local hit = was.t + (was.v + math.sqrt(was.v * was.v + 2 * g * math.max(0, was.y - radius))) / g
    local exact = first * (1 + 2 * (e < 1 and e * (1 - e ^ impacts) / (1 - e) or impacts))
    event = math.max(event or 0, math.abs(hit - exact))
    impacts = e > 0 and impacts + 1 or 3
  end,

  check = function(world, _, expect)
    local _, y = ball:position()
    expect.error(math.abs(y - course(world:time())), "<", 0.02 * drop, "height")
    expect(event, "the ball does not meet the floor")
    expect.error(event or 1, "<", world:dt(), "time of the impacts")
  end,
}
