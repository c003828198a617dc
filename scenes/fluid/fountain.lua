-- A fountain: jets rise by v^2 / (2 g) and fall back into a basin; what runs over its weir is drained into a tank, from
-- which the pump feeds the jets. In the end as much runs over as is pumped up, and the water in sight is constant.
local feder = require "feder"

local spacing = feder.param("spacing", 0.05, { min = 0.04, max = 0.06, help = "m" })
local speed = feder.param("speed", 3.4, { min = 3.2, max = 4, help = "of the water at the nozzles, m/s" })
local lean = feder.param("lean", 12, { min = 10, max = 16, help = "of the jets, degrees from upright" })
local stock = feder.param("stock", 1500, { min = 800, max = 3000, help = "particles in the tank at the start" })

local half, level, high, wall = 0.55, 0.15, 0.28, 0.06  -- of the basin: half of its side, its weir, its rim, its walls, m
local channel = 0.16                                    -- width of the channel behind the weir, m
local nozzle, ring, jets = 0.32, 0.08, 4                -- height of the nozzles, how far they are from the axis, m
local from = 5                                          -- when as much comes as goes, s
local angle = feder.deg(lean)

return feder.scene {
  title = "Fountain",
  seconds = 8,
  picture = 3,
  camera = { target = { -0.05, 0.35, 0 }, distance = 2.9, yaw = feder.deg(-35), pitch = feder.deg(28) },
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    local function block(name, x0, x1, y0, y1, z0, z1)
      world:body { name = name, type = "static", shape = feder.box(x1 - x0, y1 - y0, z1 - z0), color = "#b5b0a5",
        position = { (x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2 } }
    end
    local left, out = -half - wall - channel, half + wall
    world:body { name = "lawn", type = "static", shape = feder.plane(0, 1, 0, -wall), color = "#8fa37a" }
    block("floor", left - wall, out, -wall, 0, -out, out)
    block("weir", -half - wall, -half, 0, level, -half, half)
    block("left", left - wall, left, 0, high, -out, out)
    block("right", half, out, 0, high, -out, out)
    block("back", left, half, 0, high, -out, -half)
    block("front", left, half, 0, high, half, out)
    world:body { name = "pillar", type = "static", shape = feder.cylinder(0.14, nozzle - 0.03), color = "#9a948a",
      position = { 0, (nozzle - 0.03) / 2, 0 } }

    scene.water = world:fluid { name = "water", spacing = spacing, viscosity = 0.001 }
    scene.filled = scene.water:fill { box = { { -half, 0, -half }, { half, level, half } } }
    scene.jets = {}
    for k = 1, jets do
      local turn = 2 * math.pi * (k - 0.5) / jets
      local c, s = math.cos(turn), math.sin(turn)
      scene.jets[k] = scene.water:emitter { name = "jet" .. k, position = { ring * c, nozzle, ring * s }, speed = speed,
        direction = { math.sin(angle) * c, math.cos(angle), math.sin(angle) * s }, radius = spacing / 2 }
    end
    scene.outlet = scene.water:drain { box = { { left, 0, -half }, { -half - wall, 0.08, half } } }
    -- what is splashed over the rim soaks into the lawn
    scene.lawn = scene.water:drain { box = { { -9, -wall, -9 }, { 9, -wall + 0.03, 9 } } }
    scene.top, scene.steps = 0, 0
    world:on("warning", function(e) scene.said = e.message end)
  end,

  update = function(world, scene)
    scene.pumped = 0
    for _, jet in ipairs(scene.jets) do scene.pumped = scene.pumped + jet:count() end
    -- the pump stops when the tank is empty
    scene.tank = stock + scene.outlet:count() - scene.pumped
    for _, jet in ipairs(scene.jets) do
      if scene.tank < jets then jet:stop() else jet:start() end
    end
    feder.plot("in sight", scene.water:count())
    feder.plot("in the tank", scene.tank)
    if world:time() < from then return end
    scene.first = scene.first or { pumped = scene.pumped, gone = scene.outlet:count() + scene.lawn:count(), count = scene.water:count() }
    local p, top = scene.water:positions(), 0
    for i = 2, #p, 3 do top = math.max(top, p[i] - nozzle) end
    scene.top, scene.steps = scene.top + top, scene.steps + 1
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(not scene.said, scene.said)
    expect(scene.water:count() == scene.filled + scene.pumped - scene.outlet:count() - scene.lawn:count(), "particles are missing")
    local rise, wanted = scene.top / scene.steps, (speed * math.cos(angle)) ^ 2 / (2 * 9.81)
    local pumped, gone = scene.pumped - scene.first.pumped, scene.outlet:count() + scene.lawn:count() - scene.first.gone
    -- falling water hinders what rises
    expect.error(math.abs(rise / wanted - 1), "<", 0.1, "height of the jets")
    expect.error(math.abs(gone / pumped - 1), "<", 0.12, "what has run off, by what was pumped")
    expect.error(math.abs(scene.water:count() / scene.first.count - 1), "<", 0.04, "change of the water in sight")
    expect(scene.tank >= jets, "the tank is empty")
  end,
}
