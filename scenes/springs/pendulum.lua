-- A mass on a stiff spring, let go at an angle: its period is that of the pendulum with the same swing,
-- T = 2 pi sqrt(L/g) / agm(1, cos(angle/2)), from the arithmetic-geometric mean. Needs no bodies and no contacts.
local feder = require "feder"
local build = require "feder.build"

local angle = feder.param("angle", 90, { min = 5, max = 150, help = "degrees from the vertical" })
local length = feder.param("length", 1, { min = 0.2, max = 5, help = "metres" })
local integrator = feder.param("integrator", "symplectic_euler",
  { choices = { "symplectic_euler", "velocity_verlet", "leapfrog", "yoshida4", "rk4", "rk45", "bdf2", "tr_bdf2" } })

local gravity, stiffness, mass = 9.81, 1e5, 1

local function period()
  local a, b = 1, math.cos(feder.deg(angle) / 2)
  for _ = 1, 30 do a, b = (a + b) / 2, math.sqrt(a * b) end
  return 2 * math.pi * math.sqrt(length / gravity) / a
end

return feder.scene {
  title = "Pendulum",
  seconds = 12,
  world = { gravity = { 0, -gravity, 0 }, dt = 1 / 240, substeps = 8 },

  -- feder study: where the same pendulum is with steps 64 times finer
  study = { axes = { dt = { from = 1 / 60, to = 1 / 960, factor = 2 } } },

  build = function(world, scene)
    local a = feder.deg(angle)
    local points, springs = build.chain {
      to = { length * math.sin(a), -length * math.cos(a), 0 }, count = 2, stiffness = stiffness,
    }
    scene.net = world:net { name = "pendulum", points = points, springs = springs, masses = mass,
      integrator = integrator }
    scene.net:pin(1)
    scene.crossings = {}
    scene.energy = 0
    scene.last = points[2][1]
  end,

  -- when the bob comes through the middle towards +x
  update = function(world, scene)
    local x = scene.net:point(2)
    if scene.last < 0 and x >= 0 then
      local back = x / (x - scene.last) * (1 / 240)
      scene.crossings[#scene.crossings + 1] = world:time() - back
    end
    scene.last = x
  end,

  check = function(world, scene, expect)
    local n = #scene.crossings
    expect(n >= 2, "the pendulum does not swing")
    if n < 2 then return end
    local measured = (scene.crossings[n] - scene.crossings[1]) / (n - 1)
    expect(math.abs(measured / period() - 1) < 1e-3,
      ("period %.5f s, expected %.5f s"):format(measured, period()))
    -- released at rest: kinetic + potential + elastic stays what the height was
    local kinetic, potential, elastic = world:energy()
    local start = -mass * gravity * length * math.cos(feder.deg(angle))
    expect(math.abs(kinetic + potential + elastic - start) < 5e-3 * mass * gravity * length,
      ("energy %.4f J, expected %.4f J"):format(kinetic + potential + elastic, start))
    local x, y, z = scene.net:point(1)
    expect(x == 0 and y == 0 and z == 0, "the pinned point moved")
  end,
}
