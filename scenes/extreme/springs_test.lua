-- Extreme inputs of nets and of worlds: descriptions that must be refused, springs without length or stretched a
-- hundredfold, masses of 1e6 kg, velocities that are hardly numbers.
local feder = require "feder"
local extreme = require "feder.extreme"

extreme.needs "net"

local nan = 0 / 0

local function weightless(dt)
  return feder.world { gravity = { 0, 0, 0 }, dt = dt or 1 / 60, substeps = 1, sleeping = false }
end

-- Two points of 1 kg, 1 m apart, and a spring at rest.
local function pair(changes)
  local net = { name = "pair", points = { { 0, 0, 0 }, { 1, 0, 0 } }, masses = { 1, 1 },
    springs = { { 1, 2, stiffness = 100, rest_length = 1 } } }
  for key, value in pairs(changes or {}) do net[key] = value end
  return net
end

local function finite(world) return world:is_finite() and world:residuals()["springs.quarantined_nets"] == 0 end

local function distance(net)
  local x1, y1, z1 = net:point(1)
  local x2, y2, z2 = net:point(2)
  return math.sqrt((x2 - x1) ^ 2 + (y2 - y1) ^ 2 + (z2 - z1) ^ 2)
end

-- nets that must be refused, beside one that lives on
local lives = weightless()
lives:net(pair())

local function refused(name, word, changes)
  extreme.refused("springs: " .. name, word, lives, function() lives:net(pair(changes)) end)
end

local function refused_spring(name, word, spring) refused(name, word, { springs = { spring } }) end

refused("mass 0", "masses[2]", { masses = { 1, 0 } })
refused("mass -1", "masses[1]", { masses = { -1, 1 } })
refused("mass NaN", "masses[1]", { masses = { nan, 1 } })
refused("position NaN", "points[2]", { points = { { 0, 0, 0 }, { 1, 0, nan } } })
refused_spring("stiffness -1", "springs[1].stiffness", { 1, 2, stiffness = -1, rest_length = 1 })
refused_spring("stiffness NaN", "springs[1].stiffness", { 1, 2, stiffness = nan, rest_length = 1 })
refused_spring("spring from a point to itself", "springs[1]", { 1, 1, stiffness = 100, rest_length = 1 })
refused("no such integrator", "implicit_euler", { integrator = "rk17" })  -- one of those that are known
refused("misspelt integrator option", "tolerance", { integrator = "rk45", integrator_options = { tolerence = 1e-3 } })

local function refused_world(name, word, options)
  extreme.refused("world: " .. name, word, lives, function() feder.world(options) end)
end

refused_world("dt 0", "dt", { dt = 0 })
refused_world("dt -1", "dt", { dt = -1 })
refused_world("dt NaN", "dt", { dt = nan })
refused_world("gravity NaN", "gravity", { gravity = { 0, nan, 0 } })

-- They are pushed apart along x by a fixed rule; they must part and swing, not hang or fly off.
extreme.case("springs: two particles at one point", "part along a fixed direction and swing", function()
  local world = weightless(1 / 240)
  local net = world:net(pair { points = { { 0, 0, 0 }, { 0, 0, 0 } } })
  local most = 0
  for _ = 1, 480 do
    world:step()
    most = math.max(most, distance(net))
  end
  local good = finite(world) and most > 1.5 and most < 2.2
  return good, good and "stable" or "stuck", ("largest distance, m %.6g"):format(most)
end)

extreme.case("springs: rest length 0", "f = k x, the amplitude stays", function()
  local world = weightless(1 / 240)
  local spring = { 1, 2, stiffness = 100, rest_length = 0 }
  local net = world:net(pair { springs = { spring }, integrator = "velocity_verlet" })
  net:pin(1)
  world:step(4300)
  local most = 0
  for _ = 1, 500 do
    world:step()
    most = math.max(most, math.abs((net:point(2))))
  end
  local good = finite(world) and math.abs(most - 1) < 0.01
  return good, good and "stable" or "growing", ("amplitude after 20 s, m %.6g"):format(most)
end)

extreme.case("springs: spring stretched 100 times", "energy does not rise", function()
  local world = weightless()
  world:net(pair { springs = { { 1, 2, stiffness = 1e6, damping = 10, rest_length = 0.01 } }, integrator = "tr_bdf2" })
  local _, _, start = world:energy()
  local most = 0
  for _ = 1, 300 do
    world:step()
    local kinetic, _, elastic = world:energy()
    most = math.max(most, kinetic + elastic)
  end
  local good = finite(world) and most <= 1.001 * start
  return good, good and "stable" or "growing", ("largest energy by that of the start %.6g"):format(most / start)
end)

-- The first spring carries everything.
extreme.case("springs: 1000 links, 1e6 kg at the end", "tension within 1 % of the weight", function()
  local world = feder.world { gravity = { 0, -9.81, 0 }, substeps = 1, sleeping = false }
  local links, stiffness, points, masses, springs, mass = 1000, 1e9, {}, {}, {}, 0
  for i = 1, links + 1 do
    points[i], masses[i] = { 0, -0.1 * (i - 1), 0 }, i > links and 1e6 or 1
    if i > 1 then springs[i - 1], mass = { i - 1, i, rest_length = 0.1 }, mass + masses[i] end
  end
  local net = world:net { name = "chain", points = points, masses = masses, springs = springs, stiffness = stiffness,
    damping = 2, integrator = "implicit_euler", pins = { 1 } }
  world:step(1200)
  local tension, wanted = stiffness * net:strain(1) * 0.1, mass * 9.81
  local good = finite(world) and math.abs(tension / wanted - 1) < 0.01
  return good, good and "stable" or "inaccurate", ("tension by the weight below %.6g"):format(tension / wanted)
end)

-- The smallest numbers in single precision and, along x, in double.
extreme.case("springs: denormal velocities", "nothing moves", function()
  local world = weightless()
  local net = world:net(pair { velocities = { { 2 ^ -1074, 2 ^ -149, 0 }, { 2 ^ -1022 / 3, 0, 2 ^ -126 / 3 } } })
  world:step(600)
  local x, y, z = net:point(2)
  local far = math.sqrt((x - 1) ^ 2 + y ^ 2 + z ^ 2)
  local good = finite(world) and far < 1e-6
  return good, good and "stable" or "growing", ("moved, m %.6g"):format(far)
end)

extreme.finish()
