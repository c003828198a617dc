-- Extreme inputs of fluids, by every solver: descriptions that must be refused, particles in one place, far away or at
-- random, and beams and budgets far from the usual.
local feder = require "feder"
local extreme = require "feder.extreme"
local problem = require "feder.problem"

extreme.needs "fluid"

local spacing, gravity = 0.05, 9.81

-- A tank 1 m wide, in the plane, without a lid.
local function tank()
  local world = feder.world { gravity = { 0, -gravity }, dimension = 2, sleeping = false }
  problem.tank(world, 1)
  return world
end

-- A block of particles in the left corner of the tank.
local function block(wide, high)
  local points = {}
  for j = 1, high do
    for i = 1, wide do points[#points + 1] = { (i - 0.5) * spacing, (j - 0.5) * spacing } end
  end
  return points
end

-- descriptions that must be refused, beside a fluid that lives on
local lives = tank()
lives:fluid { spacing = spacing }:fill { points = block(4, 4) }

local function refused(name, word, options)
  extreme.refused("fluid: " .. name, word, lives, function() lives:fluid(options) end)
end

refused("spacing 0", "spacing", { spacing = 0 })
refused("density NaN", "density", { spacing = spacing, density = 0 / 0 })
refused("viscosity -1", "viscosity", { spacing = spacing, viscosity = -1 })

-- Fills the tank and runs it: places at the end, and what went wrong on the way. `add` puts more into the world.
local function run(seconds, points, options, add)
  local world = tank()
  options.spacing = spacing
  local fluid = world:fluid(options)
  fluid:fill { points = points }
  if add then add(world) end
  local warnings = extreme.warnings(world, fluid)
  local velocities, fastest = feder.buffer(3 * #points), 0
  for _ = 1, math.floor(60 * seconds + 0.5) do
    world:step()
    fluid:velocities(velocities)
    for i = 1, 3 * #points, 3 do fastest = math.max(fastest, velocities[i] ^ 2 + velocities[i + 1] ^ 2) end
  end
  local x, beyond, sum = fluid:positions(), 0, 0
  for i = 1, #x, 3 do
    beyond = math.max(beyond, -x[i + 1], -x[i], x[i] - 1)  -- below the floor, or in a wall
    sum = sum + x[i + 1]
  end
  return { x = x, fluid = fluid, count = #points, middle = sum / #points, beyond = beyond, fastest = math.sqrt(fastest),
    warnings = warnings, finite = world:is_finite() }
end

-- Nothing lost, nothing beyond the walls, but for rounding or what is allowed.
local function kept(r, allowed)
  return r.finite and r.fluid:count() == r.count and r.beyond < (allowed or 1e-4 * spacing)
end

local function outcome(r, good, detail, ...)
  local beyond = r.beyond > 0 and (", beyond the walls, m %.6g"):format(r.beyond) or ""
  return good, good and "stable" or r.finite and "inaccurate" or "nan",
    detail:format(...) .. (", fastest, m/s %.6g"):format(r.fastest) .. beyond .. r.warnings.text
end

-- They have no direction to part in but the one of a fixed rule.
local function on_one_spot(solver)
  local points = {}
  for i = 1, 10000 do points[i] = { 0.5, 0.5 } end
  local r = run(0.05, points, { solver = solver, max_substeps = 8 })
  local far = 0
  for i = 1, #r.x, 3 do far = math.max(far, (r.x[i] - 0.5) ^ 2 + (r.x[i + 1] - 0.5) ^ 2) end
  far = math.sqrt(far)
  -- walls are not asked to hold what passes hundreds of tanks in a substep. More than a thousand times the speed of a
  -- fall through the tank has no measure: it must be said
  local burst = r.fastest > 1e3 * math.sqrt(gravity)
  local good, verdict, detail = outcome(r, kept(r, 1) and far > spacing and (not burst or r.warnings.named),
    "largest distance, m %.6g", far)
  return good, good and burst and "diverged" or verdict, detail
end

-- One particle 100 tanks up: it falls, and the others stand.
local function stray(solver)
  local height, points = 100, block(20, 10)
  points[78] = { 0.5, height }
  local r = run(1, points, { solver = solver })
  local at = r.x[3 * 78 - 1]
  local fallen, wanted, middle = height - at, 0.5 * gravity, (200 * r.middle - at) / 199
  return outcome(r, kept(r) and math.abs(fallen / wanted - 1) < 0.05 and math.abs(middle - 0.25) < spacing,
    "it fell, m %.6g, middle of the others, m %.6g", fallen, middle)
end

local function all_random(solver)
  math.randomseed(7)
  local points = {}
  for i = 1, 200 do points[i] = { math.random(), 0.5 * math.random() } end
  local r = run(3, points, { solver = solver })
  -- half a metre of fluid that was thrown in, not blown up: 5 m/s are a fall of more than a metre
  return outcome(r, kept(r) and r.fastest < 5 and math.abs(r.middle - 0.25) < 1.5 * spacing, "middle, m %.6g", r.middle)
end

-- A beam of `ratio` times the density.
local function beam(solver, ratio)
  extreme.needs "body"
  local body
  local r = run(3, block(20, 8), { solver = solver, viscosity = 2 }, function(world)
    body = world:body { shape = feder.box(0.3, 0.2, 1), density = 1000 * ratio, position = { 0.5, 0.6 } }
  end)
  local _, y = body:position()
  local bottom = y - 0.1
  local right = bottom < spacing
  if ratio < 1 then right = math.abs(bottom - 0.4) < 1.5 * spacing end
  -- what a heavy one traps has no room: it is in the beam or in the floor
  return outcome(r, kept(r, 0.2 * spacing) and right, "its bottom, m %.6g", bottom)
end

-- Half a metre of fluid softer than its own weight: a heap on the floor, as its bulk modulus says.
local function soft(solver)
  local r = run(2, block(20, 10), { solver = solver, stiffness = 1, compression = 0.2 })
  return outcome(r, kept(r) and r.middle < 0.27, "middle, m %.6g", r.middle)
end

-- A compression that the budget does not carry: held all the same, or said.
local function poor(solver)
  local r = run(2, block(20, 10), { solver = solver, compression = 1e-4, max_substeps = 1 })
  local mean = r.fluid:density_error()
  local held = mean < 0.01
  local good, verdict, detail = outcome(r, kept(r) and (held or r.warnings.named), "mean compression %.6g", mean)
  return good, good and not held and "inaccurate" or verdict, detail
end

for _, solver in ipairs(feder.choices("fluid.solver")) do
  local function case(name, expected, act, argument)
    extreme.case(("fluid: %s, %s"):format(name, solver), expected, function() return act(solver, argument) end)
  end
  case("10,000 particles on one spot", "burst with a warning, none is lost", on_one_spot)
  case("one particle 100 tanks away", "falls freely, the others stand", stray)
  case("all particles at random", "settle, no energy from nowhere", all_random)
  case("a beam of 1e-2 of its density", "floats", beam, 1e-2)
  case("a beam of 1e2 times its density", "lies on the floor; what it traps is at most a fifth of a spacing in it",
    beam, 1e2)
  case("bulk modulus of 1 Pa", "falls together, or stays as stiff as it can", soft)
  case("compression of 1e-4 in one step of its own", "held, or a warning says what to expect", poor)
end

extreme.finish()
