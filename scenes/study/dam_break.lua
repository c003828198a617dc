-- A square column of fluid collapses: its front runs along the floor as Martin and Moyce measured (Phil. Trans. R. Soc.
-- A 244, 1952).
local feder = require "feder"
local fluid = require "feder.fluid"
local problem = require "feder.problem"

local p = problem.fluid(20, 0.58)
local g = 9.81

local water, start, worst

-- Front by width at T = t sqrt(g/a) with the delay of their diaphragm; linear between what was measured.
local function measured(t)
  local from, table_ = { 0, 1 }, fluid.martin_moyce
  for k, to in ipairs(table_) do
    if to[1] >= t or k == #table_ then
      return from[2] + (t - from[1]) / (to[1] - from[1]) * (to[2] - from[2])
    end
    from = to
  end
end

local function scaled(t) return t * math.sqrt(g) + fluid.diaphragm_delay end

return feder.scene {
  title = "Dam break against measurement",
  seconds = p.seconds,
  world = p.world,

  study = problem.of_fluid(p, function() return water end, {
    observe = function() return fluid.front(water) / start end,
    reference = function(t) return t == 0 and 1 or measured(scaled(t)) end,
    error = function() return worst end,
    scale = { length = 1, velocity = math.sqrt(g) },
    certainty = { source = "front of a square column by its width, Martin & Moyce 1952, their diaphragm opening 0.124 of "
      .. "t sqrt(g/a) late; largest deviation relative to the front",
      kind = "published", uncertainty = 0.02,  -- two digitisations differ by that
      resolution = p.spacing },
  }),

  build = function(world)
    problem.tank(world)
    -- the Reynolds number of their 5.7 cm of water
    water = problem.water(world, p, { name = "water", viscosity = 0.073 })
    problem.fill(water, 1, 1, 0, 0)
    start, worst = fluid.front(water), 0
  end,

  update = function(world)
    local t = scaled(world:time())
    if t < fluid.martin_moyce[1][1] then return end
    worst = math.max(worst, math.abs(fluid.front(water) / start / measured(t) - 1))
  end,

  check = function(world, _, expect)
    expect(world:is_finite())
    expect.error(worst, "<", p.solver == "dfsph" and 0.09 or 0.08, "front")  -- at 20 to 120 particles
  end,
}
