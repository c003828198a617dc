-- Extreme inputs of cloth, by every solver: descriptions that must be refused, vertices thrown about, and weights up to
-- 1e4 times its own.
local feder = require "feder"
local extreme = require "feder.extreme"
local problem = require "feder.problem"

extreme.needs "cloth"

local points = 9  -- along a border

local function new_world(gravity) return feder.world { gravity = { 0, -gravity, 0 }, sleeping = false } end

-- A square of 1 m.
local function sheet(stiffness, changes)
  local cloth = { resolution = { points, points }, stretch = stiffness, damping = 0.02, self_collision = false }
  for key, value in pairs(changes) do cloth[key] = value end
  return cloth
end

-- descriptions that must be refused, beside a sheet that lives on
local lives = new_world(9.81)
lives:cloth(sheet(1000, {}))

local function refused(name, word, changes)
  extreme.refused("cloth: " .. name, word, lives, function() lives:cloth(sheet(1000, changes)) end)
end

refused("area density 0", "area_density", { area_density = 0 })
refused("stretch NaN", "stretch", { stretch = 0 / 0 })
refused("pin out of range", "pins", { pins = { points * points + 1 } })

local function held(world) return world:residuals()["cloth.quarantined"] > 0 end

-- Of a cloth that is held back because its numbers overflowed: it must say so.
local function held_back(warnings) return warnings.named, "diverged", "held where it was" .. warnings.text end

-- Weightless, thrown about by `throw`: it must come back to its shape, and no energy may come from nowhere.
local function comes_back(solver, stiffness, throw)
  local world = new_world(0)
  local cloth = world:cloth(sheet(stiffness, { solver = solver }))
  throw(cloth)
  local warnings = extreme.warnings(world, cloth)
  local start, most = problem.energy(world), 0
  for _ = 1, 300 do
    world:step()
    if held(world) then return held_back(warnings) end
    most = math.max(most, (world:energy()))
  end
  local strain = cloth:stretch()
  local good = world:is_finite() and most <= 1.01 * start and (stiffness < 100 or strain < 0.5)
  return good, good and "stable" or world:is_finite() and "inaccurate" or "nan",
    ("largest kinetic energy by that at the start %.6g, largest strain left %.6g%s"):format(most / start, strain,
      warnings.text)
end

local function one_away(cloth) cloth:set_point(41, 100, 30, -20) end  -- the middle

local function all_random(cloth)
  math.randomseed(7)
  for i = 1, points * points do cloth:set_point(i, math.random(), math.random(), math.random()) end
end

-- A bar of `ratio` times its mass hung from its lower border, which touches nothing: holds, or stretches and says so.
local function hang(solver, ratio)
  extreme.needs "body"
  local world = new_world(9.81)
  local mass = 0.2 * ratio  -- kg
  local cloth = world:cloth(sheet(mass * 9.81 / 0.05, {  -- 5 % of strain
    solver = solver, rotation = { axis = { 1, 0, 0 }, angle = math.pi / 2 }, pins = { "top" } }))
  local top, first = (points + 1) // 2, points * (points - 1) + 1
  local low = first + points // 2
  local bar = world:body { shape = feder.box(1, 0.05, 0.05), mass = mass, group = 0, position = { cloth:point(low) } }
  for i = first, points * points do cloth:attach(i, bar) end
  local warnings = extreme.warnings(world, cloth)
  local longest = 0
  for _ = 1, 240 do
    world:step()
    local x1, y1, z1 = cloth:point(low)
    local x2, y2, z2 = cloth:point(top)
    longest = math.max(longest, math.sqrt((x1 - x2) ^ 2 + (y1 - y2) ^ 2 + (z1 - z2) ^ 2))
    if held(world) then return held_back(warnings) end
  end
  local holds = longest < 1.2
  local good = world:is_finite() and (holds or warnings.named) and longest < 5
  return good, good and holds and "stable" or "inaccurate", ("longest, m %.6g%s"):format(longest, warnings.text)
end

for _, solver in ipairs(feder.choices("cloth.solver")) do
  local function case(name, expected, run, ...)
    local arguments = table.pack(solver, ...)
    extreme.case(("cloth: %s, %s"):format(name, solver), expected, function() return run(table.unpack(arguments)) end)
  end
  case("one vertex 100 lengths away, 1 N/m", "swings back, no energy from nowhere", comes_back, 1, one_away)
  case("one vertex 100 lengths away, 1e3 N/m", "comes back to its shape", comes_back, 1e3, one_away)
  case("one vertex 100 lengths away, 1e6 N/m", "comes back to its shape, or is held with a warning", comes_back, 1e6,
    one_away)
  case("all vertices random, 1 N/m", "spreads, no energy from nowhere", comes_back, 1, all_random)
  case("all vertices random, 1e3 N/m", "spreads to its size", comes_back, 1e3, all_random)
  case("all vertices random, 1e6 N/m", "spreads to its size, or is held with a warning", comes_back, 1e6, all_random)
  case("bar of 100 times its mass hung from it", "holds, or stretches with a warning", hang, 100)
  case("bar of 1e4 times its mass hung from it", "holds, stretches or is held with a warning", hang, 1e4)
end

extreme.finish()
