-- Boxes on each other, the last as heavy as wanted: they should stand still. Drift, energy and penetration are errors.
local feder = require "feder"
local problem = require "feder.problem"

local boxes = feder.param("boxes", 10, { min = 1, max = 40, step = 1, help = "of 1 m and 1 kg" })
local top_mass = feder.param("top_mass", 1, { min = 1e-3, max = 1e4, help = "of the last box, kg" })
local seconds = feder.param("t_end", 4, { min = 1e-3, max = 600, help = "s" })

local g = 9.81

local function mass(i) return i == boxes and top_mass or 1 end

local energy, rest, pile = 0, {}, {}
for i = 1, boxes do
  rest[i] = { 0, i - 0.5, 0 }
  energy = energy + g * (i - 0.5) * mass(i)
end

return feder.scene {
  title = "Stack",
  seconds = seconds,
  world = { gravity = { 0, -g, 0 }, dt = 1 / 60, substeps = 4, sleeping = false },

  study = {
    reference = function() return { x = rest, v = problem.zeros(3 * boxes) } end,
    energy = energy,
    constraint = function(world) return math.max(0, world:max_penetration()) end,
    scale = { length = 1, velocity = math.sqrt(g), energy = g * (boxes - 1 + top_mass) },
    certainty = { source = "at rest", uncertainty = 1e-16 },
    axes = { dt = problem.steps(seconds, 30 * seconds, 3) },
  },

  build = function(world)
    world:body { type = "static", shape = feder.plane(), friction = 0.6 }
    for i = 1, boxes do
      pile[i] = world:body { name = "box" .. i, shape = feder.box(1, 1, 1), position = rest[i], mass = mass(i),
        friction = 0.6 }
    end
  end,

  check = function(world, _, expect)
    for i, box in ipairs(pile) do
      local x, y, z = box:position()
      local drift = math.sqrt(x * x + (y - rest[i][2]) ^ 2 + z * z)
      expect.error(drift, "<", 0.01, "drift of box " .. i)
    end
    expect.error(world:max_penetration(), "<", 5e-3, "penetration")
  end,
}
