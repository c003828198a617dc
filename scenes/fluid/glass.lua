-- A glass of water stands on a table for a while: fine-grained still water stays still.
local feder = require "feder"

local spacing = feder.param("spacing", 0.006, { min = 0.004, max = 0.016, help = "m" })
local wide, high, wall, level = 0.08, 0.15, 0.006, 0.12  -- of the glass inside, and of the water, m

return feder.scene {
  title = "Glass of water",
  seconds = 1.5,
  camera = { yaw = feder.deg(30), pitch = feder.deg(60) },
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { name = "table", type = "static", shape = feder.box(0.5, 0.02, 0.5), position = { 0, -wall - 0.01, 0 } }
    local out = wide + 2 * wall
    world:body {
      name = "glass", type = "static",
      shape = feder.compound {
        { shape = feder.box(out, wall, out), position = { 0, -wall / 2, 0 } },
        { shape = feder.box(wall, high, out), position = { -wide / 2 - wall / 2, high / 2, 0 } },
        { shape = feder.box(wall, high, out), position = { wide / 2 + wall / 2, high / 2, 0 } },
        { shape = feder.box(wide, high, wall), position = { 0, high / 2, -wide / 2 - wall / 2 } },
        { shape = feder.box(wide, high, wall), position = { 0, high / 2, wide / 2 + wall / 2 } },
      },
    }
    scene.water = world:fluid { name = "water", spacing = spacing, viscosity = 0.001 }
    scene.count = scene.water:fill { box = { { -wide / 2, 0, -wide / 2 }, { wide / 2, level, wide / 2 } } }
    scene.top = 0
    world:on("warning", function(e) scene.said = e.message end)
  end,

  update = function(world, scene)
    local x = scene.water:positions()
    for i = 2, #x, 3 do scene.top = math.max(scene.top, x[i]) end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(not scene.said, scene.said)
    expect(scene.water:count() == scene.count, "particles are missing")
    expect(scene.top < level + 2 * spacing, ("a particle was %.3f m high"):format(scene.top))
    local full = scene.count * spacing ^ 3 / wide ^ 2
    local height = scene.water:height_at(0, 0)
    expect(height and math.abs(height - full) < spacing, ("the water stands at %s m instead of %.4f"):format(height, full))
    local v, most = scene.water:velocities(), 0
    for i = 1, #v, 3 do most = math.max(most, v[i] ^ 2 + v[i + 1] ^ 2 + v[i + 2] ^ 2) end
    expect(math.sqrt(most) < 0.4 * math.sqrt(9.81 * level), ("still water runs at %.2f m/s"):format(math.sqrt(most)))
  end,
}
