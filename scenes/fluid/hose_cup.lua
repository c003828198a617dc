-- A hose fills a cup, the cup is carried and shaken, and not a drop gets through its walls.
local feder = require "feder"

local particles = feder.param("particles", 900, { min = 100, max = 5000 })
local spacing = 0.03
local inside, high, wall = 0.4, 0.4, 0.05  -- of the cup, m

return feder.scene {
  title = "Hose and cup",
  seconds = 6,
  camera = { yaw = feder.deg(30), pitch = feder.deg(48) },
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    local half, out = inside / 2, inside + 2 * wall
    scene.cup = world:body {
      name = "cup", type = "kinematic",
      shape = feder.compound {
        { shape = feder.box(out, wall, out), position = { 0, -wall / 2, 0 } },
        { shape = feder.box(wall, high, out), position = { -half - wall / 2, high / 2, 0 } },
        { shape = feder.box(wall, high, out), position = { half + wall / 2, high / 2, 0 } },
        { shape = feder.box(inside, high, wall), position = { 0, high / 2, -half - wall / 2 } },
        { shape = feder.box(inside, high, wall), position = { 0, high / 2, half + wall / 2 } },
      },
    }
    scene.water = world:fluid { name = "water", spacing = spacing, viscosity = 0.5, max_particles = 5000 }
    scene.hose = scene.water:emitter { name = "hose", position = { 0, 0.8, 0 }, direction = { 0, -1, 0 }, speed = 1,
      radius = 0.07, rate = 400, limit = particles }
    scene.done, scene.shaken = nil, 0
    world:on("emitter_done", function(e) scene.done = e.count end)
    -- half a second after the hose: sideways by 3 cm, three times in two seconds
    world:task(function()
      feder.wait_for("emitter_done")
      feder.wait(0.5)
      local start = world:time()
      while true do
        local t = world:time() - start
        scene.cup:move_to(0.03 * math.sin(2 * math.pi * 1.5 * t) * math.min(1, t), 0, 0)
        scene.shaken = t
        feder.wait(0)
      end
    end)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.done == particles, "the hose has not given what it should")
    expect(scene.water:count() == particles, "water has gone")
    expect(scene.shaken > 1, "the cup was not shaken")
    local cx, cy, cz = scene.cup:position()
    local x = scene.water:positions()
    local held = 0
    for i = 1, #x, 3 do
      local dx, dy, dz = x[i] - cx, x[i + 1] - cy, x[i + 2] - cz
      if math.abs(dx) < inside / 2 and math.abs(dz) < inside / 2 and dy > 0 then held = held + 1 end
      expect(dy > 0 or math.abs(dx) > inside / 2 + wall or math.abs(dz) > inside / 2 + wall, "a particle went through the bottom")
    end
    expect(held == particles, ("%d of %d particles are in the cup"):format(held, particles))
    -- as much as its particles fill, within a spacing
    local want = particles * spacing ^ 3 / inside ^ 2
    local sum, n = 0, 0
    for k = -2, 2 do
      local y = scene.water:height_at(cx + k * 0.08, cz)
      if y then sum, n = sum + y, n + 1 end
    end
    expect(n == 5 and math.abs(sum / n - want) < 1.5 * spacing, ("the water stands %.3f m high, expected %.3f"):format(sum / math.max(n, 1), want))
  end,
}
