-- A rope round a post that turns slips on it: friction along an angle phi multiplies the tension by e^(mu phi)
-- (Euler 1769, Eytelwein 1808). One end is held, a weight hangs from the other; `way` 1 turns the post towards the weight,
-- so that the held end bears e^(mu phi) times as much, -1 away from it, so that it bears that much less.
local feder = require "feder"
local problem = require "feder.problem"

local turn = feder.param("angle", 1, { min = 0.5, max = 3, help = "phi, by which it is wrapped, in half turns" })
local mu = feder.param("mu", 0.3, { min = 0.05, max = 0.5, help = "coefficient of friction" })
local way = feder.param("way", 1, { choices = { 1, -1 }, help = "1: towards the weight, -1: away from it" })
local segments = feder.param("segments", 24, { min = 4, max = 200, step = 1, help = "in half a turn" })
local seconds = feder.param("t_end", 2, { min = 0.5, max = 60, help = "s" })

local radius, post, free, g = 0.01, 0.06, 0.3, 9.81
local phi = math.pi * turn
local ratio = math.exp(way * mu * phi)
local mass = 500 / g / math.max(1, ratio)  -- kg: 500 N, 1 % of its stretch, is the most that the rope bears

local rope, first, samples

return feder.scene {
  title = "Capstan",
  seconds = seconds,
  world = { gravity = { 0, -g, 0 }, dt = 1 / 60, sleeping = false, air_density = 0 },

  study = {
    observe = function()
      local _, y = rope:point((rope:count()))
      return y - first
    end,
    reference = function() return { 0 } end,
    error = function()
      local sum = 0
      for _, tension in ipairs(samples) do sum = sum + tension end
      return math.abs(sum / #samples / (mass * g * ratio) - 1)
    end,
    interpolate = false,
    scale = { length = free, velocity = math.sqrt(g * free) },
    certainty = { source = "limit of a rope without thickness or weight", uncertainty = (math.pi / segments) ^ 2 / 12 },
    ladders = { { dt = problem.steps(seconds, 30 * seconds, 3) }, { substeps = { 1, 2, 4, 8 } },
      { segments = { 6, 12, 24, 48 } } },
  },

  build = function(world, scene)
    world:body { name = "post", type = "kinematic", shape = feder.cylinder(post, 1), rotation = { axis = { 1, 0, 0 },
      angle = feder.deg(90) }, angular_velocity = { 0, 0, -2 * way }, friction = mu }
    -- from the held end against the clock over the post, and straight down at its right side
    local path, points = post + radius, {}
    local n = math.ceil(segments * turn)
    local step = path * phi / n
    local straight = math.ceil(free / step)
    local function add(x, y) points[#points + 1] = { x, y, 0 } end
    for i = straight, 1, -1 do add(path * math.cos(phi) - i * step * math.sin(phi), path * math.sin(phi) + i * step * math.cos(phi)) end
    for i = 0, n do add(path * math.cos(phi - phi * i / n), path * math.sin(phi - phi * i / n)) end
    for i = 1, straight do add(path, -i * step) end
    rope = world:rope { name = "rope", points = points, radius = radius, friction = mu, pins = { "first" }, gravity_scale = 0,
      self_collision = false }  -- in one plane, where more than a turn passes through itself
    local size = 0.1
    local weight = world:body { name = "weight", shape = feder.box(size, size, size), mass = mass, mask = 0,
      position = { path, -straight * step - size / 2, 0 } }
    rope:attach(#points, weight, 0, size / 2, 0)
    first = points[#points][2]
    samples = {}
    scene.ratio = ratio
  end,

  update = function(world) if world:time() > seconds / 2 then samples[#samples + 1] = rope:tension(1) end end,

  check = function(world, _, expect)
    expect(world:is_finite())
    local sum = 0
    for _, tension in ipairs(samples) do sum = sum + tension end
    expect.error(math.abs(sum / #samples / (mass * g * ratio) - 1), "<", 0.03, "ratio of the tensions")
  end,
}
