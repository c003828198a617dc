-- For scenes that are studied (scenes/study): rungs, what is observed, and references by other means than the engine.
--   local problem = require "feder.problem"
local feder = require "feder"
local fluid = require "feder.fluid"

local problem = {}

-- Values of the axis dt: `steps` over `seconds`, doubled so many times.
function problem.steps(seconds, steps, doublings)
  local axis = {}
  for k = 0, doublings do axis[k + 1] = seconds / (math.ceil(steps) * 2 ^ k) end
  return axis
end

function problem.zeros(count)
  local list = {}
  for i = 1, count do list[i] = 0 end
  return list
end

-- Names of `all` without `one`.
function problem.others(all, one)
  local list = {}
  for _, name in ipairs(all) do
    if name ~= one then list[#list + 1] = name end
  end
  return list
end

-- Vertices of a cloth or points of a net, with their velocities.
function problem.points(soft)
  local x, v = soft:positions(), {}
  for i = 1, #x // 3 do
    v[3 * i - 2], v[3 * i - 1], v[3 * i] = soft:velocity(i)
  end
  return { x = x, v = v }
end

-- A cloth as its ladders want it: its own substeps are those of the world, but for explicit methods, which take what their
-- stability needs.
function problem.cloth(solver, iterations, options)
  options.solver, options.damping, options.self_collision, options.max_strain = solver, 0.02, false, false
  if solver ~= "mass_spring" then options.substeps = 1 end
  if iterations > 0 then options.solver_options = { iterations = iterations } end
  return options
end

-- About 60 steps a second: substeps, steps, and iterations of few substeps. A solver that chooses its own substeps needs
-- no more of them, and gets a part of the ladder.
function problem.cloth_ladders(solvers, seconds, substeps)
  local function dt(factor) return seconds / math.ceil(60 * factor * seconds - 1e-9) end
  local middle = (#substeps + 1) // 2
  local few, coarse = table.move(substeps, 1, middle, 1, {}), { dt(0.25), dt(0.5), dt(1) }
  local shed = problem.others(solvers, "mass_spring")
  return {
    { methods = { "mass_spring" }, dt = { dt(1) }, substeps = few },
    { methods = { "mass_spring" }, dt = coarse, substeps = { substeps[middle] } },
    { methods = shed, dt = { dt(1) }, substeps = substeps },
    { methods = shed, dt = { dt(0.25), dt(0.5), dt(1), dt(2), dt(4) }, substeps = { substeps[middle] } },
    { methods = shed, dt = { dt(1) }, substeps = { substeps[2] }, iterations = { 1, 2, 4, 8, 16, 32 } },
  }
end

-- A soft body as its ladders want it: xpbd and mass_spring take the substeps that their stiffness needs, others those of
-- the world.
function problem.soft(solver, iterations, options)
  options.solver, options.self_collision = solver, false
  if solver ~= "xpbd" and solver ~= "mass_spring" then options.substeps = 1 end
  if iterations > 0 then options.solver_options = { iterations = iterations } end
  return options
end

-- About `rate` steps a second: substeps, steps, and sweeps of those that sweep.
function problem.soft_ladders(solvers, seconds, rate, substeps)
  local function dt(factor) return seconds / math.ceil(factor * rate * seconds - 1e-9) end
  local middle = substeps[(#substeps + 1) // 2]
  return {
    { methods = { "xpbd", "mass_spring" }, dt = { dt(1) }, substeps = { substeps[1], middle } },
    { methods = { "vbd", "implicit" }, dt = { dt(1) }, substeps = substeps },
    { dt = { dt(0.5), dt(1), dt(2) }, substeps = { middle } },
    { methods = { "vbd" }, dt = { dt(1) }, substeps = { middle }, iterations = { 1, 2, 4, 8, 16, 32 } },
  }
end

-- What the studies of cloth at rest have in common: the places of rest as reference, the energy there. `cloth_` and
-- `energy_` are functions, as there is no cloth before `build`.
function problem.of_cloth(cloth_, rest, energy_, iterations, declaration)
  declaration.observe = function() return problem.points(cloth_()) end
  declaration.reference = function() return { x = rest, v = problem.zeros(3 * #rest) } end
  declaration.energy = function() return energy_() end
  declaration.constraint = function() return math.max(0, cloth_():stretch()) end
  declaration.interpolate = false
  declaration.sweeps = math.max(1, iterations)
  return declaration
end

-- About a rate of steps a second and four substeps: substeps, steps, and more of what the solver refines by. Those that do
-- not iterate have the parameter `compression` as tolerance.
function problem.fluid_ladders(solvers, seconds, rate)
  local function dt(factor) return seconds / math.ceil(factor * rate * seconds) end
  return {
    { dt = { dt(1) }, substeps = { 1, 2, 4, 8 } },
    { dt = { dt(0.25), dt(0.5), dt(1), dt(2) }, substeps = { 4 } },
    { methods = { "pbf" }, dt = { dt(1) }, substeps = { 4 }, iterations = { 1, 2, 4, 8, 16 } },
    { methods = problem.others(solvers, "pbf"), dt = { dt(1) }, substeps = { 4 }, compression = { 0.1, 0.03, 0.01, 0.003 } },
  }
end

-- The parameters that problems of fluids have, with `particles` across the length that the problem is about; of all
-- solvers, or of those that can do it.
function problem.fluid(particles, t_end, solvers)
  solvers = solvers or feder.choices("fluid.solver")
  local kernels = { "own", table.unpack(feder.choices("fluid.kernel")) }
  local p = {
    solvers = solvers,
    solver = feder.param("solver", solvers[1], { choices = solvers }),
    spacing = 1 / feder.param("particles", particles,
      { min = 5, max = 400, step = 1, help = "across the length that the problem is about" }),
    stiffness = feder.param("stiffness", 0, { min = 0, max = 1e12, help = "bulk modulus for pbf, Pa; 0: as stiff as it can" }),
    compression = feder.param("compression", 0.01, { min = 1e-4, max = 0.2,
      help = "that wcsph aims at; dfsph at a tenth of it on average" }),
    kernel = feder.param("kernel", kernels[1], { choices = kernels, help = "by which particles weigh their neighbours; own: the solver's" }),
    support = feder.param("support", 0, { min = 0, max = 4, help = "its radius in spacings; 0: as the kernel proposes" }),
    iterations = feder.param("iterations", 4, { min = 1, max = 1000, step = 1, help = "of pbf in a substep" }),
    rate = feder.param("rate", 60, { min = 10, max = 10000, step = 1, help = "steps a second" }),
    seconds = feder.param("t_end", t_end, { min = 1e-3, max = 60, help = "s" }),
  }
  p.world = { gravity = { 0, -9.81 }, dt = 1 / p.rate, substeps = 4, dimension = 2, sleeping = false }
  return p
end

-- The fluid of these parameters, with what else it is made of.
function problem.water(world, p, options)
  options.solver, options.spacing, options.stiffness = p.solver, p.spacing, p.stiffness
  options.compression, options.iterations = p.compression, p.iterations
  options.kernel = p.kernel ~= "own" and p.kernel or nil
  options.support = p.support > 0 and p.support or nil
  options.tolerance = 10 * p.compression  -- per cent
  return world:fluid(options)
end

-- What the studies of fluids have in common: a study with its own error and ladders.
function problem.of_fluid(p, fluid_, declaration)
  declaration.tolerance = "compression"
  declaration.interpolate = false
  declaration.sweeps = p.solver == "pbf" and p.iterations or 1
  declaration.ladders = problem.fluid_ladders(p.solvers, p.seconds, p.rate)
  declaration.constraint = function()
    local _, largest = fluid_():density_error()
    return largest
  end
  return declaration
end

-- A block of particles from (x, y), in the plane.
function problem.fill(fluid_, width, height, x, y)
  local d, points = fluid_:spacing(), {}
  local nx, ny = math.floor(width / d + 0.5), math.floor(height / d + 0.5)
  for j = 1, ny do
    for i = 1, nx do points[#points + 1] = { x + (i - 0.5) * width / nx, y + (j - 0.5) * height / ny, 0 } end
  end
  fluid_:fill { points = points }
end

-- A square of n by n particles that lie as those of a fluid that has moved, on no lattice: thrown by up to half a spacing,
-- then led apart (after Colagrossi, Bouscasse, Antuono and Marrone, Comput. Phys. Commun. 183, 2012). Places in spacings.
function problem.packed(n)
  local reach, strength, rounds, seed, at = 2, 0.6, 30, 1, {}
  local function thrown()
    seed = (1103515245 * seed + 12345) % 2147483648
    return seed / 2147483648 - 0.5
  end
  for j = 1, n do
    for i = 1, n do at[#at + 1] = { i - 0.5 + thrown(), j - 0.5 + thrown(), 0 } end
  end
  local row = n // reach + 8
  local function cell(x, y) return (y // reach + 2) * row + x // reach + 2 end
  for _ = 1, rounds do
    -- with the images behind the walls
    local cells = {}
    for _, a in ipairs(at) do
      for _, x in ipairs { a[1], -a[1], 2 * n - a[1] } do
        for _, y in ipairs { a[2], -a[2], 2 * n - a[2] } do
          if math.min(x, y) > -reach and math.max(x, y) < n + reach then
            local c = cell(x, y)
            local list = cells[c] or {}
            list[#list + 1], list[#list + 2], cells[c] = x, y, list
          end
        end
      end
    end
    for _, a in ipairs(at) do
      local x, y, c, u, v = a[1], a[2], cell(a[1], a[2]), 0, 0
      for up = -row, row, row do
        for near = c + up - 1, c + up + 1 do
          local list = cells[near] or {}
          for m = 1, #list, 2 do
            local dx, dy = x - list[m], y - list[m + 1]
            local r = math.sqrt(dx * dx + dy * dy) / reach
            if r > 1e-9 and r < 1 then u, v = u + (1 - r) ^ 3 * dx, v + (1 - r) ^ 3 * dy end
          end
        end
      end
      a[1] = math.max(0.1, math.min(n - 0.1, x + strength * u))
      a[2] = math.max(0.1, math.min(n - 0.1, y + strength * v))
    end
  end
  return at
end

-- Static half-spaces: the floor y = 0, and walls at x = 0 and, when given, x = width.
function problem.tank(world, width)
  world:body { type = "static", shape = feder.plane(0, 1, 0, 0) }
  world:body { type = "static", shape = feder.plane(1, 0, 0, 0) }
  if width then world:body { type = "static", shape = feder.plane(-1, 0, 0, -width) } end
end

-- Mean speed along x of the particles within `band` of y, by height(y of a particle), and 0.6 m of `middle` along x.
function problem.band_speed(water, middle, y, band, height)
  local x, v, sum, n = water:positions(), water:velocities(), 0, 0
  for i = 1, #x, 3 do
    if math.abs(x[i] - middle) <= 0.6 and math.abs(height(x[i + 1]) - y) <= band then sum, n = sum + v[i], n + 1 end
  end
  return n > 0 and sum / n or 0
end

-- The damped swing e^(-rate t) (c cos(w t) + s sin(w t)) next to values at times, by least squares: w and rate, 1/s.
-- A compass search from w = frequency and rate = 0, c and s in closed form.
function problem.swing(times, values, frequency)
  local function misfit(w, rate)
    local cc, cs, ss, cx, sx, xx = 0, 0, 0, 0, 0, 0
    for i, t in ipairs(times) do
      local c, s, x = math.exp(-rate * t), math.sin(w * t), values[i]
      c, s = c * math.cos(w * t), c * s
      cc, cs, ss, cx, sx, xx = cc + c * c, cs + c * s, ss + s * s, cx + c * x, sx + s * x, xx + x * x
    end
    local determinant = cc * ss - cs * cs
    if determinant <= 0 then return xx end
    return xx - (cx * cx * ss - 2 * cx * sx * cs + sx * sx * cc) / determinant
  end
  local w, rate, step = frequency, 0, 0.1 * frequency
  local best = misfit(w, rate)
  while step > 1e-7 * frequency do
    local moved = false
    for _, way in ipairs { { 1, 0 }, { -1, 0 }, { 0, 1 }, { 0, -1 } } do
      local u, r = w + step * way[1], rate + step * way[2]
      local found = misfit(u, r)
      if u > 0.2 * frequency and found < best then w, rate, best, moved = u, r, found, true end
    end
    if not moved then step = step / 2 end
  end
  return w, rate
end

-- Of such a swing: its period by that of `frequency`, and the share of its height that it loses in a period (below 0: it
-- grows). Nil before there is enough to tell.
function problem.period_and_loss(times, values, frequency)
  if #times < 4 then return end
  local w, rate = problem.swing(times, values, frequency)
  return frequency / w, 1 - math.exp(-2 * math.pi * rate / w)
end

-- The parameter that says of what their studies are.
function problem.swing_quantity()
  return feder.param("quantity", "period", { choices = { "period", "loss" },
    help = "whose error it is: the period's, or the share of the height that is lost in a period" })
end

-- Its error; 1 where there is nothing to tell it from.
function problem.swing_error(quantity, times, values, frequency)
  local period, loss = problem.period_and_loss(times, values, frequency)
  return math.abs(not period and 1 or quantity == "loss" and loss or period - 1)
end

-- A drop without gravity, drawn out along x and let go, as a scene: it passes its circle or sphere after a quarter and
-- after three quarters of a period. In the plane, or in space: p.world.dimension. options: title, tension in N/m.
function problem.swinging_drop(p, options)
  local radius, stretch, dimension = 0.5, 0.15, p.world.dimension  -- m, of the radius
  local frequency = fluid.swing(options.tension, 1000, radius, dimension)
  p.world.gravity = { 0, 0 }
  local drop, start, before, passages
  local function error_now()
    if #passages < 2 then return 1 end  -- has not come back
    return math.abs((passages[2] - passages[1]) * frequency / math.pi - 1)
  end
  return {
    title = options.title,
    seconds = p.seconds,
    world = p.world,

    study = problem.of_fluid(p, function() return drop end, {
      -- how much longer along x than across, by what it was at the start
      observe = function() return fluid.elongation(drop, dimension) / start end,
      reference = function(t) return math.cos(frequency * t) end,
      error = error_now,
      scale = { length = 1, velocity = frequency * stretch },
      certainty = { source = "half a period pi / w between two passages through the "
          .. (dimension == 3 and "sphere, w^2 = 8" or "circle, w^2 = 6") .. " sigma / (rho R^3)",
        uncertainty = stretch * stretch,  -- the next term is of the order of the square of the stretch
        resolution = 4 * p.spacing },
    }),

    build = function(world)
      -- what damps particles lets them freeze to a lattice, which is stiff
      drop = problem.water(world, p, { name = "drop", surface_tension = options.tension, artificial_viscosity = 0 })
      drop:fill { points = fluid.drop(radius, p.spacing, 1 + stretch, dimension) }
      start, passages = fluid.elongation(drop, dimension), {}
      before = { t = 0, x = start }
    end,

    update = function(world)
      local x, t, was = fluid.elongation(drop, dimension), world:time(), before
      if was.x * x <= 0 then passages[#passages + 1] = was.t + (t - was.t) * was.x / (was.x - x) end
      before = { t = t, x = x }
    end,

    check = function(world, _, expect)
      expect(world:is_finite())
      expect(#passages >= 1, "the drop does not swing")
      local px, py, pz = world:momentum()
      expect(math.abs(px) + math.abs(py) + math.abs(pz) < 1e-2, "the drop moves as a whole")
    end,
  }
end

-- Puts vertices to their places of rest; the root mean square of how far they are from there.
function problem.place(soft, rest)
  for i, x in ipairs(rest) do soft:set_point(i, x[1], x[2], x[3]) end
end
function problem.distance(soft, rest)
  local x, sum = soft:positions(), 0
  for i, at in ipairs(rest) do
    for k = 1, 3 do sum = sum + (x[3 * i - 3 + k] - at[k]) ^ 2 end
  end
  return math.sqrt(sum / #rest)
end

-- Kinetic, potential and elastic together, J.
function problem.energy(world)
  local kinetic, potential, elastic = world:energy()
  return kinetic + potential + elastic
end

-- The middle of [lo, hi] where the rising function f passes 0, halved until no number is between.
function problem.root(f, lo, hi)
  for _ = 1, 200 do
    local middle = (lo + hi) / 2
    if f(middle) < 0 then lo = middle else hi = middle end
  end
  return (lo + hi) / 2
end

-- One step of y' = f(t, y) by extrapolation of the modified midpoint rule with 2, 4 ... 16 substeps (Gragg 1965; Hairer,
-- Norsett and Wanner, Solving Ordinary Differential Equations I, 1993, II.9). Nil where the columns do not agree.
local function extrapolate(f, t, y, h)
  local table_, n = {}, #y
  local start = f(t, y)
  for row = 1, 8 do
    local parts = 2 * row
    local s, before, now = h / parts, y, {}
    for i = 1, n do now[i] = y[i] + s * start[i] end
    for m = 1, parts - 1 do
      local slope, next_ = f(t + m * s, now), {}
      for i = 1, n do next_[i] = before[i] + 2 * s * slope[i] end
      before, now = now, next_
    end
    local slope, value, worst = f(t + h, now), {}, 0
    for i = 1, n do value[i] = (before[i] + now[i] + s * slope[i]) / 2 end
    for column = 1, row - 1 do
      local ratio = (parts / (2 * (row - column))) ^ 2
      for i = 1, n do
        local better = value[i] + (value[i] - table_[column][i]) / (ratio - 1)
        table_[column][i], value[i] = value[i], better
      end
    end
    for i = 1, n do
      if row > 1 then worst = math.max(worst, math.abs(value[i] - table_[row - 1][i]) / (1 + math.abs(value[i]))) end
    end
    table_[row] = value
    if row > 3 and worst < 1e-15 then return value end
  end
end

-- The motion y' = f(t, y) from y(0): a function of t, which keeps the states at 256 equal distances over `seconds`.
function problem.motion(f, start, seconds)
  local kept, distance = { [0] = start }, seconds / 256
  local function advance(y, from, to)
    local h = to - from
    while from < to - 1e-14 * seconds do
      h = math.min(h, to - from)
      local next_ = extrapolate(f, from, y, h)
      if next_ or h < 1e-9 * seconds then
        from, y = from + h, next_ or y
      else
        h = h / 2
      end
    end
    return y
  end
  return function(t)
    local k = math.floor(t / distance + 1e-9)
    for i = #kept + 1, k do kept[i] = advance(kept[i - 1], (i - 1) * distance, i * distance) end
    return t - k * distance < 1e-9 * distance and kept[k] or advance(kept[k], k * distance, t)
  end
end

-- Columns of the rotation of a quaternion x, y, z, w: where the body's axes point.
function problem.axes(x, y, z, w)
  return { 1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w) },
    { 2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w) },
    { 2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y) }
end

function problem.cross(a, b)
  return { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] }
end

-- A rigid body about a fixed point (Euler 1758): I dw/dt = (I w) x w + torque in body axes, which are principal; the
-- centre of mass lies on the second one, and `weight`, m g times its distance in N m, pulls along -y (0: free). State:
-- w in body axes, then the quaternion x, y, z, w. Returns a function of t: quaternion, w in world axes.
function problem.top(inertia, weight, start, seconds)
  local a, b, c = inertia[1], inertia[2], inertia[3]
  local motion = problem.motion(function(_, s)
    local p, q, r, x, y, z, w = s[1], s[2], s[3], s[4], s[5], s[6], s[7]
    -- up in body axes is the middle row of the rotation
    local up_x, up_z = 2 * (x * y + z * w), 2 * (y * z - x * w)
    return {
      ((b - c) * q * r - weight * up_z) / a, (c - a) * r * p / b, ((a - b) * p * q + weight * up_x) / c,
      (w * p + y * r - z * q) / 2, (w * q + z * p - x * r) / 2, (w * r + x * q - y * p) / 2,
      -(x * p + y * q + z * r) / 2,
    }
  end, start, seconds)
  return function(t)
    local s = motion(t)
    local quaternion, omega, axes = { s[4], s[5], s[6], s[7] }, { 0, 0, 0 }, { problem.axes(s[4], s[5], s[6], s[7]) }
    for k = 1, 3 do
      for i = 1, 3 do omega[i] = omega[i] + s[k] * axes[k][i] end
    end
    return quaternion, omega, s
  end
end

return problem
