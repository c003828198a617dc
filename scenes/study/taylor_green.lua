-- A vortex in a box that it slips along loses its energy to viscosity alone (Taylor and Green 1937): u = U sin(k x)
-- cos(k y), v = -U cos(k x) sin(k y) have no normal component and no shear at the walls of a box of side pi / k, which
-- is one vortex of the periodic array; all of it decays as e^(-2 nu k^2 t), its energy as e^(-4 nu k^2 t). Re = U L /
-- nu with L two sides.
local feder = require "feder"
local problem = require "feder.problem"

local p = problem.fluid(50, 0.5)
local reynolds = feder.param("reynolds", 100, { min = 1, max = 1e4, help = "U L / nu, L two sides of the box" })

local start = feder.param("start", "packed", { choices = { "packed", "lattice" },
  help = "how the particles lie: as those of a fluid that has moved, or in rows, which break up and cost energy" })

local side, fastest = 0.5, 1  -- m, m/s
local k, viscosity = math.pi / side, fastest * 2 * side / reynolds
local decay = 4 * viscosity * k * k  -- of the energy, 1/s
-- What is not reached; particles that are kept from pairing by nothing but pressure stir the flow.
local within = start == "lattice" and { pbf = 0.3, wcsph = 0.35, dfsph = 0.2 } or { pbf = 0.25, wcsph = 0.25 }
p.spacing = p.spacing * side
p.world.gravity = { 0, 0 }

local water, whole

local function flow(x, y)
  return fastest * math.sin(k * x) * math.cos(k * y), -fastest * math.cos(k * x) * math.sin(k * y), 0
end

-- By the mass of a particle, J/kg.
local function energy()
  local v, sum = water:velocities(), 0
  for i = 1, #v do sum = sum + v[i] * v[i] / 2 end
  return sum
end

-- Of the rate of decay, by the energy that is left.
local function error_now(t)
  if t <= 0 then return 0 end
  return math.abs(-math.log(energy() / whole) / (decay * t) - 1)
end

return feder.scene {
  title = "Taylor-Green vortex",
  seconds = p.seconds,
  world = p.world,

  study = problem.of_fluid(p, function() return water end, {
    observe = function() return energy() / whole end,
    reference = function(t) return math.exp(-decay * t) end,
    error = function(world) return error_now(world:time()) end,
    scale = { length = side, velocity = fastest },
    certainty = { source = "e^(-4 nu k^2 t) of the energy, by the rate of decay", uncertainty = 1e-6,
      resolution = 15 * p.spacing },  -- particles stir the flow as they pass each other
  }),

  build = function(world)
    problem.tank(world, side)
    world:body { type = "static", shape = feder.plane(0, -1, 0, -side) }
    local options = { name = "water", viscosity = 1000 * viscosity, artificial_viscosity = 0, wall_slip = "free" }
    water = problem.water(world, p, options)
    if start == "lattice" then
      problem.fill(water, side, side, 0, 0)
    else
      local d, points = p.spacing, problem.packed(math.floor(side / p.spacing + 0.5))
      for _, a in ipairs(points) do a[1], a[2] = d * a[1], d * a[2] end
      water:fill { points = points }
    end
    water:set_velocities(flow)
    whole = energy()
  end,

  check = function(world, _, expect)
    expect(world:is_finite())
    expect.error(error_now(world:time()), "<", within[p.solver] or 0.05, "decay of the energy")
  end,
}
