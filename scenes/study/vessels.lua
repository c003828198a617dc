-- Communicating vessels: water in a wide and a narrow one comes to the same level (Stevin 1586).
local feder = require "feder"
local problem = require "feder.problem"

local p = problem.fluid(40, 4)

local g, wide, narrow, wall, channel = 9.81, 0.4, 0.15, 0.1, 0.15  -- m
local length, start = wide + wall + narrow, { 0.8, 0.4 }

local water, first, level, sums, count

-- Levels by the surface, means over the samples of a vessel.
local function height(from, to)
  local sum, n = 0, 0
  for k = 0, 7 do
    local y = water:height_at(from + (to - from) * (k + 0.5) / 8, 0)
    if y then sum, n = sum + y, n + 1 end
  end
  return n > 0 and sum / n or 0
end

local function error_now()
  if count == 0 then return 1 end
  return math.max(math.abs(sums[1] / count - level), math.abs(sums[2] / count - level))
end

return feder.scene {
  title = "Communicating vessels",
  seconds = p.seconds,
  world = p.world,

  study = problem.of_fluid(p, function() return water end, {
    -- the way to the end is not known: the reference is where it starts, by whatever kernel it is measured
    observe = function()
      return { start[1] + height(0, wide) - first[1], start[2] + height(length - narrow, length) - first[2], 0 }
    end,
    reference = function() return { start[1], start[2], 0 } end,
    error = error_now,
    scale = { length = 1, velocity = math.sqrt(g) },
    certainty = { source = "the level of the volume in both vessels, the larger deviation, m", uncertainty = 1e-6,
      resolution = 0.5 * p.spacing },
  }),

  build = function(world)
    problem.tank(world, length)
    world:body { type = "static", shape = feder.box(wall, 2, 1), position = { wide + wall / 2, channel + 1, 0 } }
    water = problem.water(world, p, { name = "water", viscosity = 5 })
    problem.fill(water, length, channel, 0, 0)
    problem.fill(water, wide, start[1] - channel, 0, channel)
    problem.fill(water, narrow, start[2] - channel, length - narrow, channel)
    first = { height(0, wide), height(length - narrow, length) }
    level = (water:count() * p.spacing ^ 2 - wall * channel) / (wide + narrow)
    sums, count = { 0, 0 }, 0
  end,

  -- the mean over the last quarter
  update = function(world)
    if world:time() < 0.75 * p.seconds then return end
    sums[1], sums[2], count = sums[1] + height(0, wide), sums[2] + height(length - narrow, length), count + 1
  end,

  check = function(_, _, expect)
    expect.error(math.abs(sums[1] - sums[2]) / count, "<", 0.5 * p.spacing, "between the levels, m")
    -- the aim is half a spacing
    expect.error(error_now(), "<", (p.solver == "dfsph" and 0.5 or 1) * p.spacing, "from the level of the volume, m")
  end,
}
