-- A net held at its four corners sags under its own weight: at rest the corners carry exactly that weight, and the
-- sag has the net's symmetry.
local feder = require "feder"
local build = require "feder.build"

local cells = feder.param("cells", 12, { min = 4, max = 40, step = 2 })
local integrator = feder.param("integrator", "symplectic_euler",
  { choices = { "symplectic_euler", "velocity_verlet", "implicit_euler" } })

local gravity, mass, stiffness = 9.81, 0.02, 400

return feder.scene {
  title = "Hanging net",
  seconds = 10,
  -- in vacuum, as springs alone are looked at
  world = { gravity = { 0, -gravity, 0 }, dt = 1 / 60, substeps = 8, air_density = 0 },

  build = function(world, scene)
    local n = cells + 1
    local points, springs, faces = build.grid {
      count = { n, n }, size = { 2, 2 }, position = { 0, 2, 0 }, stiffness = stiffness, damping = 0.2,
    }
    scene.corners = { 1, n, n * (n - 1) + 1, n * n }
    scene.points, scene.springs = points, springs
    scene.net = world:net { name = "net", points = points, springs = springs, faces = faces, masses = mass,
      damping = 1, integrator = integrator }
    for _, i in ipairs(scene.corners) do scene.net:pin(i) end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    local n, held = cells + 1, {}
    for _, i in ipairs(scene.corners) do held[i] = true end

    -- vertical pull of the springs on the corners against the weight of the free points
    local pull = 0
    for k, s in ipairs(scene.springs) do
      local i, j = s[1], s[2]
      if held[j] then i, j = j, i end
      if held[i] and not held[j] then
        local xi, yi, zi = scene.net:point(i)
        local xj, yj, zj = scene.net:point(j)
        local dx, dy, dz = xj - xi, yj - yi, zj - zi
        local now = math.sqrt(dx * dx + dy * dy + dz * dz)
        local rest = now / (1 + scene.net:strain(k))
        pull = pull - stiffness * (now - rest) * dy / now
      end
    end
    local weight = (n * n - 4) * mass * gravity
    expect(math.abs(pull / weight - 1) < 0.01, ("the corners carry %.4f N of %.4f N"):format(pull, weight))

    local kinetic = world:energy()
    expect(kinetic < 1e-4 * weight, ("not at rest: %.2e J"):format(kinetic))

    -- the middle hangs lowest; mirrored points hang alike
    local middle = (n * n + 1) / 2
    local _, lowest = scene.net:point(middle)
    expect(lowest < 1.9, ("the middle should sag, it is at %.3f m"):format(lowest))
    for j = 1, n do
      for i = 1, n do
        local _, y = scene.net:point((j - 1) * n + i)
        local _, mirrored = scene.net:point((n - j) * n + (n + 1 - i))
        expect(y >= lowest - 1e-3, "a point hangs below the middle")
        expect(math.abs(y - mirrored) < 5e-3, ("points (%d, %d) and its mirror hang unlike"):format(i, j))
      end
    end
  end,
}
