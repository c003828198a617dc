-- A beam floats with rho_body / rho of its height under water (Archimedes, On Floating Bodies, 3rd century BC).
local feder = require "feder"
local problem = require "feder.problem"

local p = problem.fluid(16, 3)
local share = feder.param("density_ratio", 0.5,
  { min = 1e-2, max = 1e2, help = "of the beam to the fluid; from 1 on it sinks to the ground" })

local g, tank, level, wide, high = 9.81, 2, 0.625, 0.75, 0.5  -- m
-- it starts in a hollow of three quarters of its draught
local under = level - 0.75 * math.min(share, 1) * high

local water, beam, sum, count

local function error_now()
  return math.abs(sum / count - (share < 1 and share * high or 0)) / high
end

return feder.scene {
  title = "Draught",
  seconds = p.seconds,
  world = p.world,

  study = problem.of_fluid(p, function() return water end, {
    observe = function()
      local x, y = beam:position()
      return { x, y, 0 }
    end,
    -- the way to the end is not known: the reference is where it starts
    reference = function() return { tank / 2, under + high / 2, 0 } end,
    error = error_now,
    scale = { length = high, velocity = math.sqrt(g * high) },
    certainty = { source = "draught rho_body / rho of the height, by the height; above 1: it lies on the ground",
      uncertainty = 1e-6, resolution = 0.5 * p.spacing / high },
  }),

  build = function(world)
    problem.tank(world, tank)
    water = problem.water(world, p, { name = "water", viscosity = 5 })
    local side = (tank - wide) / 2
    problem.fill(water, tank, under, 0, 0)
    problem.fill(water, side, level - under, 0, under)
    problem.fill(water, side, level - under, side + wide, under)
    beam = world:body { name = "beam", shape = feder.box(wide, high, 1), density = 1000 * share,
      position = { tank / 2, under + high / 2, 0 } }
    sum, count = 0, 0
  end,

  -- the mean over the last quarter
  update = function(world)
    if world:time() < 0.75 * p.seconds then return end
    local left, right = water:height_at(0.2, 0), water:height_at(tank - 0.2, 0)
    if not left or not right then return end
    local _, y = beam:position()
    local bottom = y - high / 2
    sum, count = sum + (share < 1 and (left + right) / 2 - bottom or bottom), count + 1
  end,

  check = function(_, _, expect)
    expect.error(error_now(), "<", 0.05, "draught")
  end,
}
