-- An ordinary scene of all systems by the number SEED: motors, conveyors, teleports, impulses, overlap at birth. Prints
-- what the watchdog says. For test_watchdog.cpp.
local feder = require "feder"
local seed = SEED
local state = seed * 2654435761 % 4294967296
local function random()
  state = (state * 1664525 + 1013904223) % 4294967296
  return state / 4294967296
end
for _ = 1, 8 do random() end
local function range(a, b) return a + (b - a) * random() end
local function whole(a, b) return math.floor(range(a, b + 1)) end
local function chance(p) return random() < p end
local function place(s) return { range(-s, s), range(0.2, 3), range(-s, s) } end

local world = feder.world { substeps = whole(1, 6), rigid = chance(0.4) and { solver = "impulse" } or nil,
  gravity = chance(0.1) and { 0, 0, 0 } or nil }
world:on("warning", function(e)
  if e.code == "diverged" or e.code == "non_finite" then print(("seed %d: %s: %s"):format(seed, e.code, e.message)) end
end)
world:body { type = "static", shape = feder.plane() }
local bodies, nets, cloths, fluids, joints = {}, {}, {}, {}, {}
local function shape()
  local k, s = whole(1, 4), range(0.1, 0.6)
  if k == 1 then return feder.sphere(s) end
  if k == 2 then return feder.capsule(s / 2, s) end
  if k == 3 then return feder.cylinder(s / 2, s * range(0.5, 2)) end
  return feder.box(s, s * range(0.5, 2), s * range(0.5, 2))
end
local function body()
  bodies[#bodies + 1] = world:body { name = "body" .. #bodies, shape = shape(), position = place(1.2), restitution = range(0, 0.9),
    velocity = chance(0.3) and { range(-6, 6), range(-6, 6), range(-6, 6) } or nil,
    angular_velocity = chance(0.3) and { range(-9, 9), range(-9, 9), range(-9, 9) } or nil,
    surface_velocity = chance(0.1) and { range(-3, 3), 0, 0 } or nil, density = 10 ^ range(1.5, 3.5),
    type = chance(0.15) and "kinematic" or nil }
  return bodies[#bodies]
end
local function joint()
  if #bodies < 2 then return end
  local a, b = bodies[whole(1, #bodies)], chance(0.7) and bodies[whole(1, #bodies)] or nil
  if a == b or not a then return end
  local x, y, z = a:position()
  local kind = ({ "ball", "hinge", "distance", "weld" })[whole(1, 4)]
  joints[#joints + 1] = world:joint { type = kind, a = a, b = b, anchor = { x + range(-0.3, 0.3), y + range(-0.3, 0.3), z },
    axis = kind == "hinge" and { range(-1, 1), 1, range(-1, 1) } or nil,
    motor = kind == "hinge" and chance(0.6) and { speed = range(-12, 12), max_force = 10 ^ range(0, 5) } or nil,
    spring = kind == "distance" and chance(0.5) and { hertz = range(0.5, 5), damping_ratio = range(0, 1) } or nil }
end
local function net()
  local n, points, springs, at = whole(3, 9), {}, {}, place(1)
  for i = 1, n do points[i] = { at[1] + 0.15 * i, at[2] + range(-0.02, 0.02), at[3] } end
  local m, substeps = range(0.02, 0.5), 6
  local k = m * (60 * 1) ^ 2 * range(0.01, 0.15)
  for i = 2, n do springs[#springs + 1] = { i - 1, i, stiffness = k, damping = m * range(0, 2), rest_length = 0.15 * range(0.8, 1.2) } end
  local integrators = { "symplectic_euler", "implicit_euler", "velocity_verlet", "rk4", "implicit_midpoint" }
  nets[#nets + 1] = world:net { name = "net" .. #nets, points = points, masses = m, springs = springs,
    integrator = integrators[whole(1, #integrators)], radius = chance(0.6) and 0.05 or nil }
  if chance(0.5) then nets[#nets]:pin(1) end
end
local function cloth()
  local w, h = range(0.5, 1.6), range(0.5, 1.6)
  cloths[#cloths + 1] = world:cloth { name = "cloth" .. #cloths, size = { w, h }, resolution = { whole(4, 12), whole(4, 12) },
    position = place(0.6), solver = chance(0.3) and "mass_spring" or nil, area_density = range(0.1, 0.6),
    pins = chance(0.5) and { "top_left", "top_right" } or nil,
    stretch = 10 ^ range(2, 4.5), rotation = { axis = { 1, 0, 0 }, angle = range(0, 1.6) } }
end
local function fluid()
  local s = range(0.07, 0.12)
  local f = world:fluid { name = "fluid" .. #fluids, spacing = s, solver = chance(0.3) and "wcsph" or nil, max_particles = 3000,
    viscosity = chance(0.5) and range(0, 2) or nil }
  fluids[#fluids + 1] = f
  local at, e = place(0.8), range(0.3, 0.7)
  f:fill { box = { { at[1], at[2], at[3] }, { at[1] + e, at[2] + e, at[3] + e } } }
  if chance(0.2) then f:fill { box = { { at[1], at[2], at[3] }, { at[1] + e, at[2] + e / 2, at[3] + e } } } end
  if chance(0.3) then f:emitter { position = place(1), direction = { range(-1, 1), -1, 0 }, speed = range(0.5, 4), radius = range(0, 0.2) } end
end
local made = { body, body, body, body, joint, joint, net, cloth, fluid }
for _ = 1, whole(4, 16) do
  local f = made[whole(1, #made)]
  if not ((f == fluid and #fluids > 0) or (f == cloth and #cloths > 1)) then f() end
end
if seed % 2 == 0 then  -- ropes, and no draw more: seeds keep their course
  local before = state
  for k = 1, whole(1, 2) do
    local at = place(1)
    local rope = world:rope { name = "rope" .. k, from = at, to = { at[1] + range(-1, 1), range(0.2, 3), at[3] + range(0.1, 1) },
      segments = whole(2, 20), radius = range(0.005, 0.03), stretch = 10 ^ range(2, 5), bend = chance(0.5) and 10 ^ range(-4, -1) or nil,
      pins = chance(0.3) and "last_clamped" or nil }
    local body = bodies[whole(1, math.max(#bodies, 1))]
    if body and chance(0.5) then rope:attach(1, body, 0, 0, 0) end
    if cloths[1] and chance(0.5) then rope:attach(2, cloths[1]) end
    if chance(0.3) then rope:pin((rope:count())) end
    world:after(range(0.2, 1.5), function() rope:set_point(1, range(-1, 1), range(0.2, 3), range(-1, 1)) end)
    world:after(range(0.2, 1.5), function() rope:set_velocity(2, range(-9, 9), range(-9, 9), 0) end)
  end
  state = before
end
local function pick(list) return list[whole(1, math.max(#list, 1))] end
local edits = {
  function() local b = pick(bodies) if b then b:set_position(range(-1, 1), range(0.2, 3), range(-1, 1)) end end,
  function() local b = pick(bodies) if b then b:set_velocity(range(-20, 20), range(-20, 20), range(-20, 20)) end end,
  function() local b = pick(bodies) if b then b:apply_impulse(b:mass() * range(-20, 20), b:mass() * range(-20, 20), 0) end end,
  function() local b = pick(bodies) if b then b:apply_force(b:mass() * range(-500, 500), b:mass() * range(0, 500), 0) end end,
  function() local n = pick(nets) if n then n:set_point(1, range(-1, 1), range(0.2, 3), range(-1, 1)) end end,
  function() local n = pick(nets) if n then n:set_velocity(2, range(-9, 9), range(-9, 9), 0) end end,
  function() local n = pick(cloths) if n then n:set_point(1, range(-1, 1), range(0.2, 3), range(-1, 1)) end end,
  function() local n = pick(cloths) if n then n:set_velocity(2, range(-9, 9), range(-9, 9), 0) end end,
  function() local b = pick(bodies) if b then b:set_type(chance(0.5) and "kinematic" or "dynamic") end end,
  function() local j = pick(joints) if j and j:alive() then j:destroy() end end,
  body, joint,
  function() world:set_gravity(range(-5, 5), range(-15, 5), 0) end,
  function() local k = whole(1, math.max(#bodies, 1)) if bodies[k] then bodies[k]:destroy() table.remove(bodies, k) end end,
}
for _ = 1, 12 do
  world:step(whole(4, 16))
  for _ = 1, whole(0, 2) do pcall(edits[whole(1, #edits)]) end
end
