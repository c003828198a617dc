-- A drop without gravity, drawn out along x and let go: it passes its circle after a quarter and after three quarters of
-- a period, which is that of Rayleigh (1879), of small swings.
local feder = require "feder"
local fluid = require "feder.fluid"
local problem = require "feder.problem"

local p = problem.fluid(24, 2.4)
local tension = feder.param("tension", 125, { min = 1, max = 1e5, help = "N/m; 125 makes a period of 2.565 s" })

local radius, stretch = 0.5, 0.15  -- m, of the radius
local frequency = fluid.swing(tension, 1000, radius)
p.world.gravity = { 0, 0 }

local drop, start, before, passages

local function error_now()
  if #passages < 2 then return 1 end  -- has not come back
  return math.abs((passages[2] - passages[1]) * frequency / math.pi - 1)
end

return feder.scene {
  title = "Swinging drop",
  seconds = p.seconds,
  world = p.world,

  study = problem.of_fluid(p, function() return drop end, {
    -- how much longer along x than along y, by what it was at the start
    observe = function() return fluid.elongation(drop) / start end,
    reference = function(t) return math.cos(frequency * t) end,
    error = error_now,
    scale = { length = 1, velocity = frequency * stretch },
    certainty = { source = "half a period pi / w between two passages through the circle, w^2 = 6 sigma / (rho R^3)",
      uncertainty = stretch * stretch,  -- the next term is of the order of the square of the stretch
      resolution = 4 * p.spacing },
  }),

  build = function(world)
    -- what damps particles lets them freeze to a lattice, which is stiff
    drop = problem.water(world, p, { name = "drop", surface_tension = tension, artificial_viscosity = 0 })
    drop:fill { points = fluid.drop(radius, p.spacing, 1 + stretch) }
    start, passages = fluid.elongation(drop), {}
    before = { t = 0, x = start }
  end,

  update = function(world)
    local x, t, was = fluid.elongation(drop), world:time(), before
    if was.x * x <= 0 then passages[#passages + 1] = was.t + (t - was.t) * was.x / (was.x - x) end
    before = { t = t, x = x }
  end,

  check = function(world, _, expect)
    expect(world:is_finite())
    expect(#passages >= 1, "the drop does not swing")
    local px, py = world:momentum()
    expect(math.abs(px) + math.abs(py) < 1e-2, "the drop moves as a whole")
  end,
}
