-- A block thrown over the floor stops after v/(mu g) (Coulomb 1785). The event is the time of its stop.
local feder = require "feder"
local problem = require "feder.problem"

local speed = feder.param("speed", 5, { min = 0.01, max = 1e3, help = "m/s at the start" })
local mu = feder.param("mu", 0.5, { min = 1e-3, max = 10, help = "friction" })

local g = 9.81
local deceleration = mu * g
local stop = speed / deceleration
local seconds = 1.25 * stop

local block, before, event

local function course(t)
  local s = math.min(t, stop)
  return speed * s - 0.5 * deceleration * s * s, speed - deceleration * s
end

return feder.scene {
  title = "Slide to rest",
  seconds = seconds,
  picture = 0.5,
  world = { gravity = { 0, -g, 0 }, dt = 1 / 60, substeps = 4, sleeping = false },

  study = {
    reference = function(t)
      local x, v = course(t)
      return { x = { x, 0.25, 0 }, v = { v, 0, 0 } }
    end,
    energy = function(t)
      local _, v = course(t)
      return v * v / 2 + g * 0.25
    end,
    event = function() return event end,
    constraint = function(world) return math.max(0, world:max_penetration()) / 0.5 end,
    scale = { length = 0.5 * speed * stop, velocity = speed, energy = 0.5 * speed * speed },
    certainty = { source = "v/(mu g)" },
    axes = { dt = problem.steps(seconds, 60 * seconds, 6) },
  },

  build = function(world)
    world:body { type = "static", shape = feder.plane(), friction = mu }
    block = world:body { name = "block", shape = feder.box(1, 0.5, 1), position = { 0, 0.25, 0 },
      velocity = { speed, 0, 0 }, mass = 1, friction = mu }
    before, event = { t = 0, v = speed }, nil
  end,

  update = function(world)
    local v = block:velocity()
    if not event and math.abs(v) <= 1e-3 * speed then
      event = math.abs(before.t + before.v / deceleration - stop)
    end
    before = { t = world:time(), v = v }
  end,

  check = function(world, _, expect)
    local x = block:position()
    expect.error(math.abs(x - course(world:time())), "<", 0.01 * speed * stop, "place")
    expect.error(event or 1, "<", 0.02 * stop, "time of the stop")
  end,
}
