-- A box that spins freely near its middle axis and tumbles over again and again (Euler 1758): the errors are those of
-- the tips of its three unit axes; its angular momentum is fixed in the world.
local feder = require "feder"
local problem = require "feder.problem"

local half, spin = {}, {}
for k, name in ipairs { "hx", "hy", "hz" } do
  half[k] = feder.param(name, k / 10, { min = 1e-3, max = 1e3, help = "half size, m; the mass is 1 kg" })
end
for k, name in ipairs { "wx", "wy", "wz" } do
  spin[k] = feder.param(name, k == 2 and 5 or 0.05, { min = -1e4, max = 1e4, help = "spin at the start, rad/s" })
end
local seconds = feder.param("t_end", 10, { min = 1e-3, max = 1e4, help = "s" })

local inertia, energy, speed = {}, 0, math.sqrt(spin[1] ^ 2 + spin[2] ^ 2 + spin[3] ^ 2)
for k = 1, 3 do
  local a, b = half[k % 3 + 1], half[(k + 1) % 3 + 1]
  inertia[k] = (a * a + b * b) / 3
  energy = energy + 0.5 * inertia[k] * spin[k] * spin[k]
end

local body, exact

local function tips(q, w)
  local x, v = {}, {}
  for _, axis in ipairs { problem.axes(q[1], q[2], q[3], q[4]) } do
    x[#x + 1], v[#v + 1] = axis, problem.cross(w, axis)
  end
  return { x = x, v = v, q = q }
end

local function observe()
  return tips({ body:rotation() }, { body:angular_velocity() })
end

return feder.scene {
  title = "Free top",
  seconds = seconds,
  picture = 1,
  world = { gravity = { 0, 0, 0 }, dt = 1 / 480, substeps = 1, sleeping = false },

  study = {
    observe = observe,
    reference = function(t) return tips(exact(t)) end,
    energy = energy,
    constraint = function() return 0 end,
    conserves = "angular_momentum",
    scale = { length = 1, velocity = math.max(speed, 1e-6), energy = energy },
    certainty = { source = "Euler's equations, extrapolated", kind = "quad", uncertainty = 1e-12,
      rounding = 1e3 },  -- near its middle axis the spin forgets where it came from
    axes = { dt = problem.steps(seconds, speed * seconds * 2, 6), substeps = { 1 } },
  },

  build = function(world)
    body = world:body { name = "top", shape = feder.box(2 * half[1], 2 * half[2], 2 * half[3]), mass = 1, friction = 0,
      angular_velocity = spin }
    exact = problem.top(inertia, 0, { spin[1], spin[2], spin[3], 0, 0, 0, 1 }, seconds)
  end,

  check = function(world, _, expect)
    local now, then_ = observe(), tips(exact(world:time()))
    local worst = 0
    for k = 1, 3 do
      for i = 1, 3 do worst = math.max(worst, math.abs(now.x[k][i] - then_.x[k][i])) end
    end
    expect.error(worst, "<", 0.02, "axes of the box")
    local lx, ly, lz = world:angular_momentum()
    local miss = 0
    for k, l in ipairs { lx, ly, lz } do miss = math.max(miss, math.abs(l - inertia[k] * spin[k])) end
    expect.error(miss, "<", 1e-5 * inertia[2] * speed, "angular momentum")
    expect.error(math.abs(world:energy() - energy), "<", 1e-3 * energy, "energy")
  end,
}
