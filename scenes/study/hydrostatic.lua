-- A column of fluid at rest: its pressure is rho g (H - y) in all depths (Stevin 1586).
local feder = require "feder"
local problem = require "feder.problem"

local p = problem.fluid(16, 2)
local g, width, depths = 9.81, 0.5, { 0.2, 0.4, 0.6, 0.8 }

local water, sum, count

-- Root mean square over the depths, by rho g H, of the mean over the last quarter: waves go to and fro.
local function error_now()
  local squares = 0
  for k, y in ipairs(depths) do squares = squares + (sum[k] / count / (1000 * g) - (1 - y)) ^ 2 end
  return math.sqrt(squares / #depths)
end

return feder.scene {
  title = "Hydrostatic column",
  seconds = p.seconds,
  world = p.world,

  study = problem.of_fluid(p, function() return water end, {
    -- the centre of mass
    observe = function()
      local at, x, y = water:positions(), 0, 0
      for i = 1, #at, 3 do x, y = x + at[i], y + at[i + 1] end
      return { 3 * x / #at, 3 * y / #at, 0 }
    end,
    reference = function() return { width / 2, 0.5, 0 } end,
    error = error_now,
    scale = { length = 1, velocity = math.sqrt(g) },
    certainty = { source = "pressure rho g (H - y), rms over four depths by rho g H", uncertainty = 1e-6,
      resolution = 0.5 * p.spacing },
  }),

  build = function(world)
    problem.tank(world, width)
    water = problem.water(world, p, { name = "water" })
    problem.fill(water, width, 1, 0, 0)
    sum, count = { 0, 0, 0, 0 }, 0
  end,

  update = function(world)
    if world:time() < 0.75 * p.seconds then return end
    for k, y in ipairs(depths) do sum[k] = sum[k] + water:pressure_at(width / 2, y, 0) end
    count = count + 1
  end,

  check = function(_, _, expect)
    expect.error(error_now(), "<", 0.05, "pressure")
  end,
}
