-- A ball in a fluid is let go: the fluid has to make way, so it starts with g (1 - s) / (s + C), s its density by the
-- fluid's. In the middle of a closed tank b times as wide (Stokes 1843; Lamb, Hydrodynamics, art. 93): C = (b^2 + 1) /
-- (b^2 - 1) of a cylinder, (b^3 + 2) / (2 (b^3 - 1)) of a sphere.
local feder = require "feder"
local problem = require "feder.problem"

local dimension = feder.param("dimension", 2, { min = 2, max = 3, step = 1, help = "2: a cylinder, 3: a sphere" })
local share = feder.param("density_ratio", 0.1, { min = 1e-2, max = 1e2, help = "of the ball to the fluid" })
local b = feder.param("tank", 4, { min = 2, max = 20, help = "radius of the tank by the ball's" })
local hold = feder.param("hold", "static", { choices = { "static", "weld" },
  help = "how the ball is held until then: a static body, or welded to the world" })
local p = problem.fluid(dimension == 3 and 6 or 10, 0.55)

local g, radius, rest, sides = 9.81, 0.25, 0.5, 16  -- m/s^2, m, s until it is let go
p.spacing = p.spacing * radius  -- as many across the radius
p.world.dimension = dimension
local added = dimension == 3 and (b ^ 3 + 2) / (2 * (b ^ 3 - 1)) or (b ^ 2 + 1) / (b ^ 2 - 1)
local expected = g * (1 - share) / (share + added)

local unit = g * math.max(math.abs(1 - share), 0.1) / (share + added)  -- there is no acceleration at s = 1

-- What is not reached yet; the aim is 0.05.
local within = dimension == 3 and { pbf = 0.25, wcsph = 0.25 } or {}

local water, ball, weld, release, before

-- Rings of particles about the ball, or shells of them.
local function points()
  local list, layers = {}, math.floor((b - 1) * radius / p.spacing + 0.5)
  for j = 1, layers do
    local r = radius + (j - 0.5) * (b - 1) * radius / layers
    if dimension == 2 then
      local n = math.floor(2 * math.pi * r / p.spacing + 0.5)
      for i = 1, n do
        local turn = 2 * math.pi * i / n
        list[#list + 1] = { r * math.cos(turn), r * math.sin(turn), 0 }
      end
    else
      local n = math.floor(4 * math.pi * (r / p.spacing) ^ 2 + 0.5)
      for i = 1, n do  -- evenly (Vogel 1979)
        local y, turn = 1 - 2 * (i - 0.5) / n, i * math.pi * (3 - math.sqrt(5))
        local flat = math.sqrt(1 - y * y)
        list[#list + 1] = { r * flat * math.cos(turn), r * y, r * flat * math.sin(turn) }
      end
    end
  end
  return list
end

-- The tank: planes that leave as much room as the circle, or triangles of a sphere, and 8 thousandths more: particles that
-- lie at random and fill all that there is jam.
local function tank(world)
  if dimension == 2 then
    local half = math.pi / sides
    for i = 1, sides do
      local turn = 2 * half * i
      world:body { type = "static",
        shape = feder.plane(math.cos(turn), math.sin(turn), 0, -b * radius * math.sqrt(half / math.tan(half))) }
    end
    return
  end
  local v, t, rows, columns = {}, {}, 16, 32
  for i = 0, rows do
    for k = 0, columns - 1 do
      local up, turn = math.pi * i / rows, 2 * math.pi * k / columns
      local r = b * radius * 1.007
      v[#v + 1] = { r * math.sin(up) * math.cos(turn), r * math.cos(up), r * math.sin(up) * math.sin(turn) }
    end
  end
  for i = 0, rows - 1 do
    for k = 0, columns - 1 do
      local a, c = i * columns + k + 1, i * columns + (k + 1) % columns + 1
      if i > 0 then t[#t + 1] = { a, c, a + columns } end
      if i < rows - 1 then t[#t + 1] = { c, c + columns, a + columns } end
    end
  end
  world:body { type = "static", shape = feder.mesh(v, t) }
end

local function speed()
  local _, y = ball:velocity()
  return y
end

-- Of the mean acceleration since it was let go.
local function error_now(t)
  if not release or t <= release then return 1 end
  return math.abs(speed() / (t - release) - expected) / unit
end

return feder.scene {
  title = "Added mass",
  seconds = p.seconds,
  world = p.world,

  study = problem.of_fluid(p, function() return water end, {
    observe = speed,
    reference = function(t) return expected * math.max(0, t - rest) end,
    error = function(world) return error_now(world:time()) end,
    scale = { length = radius, velocity = math.sqrt(g * radius) },
    certainty = { source = "g (1 - s) / (s + C), by the speed at the end", uncertainty = 5e-3,
      resolution = 0.5 * p.spacing / radius },
  }),

  build = function(world)
    tank(world)
    water = problem.water(world, p, { name = "water", artificial_viscosity = 0 })
    water:fill { points = points() }
    ball = world:body { name = "ball", shape = dimension == 3 and feder.sphere(radius) or feder.circle(radius),
      density = 1000 * share, type = hold == "static" and "static" or "dynamic" }
    weld = hold == "weld" and world:joint { type = "weld", a = ball, anchor = { 0, 0, 0 } }
    release, before = nil, 0
  end,

  update = function(world)
    local t = world:time()
    if not release and t + (t - before) / 2 > rest then
      release = t
      if weld then weld:destroy() else ball:set_type("dynamic") end
    end
    before = t
  end,

  check = function(world, _, expect)
    expect(world:is_finite())
    local x, far = water:positions(), 0
    for i = 1, #x, 3 do far = math.max(far, x[i] ^ 2 + x[i + 1] ^ 2 + x[i + 2] ^ 2) end
    expect(math.sqrt(far) < b * radius + p.spacing, "fluid is out of the tank")
    expect.error(error_now(world:time()), "<", within[p.solver] or 0.05, "acceleration")
  end,
}
