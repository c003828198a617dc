-- Random operations over all kinds of objects, by the numbers SEED and OPERATIONS; about one number in twenty is
-- hostile. An operation may be refused with an error: what must not happen is a crash, a state that is not finite where
-- all numbers were ordinary (it is printed), or a snapshot that does not run on as the world did.
local feder = require "feder"
local state = SEED * 2654435761 % 4294967296
local function random()
  state = (state * 1664525 + 1013904223) % 4294967296
  return state / 4294967296
end
for _ = 1, 8 do random() end
local HOSTILE = { 0, -1, 1e-30, 1e30, -1e30, 1e9, 0 / 0, 1 / 0, 1e-6, 12345.678 }
local hostile = random() < 0.5 and 0.05 or 0
local function range(a, b)
  local x = random()
  if random() < hostile then return HOSTILE[1 + math.floor(x * #HOSTILE)] end
  return a + (b - a) * x
end
local function whole(a, b) return math.min(b, a + math.floor(random() * (b - a + 1))) end
local function chance(p) return random() < p end
local function pick(list) return list[whole(1, math.max(1, #list))] end
local function place(s) return { range(-s, s), range(0.1, 3), range(-s, s) } end

local world = feder.world { substeps = whole(1, 5), threads = whole(1, 2), rigid = chance(0.3) and { solver = "impulse" } or nil }
local o = { body = {}, joint = {}, net = {}, cloth = {}, fluid = {}, force = {}, emitter = {}, drain = {}, region = {}, connection = {} }
local ropes = SEED % 2 == 1  -- the others keep the course they had before there were ropes
if ropes then o.rope = {} end
local softs = SEED % 5 == 3
if softs then o.soft = {} end
local names = {}
for name in pairs(o) do names[#names + 1] = name end
table.sort(names)
local function keep(kind, thing) o[kind][#o[kind] + 1] = thing return thing end
local function drop(kind)
  local list = o[kind]
  local k = whole(1, math.max(1, #list))
  if list[k] then
    local thing = table.remove(list, k)
    if kind == "connection" then thing:disconnect() else thing:destroy() end
  end
end
local KINDS, POINTS = { "body", "net", "cloth", "fluid" }, { "net", "cloth" }
for _, kinds in ipairs { KINDS, POINTS } do
  if ropes then kinds[#kinds + 1] = "rope" end
  if softs then kinds[#kinds + 1] = "soft" end
end
local function anything() return pick(o[pick(KINDS)]) end
local function points() return pick(o[pick(POINTS)]) end

local function shape()
  local s = range(0.1, 0.7)
  local make = { function() return feder.sphere(s / 2) end, function() return feder.capsule(s / 3, s) end,
    function() return feder.cylinder(s / 2, range(0.1, 0.7)) end, function() return feder.cone(s / 2, range(0.1, 0.7)) end,
    function() return feder.hull { { 0, 0, 0 }, { s, 0, 0 }, { 0, s, 0 }, { 0, 0, s }, { s, s, range(0, 1) } } end,
    function() return feder.compound { { shape = feder.box(s, s, s) }, { shape = feder.sphere(s), position = { s, 0, 0 } } } end,
    function() return feder.box(s, range(0.1, 0.7), range(0.1, 0.7)) end }
  return pick(make)()
end
-- Every fourth seed has fields, and bodies that are carved; no draw more: seeds keep their course.
local function solid()
  local made = shape()
  local n = SEED % 4 == 2 and state % 16 or 16
  if n == 1 and #o.body > 0 then o.body[#o.body]:carve { shape = made, position = { o.body[#o.body]:position() } } end
  if n == 2 and #o.body > 0 then
    local x, y, z = o.body[1]:position()
    o.body[1]:weld_on { shape = made, position = { x, y + 0.2, z } }
  end
  return n > 2 and n < 8 and feder.sdf { shape = made, spacing = 0.06, adaptive = n == 3 } or made
end
local function new_body()
  return keep("body", world:body { shape = solid(), position = place(1.2), type = chance(0.2) and pick { "kinematic", "static" } or nil,
    velocity = chance(0.5) and { range(-5, 5), range(-5, 5), range(-5, 5) } or nil, restitution = range(0, 1), bullet = chance(0.1),
    angular_velocity = chance(0.3) and { range(-9, 9), range(-9, 9), range(-9, 9) } or nil, sensor = chance(0.1),
    density = range(50, 3000), surface_velocity = chance(0.1) and { range(-2, 2), 0, 0 } or nil })
end
local function new_joint()
  local a, b = pick(o.body), chance(0.7) and pick(o.body) or nil
  local kind = pick { "ball", "hinge", "distance", "weld" }
  return keep("joint", world:joint { type = kind, a = a, b = b, anchor = { a:position() }, axis = kind == "hinge" and { range(-1, 1), 1, 0 } or nil,
    motor = kind == "hinge" and chance(0.4) and { speed = range(-9, 9), max_force = range(0, 1000) } or nil,
    limits = kind == "hinge" and chance(0.3) and { range(-1, 0), range(0, 1) } or nil,
    break_force = chance(0.2) and range(1, 1e5) or nil })
end
local function new_net()
  local n, points, springs, at, m = whole(2, 12), {}, {}, place(1), range(0.05, 1)
  for i = 1, n do points[i] = { at[1] + 0.12 * i, at[2] + range(-0.05, 0.05), at[3] } end
  for i = 2, n do springs[#springs + 1] = { i - 1, i, stiffness = m * range(1, 300), damping = m * range(0, 3) } end
  if n > 3 and chance(0.5) then springs[#springs + 1] = { 1, 3, stiffness = m * range(1, 300), break_strain = chance(0.5) and range(0.1, 1) or nil } end
  return keep("net", world:net { points = points, masses = m, springs = springs, radius = chance(0.7) and range(0.02, 0.1) or nil,
    integrator = pick { "symplectic_euler", "implicit_euler", "velocity_verlet", "rk4", "implicit_midpoint", "bdf2", "rk45", "heun" } })
end
local function new_cloth()
  return keep("cloth", world:cloth { size = { range(0.4, 1.5), range(0.4, 1.5) }, resolution = { whole(2, 9), whole(2, 9) }, position = place(0.7),
    solver = chance(0.4) and "mass_spring" or nil, stretch = 10 ^ range(2, 5), shear = chance(0.3) and 10 ^ range(2, 5) or nil,
    thickness = range(0.005, 0.03), tear_strain = chance(0.3) and range(0.05, 0.5) or nil, area_density = range(0.1, 1),
    rotation = { axis = { 1, 0, 0 }, angle = range(0, 3) }, pins = chance(0.4) and { "top_left", 1 } or nil })
end
local function new_rope()
  local n, points, at = whole(2, 24), {}, place(1)
  for i = 1, n do points[i] = { at[1] + 0.06 * i, at[2] + range(-0.03, 0.03), at[3] } end
  local straight = chance(0.5)
  return keep("rope", world:rope { points = not straight and points or nil, from = straight and at or nil, to = straight and place(1) or nil,
    segments = straight and whole(1, 24) or nil, radius = range(0.004, 0.04), density = 10 ^ range(1, 4), stretch = 10 ^ range(1, 6),
    bend = chance(0.5) and 10 ^ range(-4, 1) or nil, damping = range(0, 0.01), friction = range(0, 1), self_collision = chance(0.7),
    pins = chance(0.4) and pick { "first", "last_clamped", { 1, 2 } } or nil, drag = chance(0.2) and range(0, 2) or nil })
end
local function new_soft()
  local x, y, z = range(0.1, 0.6), range(0.1, 0.6), range(0.1, 0.6)
  local shape = pick { feder.box(x, y, z), feder.sphere(x / 2), feder.capsule(x / 4, y) }
  return keep("soft", world:soft { shape = shape, resolution = whole(1, 3), position = place(1), rotation = { axis = { 1, 2, 0 }, angle = range(0, 3) },
    velocity = chance(0.3) and { range(-9, 9), range(-9, 9), range(-9, 9) } or nil, density = 10 ^ range(1.5, 3.5), young = 10 ^ range(3, 6),
    poisson = chance(0.5) and range(-0.5, 0.49) or nil, damping = range(0, 0.02), friction = range(0, 1), self_collision = chance(0.7),
    solver = pick { "xpbd", "vbd", "implicit", "mass_spring" },
    plastic = chance(0.3) and { yield = range(0, 0.3), flow = 10 ^ range(-1, 3) } or nil,
    fracture_stress = chance(0.3) and 10 ^ range(2, 5) or nil, self = chance(0.3) and pick { "hash", "sphere_tree" } or nil,
    elasticity = chance(0.3) and pick { "neo_hookean", "corotated", "stvk" } or nil,
    thickness = chance(0.3) and range(0.002, 0.05) or nil, pins = chance(0.2) and { 1 } or nil })
end
local function new_fluid()
  if #o.fluid > 1 then return drop("fluid") end
  local spacing = range(0.08, 0.14)
  local function digit(n) return math.floor(spacing * 10 ^ n) % 10 end  -- no draw more: seeds keep their course
  return keep("fluid", world:fluid { spacing = spacing, friction = digit(4) < 3 and digit(5) / 4 or nil,
    vorticity = digit(5) < 2 and 2 * digit(4) or nil, kernels = digit(6) < 2 and { viscosity = "cubic" } or nil,
    adhesion = digit(7) < 4 and digit(6) / 2 or nil, solver = chance(0.4) and "wcsph" or nil, max_particles = 800,
    viscosity = chance(0.5) and range(0, 10) or nil, surface_tension = chance(0.3) and range(0, 5) or nil,
    max_substeps = chance(0.3) and whole(1, 30) or nil })
end
local function vector(s) return range(-s, s), range(-s, s), range(-s, s) end

local operations
operations = {
  new_body, new_body, new_joint, new_joint, new_net, new_net, new_cloth, new_fluid,
  function()
    local at, e = place(0.7), range(0.2, 0.5)
    pick(o.fluid):fill { box = { at, { at[1] + e, at[2] + e, at[3] + e } }, velocity = chance(0.3) and { vector(3) } or nil }
  end,
  function() keep("emitter", pick(o.fluid):emitter { position = place(1), direction = { range(-1, 1), -1, 0 }, speed = range(0.5, 4),
    radius = range(0, 0.2), limit = chance(0.5) and whole(1, 200) or nil }) end,
  function() keep("drain", pick(o.fluid):drain { box = { { -0.3, -0.2, -0.3 }, { 0.3, range(0, 0.3), 0.3 } } }) end,
  function() local e = pick(o.emitter) if chance(0.5) then e:stop() else e:start() end end,
  function() keep("region", world:region { box = { { -1, 0, -1 }, { 1, range(0.1, 2), 1 } } }) end,
  function() keep("force", world:force { kind = "wind", velocity = { vector(8) }, on = chance(0.5) and anything() or nil }) end,
  function() keep("force", world:force { kind = "drag", linear = 10 ^ range(-2, 3), quadratic = range(0, 1), on = chance(0.5) and anything() or nil }) end,
  function() keep("force", world:force { kind = "spring", position = place(1), stiffness = range(0, 0.3), on = anything() }) end,
  function() keep("force", world:force { each = chance(0.5) and function(x, y, z) return -x, range(-1, 1), -z end or { "-x", "sin(t)", "0" }, on = anything() }) end,
  function() keep("force", world:force { kind = "buoyancy", on = anything() }) end,
  function() pick(o.body):set_position(vector(2)) end,
  function() pick(o.body):set_velocity(vector(9)) end,
  function() pick(o.body):set_angular_velocity(vector(9)) end,
  function() pick(o.body):apply_impulse(vector(50)) end,
  function() pick(o.body):apply_force(vector(500)) end,
  function() pick(o.body):set_type(pick { "static", "kinematic", "dynamic" }) end,
  function() pick(o.body):move_to(vector(2)) end,
  function() if chance(0.5) then pick(o.body):sleep() else pick(o.body):wake() end end,
  function() pick(o.joint):set_motor(range(-9, 9), range(0, 1000)) end,
  function() pick(o.joint):set_limits(range(-1, 0), range(0, 1)) end,
  function() local n = points() n:set_point(whole(1, n:count()), vector(1)) end,
  function() local n = points() n:set_velocity(whole(1, n:count()), vector(9)) end,
  function() local n = points() n:pin(whole(1, n:count())) end,
  function() local n = points() n:unpin(whole(1, n:count())) end,
  function() local n = points() n:attach(whole(1, n:count()), pick(o.body), vector(0.2)) end,
  function() local n = points() n:detach(whole(1, n:count())) end,
  function() local n = pick(o.net) n:add_spring { whole(1, n:count()), whole(1, n:count()), stiffness = range(1, 5) } end,
  function() pick(o.net):remove_spring(whole(1, 3)) end,
  function() world:set_gravity(range(-3, 3), range(-12, 3), range(-3, 3)) end,
  function() world:raycast(range(-2, 2), 3, 0, vector(1)) end,
  function() world:overlap { shape = shape(), position = place(1) } end,
  function() pick(o.fluid):density_error() pick(o.fluid):height_at(vector(1)) end,
  function() local f = pick(o.fluid) f:set_velocities(function() return vector(2) end) end,
  function() pick(o.net):strain(1) pick(o.cloth):stretch() pick(o.cloth):smooth_vertices(feder.buffer(3 * pick(o.cloth):count())) end,
  function() return world:residuals(), world:energy(), world:report(), world:momentum() end,
  function()  -- destroys inside a handler
    keep("connection", world:on(pick { "contact_begin", "contact_end", "sleep", "wake", "warning", "drained", "spring_break", "step" }, function()
      if chance(0.2) then pcall(drop, pick(names)) end
      if chance(0.1) then pcall(pick(operations)) end
    end))
  end,
  function() world:after(range(0, 0.3), function() pcall(drop, pick(names)) end) end,
  function()  -- run = restore, run
    if #o.connection > 0 or #o.force > 0 then return end
    local image, from = world:snapshot(), state
    world:step(2)
    local hash = world:hash()
    world:restore(image)
    world:step(2)
    if world:hash() ~= hash then print("restored, it does not run as before") end
    state = from
  end,
}
if ropes then
  for _, operation in ipairs { new_rope, new_rope,
    function() local n = points() n:attach(whole(1, n:count()), points()) end,
    function() local r = pick(o.rope) r:apply_impulse(whole(1, r:count()), vector(1)) end,
    function() local r = pick(o.rope) if chance(0.5) then r:sleep() else r:wake() end end,
    function() local r = pick(o.rope) r:tension(1) r:length() r:positions() r:strain() r:mass() end,
  } do operations[#operations + 1] = operation end
end
if softs then
  for _, operation in ipairs { new_soft, new_soft,
    function() local n = points() n:attach(whole(1, n:count()), points()) end,
    function() local b = pick(o.soft) b:apply_impulse(whole(1, b:count()), vector(9)) end,
    function() local b = pick(o.soft) if chance(0.5) then b:sleep() else b:wake() end end,
    function() local b = pick(o.soft) b:volume() b:inverted() b:strain() b:positions() b:awake() b:mass() b:tetrahedron_at(vector(2)) b:part(b:count()) b:tension(1) end,
  } do operations[#operations + 1] = operation end
end
for _, name in ipairs(names) do
  operations[#operations + 1] = function() drop(name) end
  if name == "body" or name == "cloth" then operations[#operations + 1] = function() drop(name) end end
end

world:body { type = "static", shape = feder.plane() }
local indices = { {}, { index = "grid" }, { index = "kd_tree", leaf = 1 }, { index = "octree" }, { index = "bsp" },
  { volume = "obb", build = "sah" }, { volume = "sphere", build = "bottom_up" }, { volume = "kdop18", build = "morton" },
  { volume = "hull", build = "insertion" } }
if SEED % 3 == 0 then  -- a hill
  world:body { type = "static", position = { 0.8, 0, 0 }, shape = feder.mesh(
    { { -0.8, 0, -0.8 }, { 0.8, 0, -0.8 }, { 0.8, 0, 0.8 }, { -0.8, 0, 0.8 }, { 0, 0.3, 0 } },
    { { 1, 5, 2 }, { 2, 5, 3 }, { 3, 5, 4 }, { 4, 5, 1 } }, indices[SEED // 3 % #indices + 1]) }
end
for k = 1, OPERATIONS do
  local ok, message = pcall(pick(operations))
  if not ok and type(message) ~= "string" and type(message) ~= "userdata" then print("an error that is no text: " .. tostring(message)) end
  if chance(0.4) then
    local stepped, why = pcall(world.step, world, whole(1, 4))  -- a scripted force may give what is refused
    if not stepped and hostile == 0 then print(why) end
  end
end
if hostile == 0 and not world:is_finite() then print "ordinary numbers, and the state is not finite" end
world:close()
