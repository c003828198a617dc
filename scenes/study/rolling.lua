-- A ball thrown without spin slips, and rolls after 2 v/(7 mu g) with 5/7 of its speed (Euler 1760). The event is the
-- time when it rolls.
local feder = require "feder"
local problem = require "feder.problem"

local speed = feder.param("speed", 5, { min = 0.01, max = 1e3, help = "m/s at the start, without spin" })
local mu = feder.param("mu", 0.5, { min = 1e-3, max = 10, help = "friction" })
local radius = feder.param("radius", 0.5, { min = 1e-3, max = 100, help = "m" })

local g = 9.81
local deceleration = mu * g
local rolls = 2 * speed / (7 * deceleration)
local seconds = 3 * rolls

local ball, before, event

local function course(t)
  local s = math.min(t, rolls)
  local v = speed - deceleration * s
  return speed * s - 0.5 * deceleration * s * s + v * (t - s), v
end

return feder.scene {
  title = "Rolling ball",
  seconds = seconds,
  picture = 0.5,
  world = { gravity = { 0, -g, 0 }, dt = 1 / 60, substeps = 4, sleeping = false },

  study = {
    reference = function(t)
      local x, v = course(t)
      return { x = { x, radius, 0 }, v = { v, 0, 0 } }
    end,
    -- the rim runs with 5/2 mu g t while it slips
    energy = function(t)
      local _, v = course(t)
      local rim = 2.5 * deceleration * math.min(t, rolls)
      return 0.5 * v * v + 0.2 * rim * rim + g * radius
    end,
    event = function() return event end,
    constraint = function(world) return math.max(0, world:max_penetration()) / (2 * radius) end,
    scale = { length = speed * seconds, velocity = speed, energy = 0.5 * speed * speed },
    certainty = { source = "2 v/(7 mu g), then 5/7 v" },
    axes = { dt = problem.steps(seconds, 60 * seconds, 6) },
  },

  build = function(world)
    world:body { type = "static", shape = feder.plane(), friction = mu }
    ball = world:body { name = "ball", shape = feder.sphere(radius), position = { 0, radius, 0 },
      velocity = { speed, 0, 0 }, mass = 1, friction = mu }
    before, event = { t = 0, slip = speed }, nil
  end,

  update = function(world)
    local v, _, _ = ball:velocity()
    local _, _, w = ball:angular_velocity()
    local slip = v + radius * w
    if not event and math.abs(slip) <= 1e-3 * speed then
      event = math.abs(before.t + before.slip / (3.5 * deceleration) - rolls)
    end
    before = { t = world:time(), slip = slip }
  end,

  check = function(world, _, expect)
    local x = ball:position()
    local v = ball:velocity()
    local at, fast = course(world:time())
    expect.error(math.abs(x - at), "<", 0.02 * speed * seconds, "place")
    expect.error(math.abs(v - fast), "<", 0.01 * speed, "speed")
    expect.error(event or 1, "<", 0.1 * rolls, "time when it rolls")
  end,
}
