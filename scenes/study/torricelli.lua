-- Water leaves a tank through a slot in its floor as fast as if it had fallen from the surface (Torricelli 1644), v =
-- sqrt(2 g h), in a jet that is pi / (pi + 2) = 0.611 as wide as the slot (Kirchhoff 1869).
local feder = require "feder"
local problem = require "feder.problem"

local p = problem.fluid(40, 1)
local quantity = feder.param("quantity", "speed", { choices = { "speed", "discharge" },
  help = "whose error it is: the speed of the jet, or the flow through the slot" })

local g, wide, level, slot, floor = 9.81, 1, 0.8, 0.15, 0.1  -- m
local within = { dfsph = 0.26 }  -- the edges of the slot count as wider than they are
local contraction = math.pi / (math.pi + 2)
local formed = 0.4  -- s, when there is a jet as far as it is looked at

local water, sum, count, filled, before, fallen, out

-- Mean height of the surface, where there is one above the floor.
local function surface()
  local total, n = 0, 0
  for k = 0, 7 do
    local y = water:height_at(wide * (k + 0.5) / 8, 0)
    if y and y > 0 then total, n = total + y, n + 1 end
  end
  return n > 0 and total / n or 0
end

-- m^2 in the tank
local function volume()
  local x, n = water:positions(), 0
  for i = 2, #x, 3 do
    if x[i] > 0 then n = n + 1 end
  end
  return n * p.spacing ^ 2
end

-- Speeds by that of their fall from the surface, in the jet below the floor.
local function add_jet(top)
  local x, v = water:positions(), water:velocities()
  for i = 1, #x, 3 do
    local y = x[i + 1]
    if y < -slot and y > -4 * slot then
      sum, count = sum + math.sqrt((v[i] ^ 2 + v[i + 1] ^ 2) / (2 * g * (top - y))), count + 1
    end
  end
end

-- Signed; 1 before anything was measured.
local function speed_error() return count > 0 and sum / count - 1 or 1 end
local function discharge_error() return fallen > 0 and out / fallen - 1 or 1 end

return feder.scene {
  title = "Torricelli's jet",
  seconds = p.seconds,
  world = p.world,

  study = problem.of_fluid(p, function() return water end, {
    -- what is left of the water, by the jet of Kirchhoff at the speed of Torricelli
    observe = function() return volume() / filled end,
    reference = function(t)
      return math.max(0, 1 - contraction * slot / wide * math.sqrt(g / (2 * level)) * t) ^ 2
    end,
    error = function() return math.abs(quantity == "speed" and speed_error() or discharge_error()) end,
    scale = { length = 1, velocity = math.sqrt(2 * g * level) },
    certainty = { source = "v^2 = 2 g h, by the mean of the jet; flow through a slot contracted to 0.611",
      uncertainty = 0.01,  -- the tank is not wide beside the jet: (0.611 slot / width)^2, and it takes time to start
      resolution = 0.5 * p.spacing },
  }),

  build = function(world)
    world:body { type = "static", shape = feder.plane(1, 0, 0, 0) }
    world:body { type = "static", shape = feder.plane(-1, 0, 0, -wide) }
    local part = (wide - slot) / 2
    for _, x in ipairs { part / 2, wide - part / 2 } do
      world:body { type = "static", shape = feder.box(part, floor, 1), position = { x, -floor / 2, 0 } }
    end
    water = problem.water(world, p, { name = "water", artificial_viscosity = 0 })
    problem.fill(water, wide, level, 0, 0)
    water:drain { box = { { -1, -3, -1 }, { wide + 1, -1.2, 1 } } }
    filled = volume()
    sum, count, fallen, out = 0, 0, 0, 0
    before = { t = 0, volume = filled }
  end,

  update = function(world)
    local t, left, was = world:time(), volume(), before
    before = { t = t, volume = left }
    if t < formed then return end
    local top = surface()
    add_jet(top)
    out, fallen = out + was.volume - left, fallen + contraction * slot * math.sqrt(2 * g * top) * (t - was.t)
  end,

  check = function(_, _, expect)
    expect.error(math.abs(speed_error()), "<", 0.04, "speed of the jet")
    expect.error(math.abs(discharge_error()), "<", within[p.solver] or 0.18, "flow through the slot")
  end,
}
