-- The flow between two plates starts when the upper one starts to move: its profile is the series of Morris, Fox and
-- Zhu, Modeling Low Reynolds Number Incompressible Flows Using SPH (1997), eq. 20.
local feder = require "feder"
local problem = require "feder.problem"

local p = problem.fluid(20, 0.4)
local viscosity = feder.param("viscosity", 0.5, { min = 1e-3, max = 10, help = "kinematic, m^2/s" })
local plate = feder.param("speed", 0.5, { min = 1e-3, max = 10, help = "of the upper plate, m/s" })

local long, band = 4, 0.09  -- m
p.world.gravity = { 0, 0 }

local water

-- By that of the plate.
local function speed(y, t)
  if t <= 0 then return 0 end
  local u = y
  for n = 1, 60 do
    local k = n * math.pi
    u = u + 2 / k * (-1) ^ n * math.sin(k * y) * math.exp(-k * k * viscosity * t)
  end
  return u
end

-- Over the band about y.
local function expected(y, t)
  local sum = 0
  for k = 0, 15 do sum = sum + speed(y - band + 2 * band * (k + 0.5) / 16, t) / 16 end
  return sum
end

local function reference(t) return { expected(0.25, t), expected(0.5, t), expected(0.75, t) } end

-- Mean speed of the particles in the bands about the three heights, far from the ends.
local function observe()
  local function mean(y)
    return problem.band_speed(water, long / 2, y, band, function(height) return height end) / plate
  end
  return { mean(0.25), mean(0.5), mean(0.75) }
end

local function error_now(t)
  local now, want, worst = observe(), reference(t), 0
  for k = 1, 3 do worst = math.max(worst, math.abs(now[k] - want[k])) end
  return worst
end

return feder.scene {
  title = "Couette flow",
  seconds = p.seconds,
  world = p.world,

  study = problem.of_fluid(p, function() return water end, {
    observe = observe,
    reference = reference,
    error = function() return error_now(p.seconds) end,
    scale = { length = 1, velocity = plate },
    certainty = { source = "series of Couette: speed at a quarter, a half and three quarters, by the plate's",
      uncertainty = 1e-4, resolution = 0.5 * p.spacing },
  }),

  build = function(world)
    world:body { type = "static", shape = feder.plane(0, 1, 0, 0) }
    -- long enough to cover the fluid all the time
    local half = long / 2 + 1 + plate * p.seconds
    world:body { name = "plate", type = "kinematic", shape = feder.box(2 * half, 0.5, 1), velocity = { plate, 0, 0 },
      position = { long / 2, 1.25, 0 } }
    water = problem.water(world, p, { name = "water", viscosity = 1000 * viscosity, artificial_viscosity = 0 })
    problem.fill(water, long, 1, 0, 0)
  end,

  check = function(world, _, expect)
    expect.error(error_now(world:time()), "<", 0.02, "profile")
  end,
}
