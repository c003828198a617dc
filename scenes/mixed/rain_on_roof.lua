-- Rain on a sloping tarpaulin: it sags under the water, sheds it into a trough, and keeps dry what is below.
local feder = require "feder"

local drops = feder.param("drops", 700, { min = 100, max = 3000, help = "particles of rain" })
local slope = feder.param("slope", 18, { min = 10, max = 40, help = "degrees" })
local spacing = 0.035
local long, wide, eaves = 1.8, 1.2, 0.9  -- of the roof along and across the slope, height of its lower edge, m

return feder.scene {
  title = "Rain on a roof",
  seconds = 8,
  camera = { target = { 0.3, 0.8, 0 }, distance = 4.6, yaw = feder.deg(25), pitch = feder.deg(16) },
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    local angle = feder.deg(slope)
    local reach, rise = long * math.cos(angle), long * math.sin(angle)
    local middle = eaves + rise / 2
    world:body { name = "ground", type = "static", shape = feder.plane() }
    scene.roof = world:cloth { name = "roof", size = { long, wide }, resolution = { 25, 17 }, area_density = 0.6,
      stretch = 20000, damping = 0.01, thickness = 0.01, friction = 0.3, self_collision = false, wind = false,
      color = "#c9772b", position = { 0, middle, 0 }, rotation = { axis = { 0, 0, 1 }, angle = -angle },
      pins = { "left", "right", "top", "bottom" } }
    for _, side in ipairs { -1, 1 } do
      for _, stand in ipairs { { -reach / 2, eaves + rise }, { reach / 2, eaves } } do
        world:body { type = "static", shape = feder.cylinder(0.025, stand[2] - 0.02), color = "#6b5a48",
          position = { stand[1], stand[2] / 2 - 0.01, side * wide / 2 } }
      end
    end
    -- a cat's box of crates below, to be kept dry
    scene.crates = {}
    for i = 1, 3 do
      scene.crates[i] = world:body { name = "crate" .. i, shape = feder.box(0.28, 0.28, 0.28), density = 300,
        color = "#8a6f4d", position = { -0.35 + 0.32 * (i - 1), 0.14, 0.1 * (i - 2) } }
    end
    local w, h, t = 1.0, 0.45, 0.03
    local x = reach / 2 + w / 2 - 0.05
    scene.trough = { lo = x - w / 2, hi = x + w / 2, z = wide / 2 + 0.1 }
    world:body { name = "trough", type = "static", color = "#7d8a92", shape = feder.compound {
      { shape = feder.box(w, t, 2 * scene.trough.z), position = { x, t / 2, 0 } },
      { shape = feder.box(t, h, 2 * scene.trough.z), position = { x - w / 2, h / 2, 0 } },
      { shape = feder.box(t, h + 0.5, 2 * scene.trough.z), position = { x + w / 2, (h + 0.5) / 2, 0 } },
      { shape = feder.box(w, h, t), position = { x, h / 2, -scene.trough.z } },
      { shape = feder.box(w, h, t), position = { x, h / 2, scene.trough.z } },
    } }
    scene.rain = world:fluid { name = "rain", spacing = spacing, viscosity = 0.1, max_particles = drops + 50 }
    for _, at in ipairs { { -0.5, 1 }, { 0.1, 0.9 } } do
      scene.rain:emitter { position = { at[1] * reach / 1.7, middle + at[2], 0 }, direction = { 0, -1, 0 }, speed = 0.6,
        radius = 0.3, rate = drops / 8, limit = drops // 2 }
    end
    scene.heaviest, scene.woken, scene.done = 0, 0, 0
    world:on("wake", function(e) if e.cause == "fluid" then scene.woken = scene.woken + 1 end end)
    world:on("emitter_done", function(e) scene.done = scene.done + e.count end)
  end,

  update = function(world, scene)
    local force = world:residuals()["fluid_cloth.force_n"] or 0
    scene.mean = (scene.mean or 0) * 0.95 + 0.05 * force
    scene.heaviest = math.max(scene.heaviest, scene.mean)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.done == 2 * (drops // 2), ("%d drops have come"):format(scene.done))
    expect(scene.rain:count() == scene.done, "rain has gone")
    expect(scene.heaviest > 2, ("the rain pressed on the roof with %.2f N at most"):format(scene.heaviest))
    -- nothing has come through: below the roof, away from the trough, it is dry
    local x = scene.rain:positions()
    local wet, held = 0, 0
    for i = 1, #x, 3 do
      if math.abs(x[i + 2]) < wide / 2 and x[i] < scene.trough.lo - 0.1 and x[i] > -0.8 and x[i + 1] < 0.7 then wet = wet + 1 end
      if x[i] > scene.trough.lo and x[i] < scene.trough.hi then held = held + 1 end
    end
    expect(wet == 0, ("%d drops came through the roof"):format(wet))
    expect(held > 0.7 * scene.done, ("only %d of %d drops are in the trough"):format(held, scene.done))
    expect(scene.roof:stretch() < 0.05, ("the roof is stretched by %.1f %%"):format(100 * scene.roof:stretch()))
  end,
}
