-- Extreme inputs of bodies: descriptions that must be refused, degenerate shapes, full overlap, speeds and masses a
-- thousand times the usual.
local feder = require "feder"
local extreme = require "feder.extreme"

extreme.needs "body"

local nan = 0 / 0

local function new_world(gravity, solver)
  return feder.world { gravity = { 0, -gravity, 0 }, sleeping = false, rigid = { solver = solver or "soft_step" } }
end

local function steps(seconds) return math.floor(60 * seconds + 0.5) end

local function length(x, y, z) return math.sqrt(x * x + y * y + z * z) end

-- descriptions that must be refused, beside a box that lives on
local lives = new_world(9.81)
lives:body { shape = feder.box(1, 1, 1), mass = 1 }

local function refused(name, word, options)
  extreme.refused("rigid: " .. name, word, lives, function()
    options.name, options.shape = "bad", feder.box(1, 1, 1)
    lives:body(options)
  end)
end

refused("mass -1", "mass", { mass = -1 })
refused("mass NaN", "mass", { mass = nan })
refused("density 0", "density", { density = 0 })
refused("position NaN", "position", { position = { nan, 0, 0 } })
refused("velocity infinite", "velocity", { velocity = { math.huge, 0, 0 } })
extreme.refused("rigid: box of no width", "box", lives, function() lives:body { shape = feder.box(0, 1, 1) } end)
extreme.refused("rigid: mesh without area", "area", lives, function()
  feder.mesh({ { 0, 0, 0 }, { 1, 0, 0 }, { 2, 0, 0 } }, { { 1, 2, 3 } })
end)

-- A square of two triangles, with one of no area and one whose vertices are twice the same place beside them.
extreme.case("rigid: mesh with zero-area triangles and double vertices", "the good triangles carry a ball", function()
  local world = new_world(9.81)
  local vertices = { { -2, 0, -2 }, { 2, 0, -2 }, { 2, 0, 2 }, { -2, 0, 2 }, { 0, 0, 0 }, { 0, 0, 0 }, { 1, 0, 1 } }
  local triangles = { { 1, 3, 2 }, { 1, 4, 3 }, { 1, 5, 3 }, { 5, 6, 7 } }
  world:body { type = "static", shape = feder.mesh(vertices, triangles) }
  local ball = world:body { shape = feder.sphere(0.25), position = { 0, 1, 0 }, mass = 1 }
  world:step(steps(3))
  local _, height = ball:position()
  local good = world:is_finite() and math.abs(height - 0.25) < 0.0125
  return good, good and "stable" or "inaccurate", ("ball rests at, m %.6g"):format(height)
end)

-- Two boxes in one place, weightless: they part at no more than the push speed of the solver.
extreme.case("rigid: boxes fully overlapping", "part, no faster than the push speed", function()
  local world = new_world(0)
  local a = world:body { shape = feder.box(1, 1, 1), mass = 1 }
  local b = world:body { shape = feder.box(1, 1, 1), mass = 1 }
  local function between(what)
    local x1, y1, z1 = a[what](a)
    local x2, y2, z2 = b[what](b)
    return length(x1 - x2, y1 - y2, z1 - z2)
  end
  local fastest = 0
  for _ = 1, 300 do
    world:step()
    fastest = math.max(fastest, between "velocity")
  end
  local apart = between "position"
  local good = world:is_finite() and apart > 0.95 and fastest < 4
  return good, good and "stable" or fastest < 4 and "stuck" or "growing",
    ("apart, m %.6g, fastest, m/s %.6g"):format(apart, fastest)
end)

-- 167 m per step against a wall of 1 cm, 10 m away: stopped whether marked as bullet or not;
-- a wall that moves itself, too.
local function shoot(bullet, wall_moves)
  local world = new_world(0)
  if wall_moves then
    world:body { shape = feder.box(0.01, 4, 4), position = { 10, 0, 0 }, mass = 1e6, velocity = { -1, 0, 0 } }
  else
    world:body { type = "static", shape = feder.box(0.01, 4, 4), position = { 10, 0, 0 } }
  end
  local ball = world:body { shape = feder.sphere(0.05), mass = 1, velocity = { 10000, 0, 0 }, bullet = bullet }
  world:step(steps(0.5))
  local x = ball:position()
  local stopped = x < 9.96
  return world:is_finite() and stopped, stopped and "stable" or "inaccurate",
    ("ends at x, m %.6g"):format(x)
end

extreme.case("rigid: ball of 1e4 m/s, wall of 1 cm", "stops at the wall", function() return shoot(false, false) end)
extreme.case("rigid: the same, marked as bullet", "stops at the wall", function() return shoot(true, false) end)
extreme.case("rigid: bullet of 1e4 m/s, moving wall of 1 cm", "stops at the wall",
  function() return shoot(true, true) end)
extreme.case("rigid: the same, not marked as bullet", "stops at the wall",
  function() return shoot(false, true) end)

extreme.case("rigid: needle 1000 : 1", "lies still", function()
  local world = new_world(9.81)
  world:body { type = "static", shape = feder.plane() }
  local needle = world:body { shape = feder.box(1, 0.001, 0.001), position = { 0, 0.2, 0 }, mass = 0.001 }
  world:step(steps(5))
  local _, height = needle:position()
  local speed = length(needle:velocity())
  local good = world:is_finite() and math.abs(height) < 0.01 and speed < 0.05
  return good, good and "stable" or "inaccurate", ("height, m %.6g, speed, m/s %.6g"):format(height, speed)
end)

-- Boxes on each other, the last as heavy as wanted: do they stand still after 2 s?
local function stack(solver, count, seconds, top_mass)
  local world = new_world(9.81, solver)
  world:body { type = "static", shape = feder.plane() }
  local top
  for k = 1, count do
    top = world:body { shape = feder.box(1, 1, 1), position = { 0, k - 0.5, 0 }, mass = k == count and top_mass or 1 }
  end
  world:step(steps(2))
  local x, y, z = top:position()
  world:step(steps(seconds))
  local x_end, y_end, z_end = top:position()
  local drift = length(x_end - x, y_end - y, z_end - z) / seconds * 60  -- m per minute
  local kinetic, sunk = world:energy(), count - 0.5 - y_end
  local stands = world:is_finite() and drift < 1e-3 and kinetic < 1e-6 and sunk < 0.05 * count
  return stands, stands and "stable" or "inaccurate",
    ("drift, m/min %.6g, kinetic, J %.6g, sunk, m %.6g"):format(drift, kinetic, sunk)
end

extreme.case("rigid: stack of 40 boxes for 60 s, impulse", "drift below 1 mm/min, kinetic energy below 1e-6 J",
  function() return stack("impulse", 40, 60, 1) end)
extreme.case("rigid: heavy 1000 : 1 on light, impulse", "stands", function() return stack("impulse", 2, 10, 1000) end)
extreme.case("rigid: heavy 1000 : 1 on light, soft_step", "stands, sways by less than .05 mm/s",
  function() return stack("soft_step", 2, 10, 1000) end)

extreme.finish()
