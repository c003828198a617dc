-- A block on a slope holds when mu >= tan(angle), else it slides with g (sin - mu cos) (Coulomb 1785).
local feder = require "feder"
local problem = require "feder.problem"

local degrees = feder.param("angle", 30, { min = 0, max = 80, help = "degrees" })
local mu = feder.param("mu", 0.3, { min = 0, max = 10, help = "friction" })
local seconds = feder.param("t_end", 1, { min = 1e-3, max = 100, help = "s" })

local g, angle = 9.81, degrees * math.pi / 180
local c, s = math.cos(angle), math.sin(angle)
local acceleration = math.max(0, g * (s - mu * c))

local block

local function course(t)
  local along, v = acceleration * t * t / 2, acceleration * t
  return { x = { 0.25 * s + along * c, 0.25 * c - along * s, 0 }, v = { v * c, -v * s, 0 } }
end

return feder.scene {
  title = "Block on a slope",
  seconds = seconds,
  picture = 0.5,
  world = { gravity = { 0, -g, 0 }, dt = 1 / 60, substeps = 4, sleeping = false },

  study = {
    reference = course,
    energy = function(t)
      local at = course(t)
      return (at.v[1] ^ 2 + at.v[2] ^ 2) / 2 + g * at.x[2]
    end,
    constraint = function(world) return math.max(0, world:max_penetration()) / 0.5 end,
    scale = {
      length = math.max(0.1, 0.5 * acceleration * seconds * seconds),
      velocity = math.max(0.1, acceleration * seconds),
      energy = g * math.max(0.1, 0.5 * acceleration * seconds * seconds),
    },
    certainty = { source = "g (sin - mu cos)" },
    axes = { dt = problem.steps(seconds, 60 * seconds, 6) },
  },

  build = function(world)
    world:body { type = "static", shape = feder.plane(s, c, 0, 0), friction = mu }
    block = world:body { name = "block", shape = feder.box(1, 0.5, 1), position = { 0.25 * s, 0.25 * c, 0 },
      rotation = { axis = { 0, 0, 1 }, angle = -angle }, mass = 1, friction = mu }
  end,

  check = function(world, _, expect)
    local x, y = block:position()
    local at = course(world:time()).x
    expect.error(math.sqrt((x - at[1]) ^ 2 + (y - at[2]) ^ 2), "<", 0.02, "place")
  end,
}
