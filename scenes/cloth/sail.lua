-- A sail pinned along its mast, flush with the wood, and held at its clew: it fills in the wind, its leech flies.
local feder = require "feder"

local wind = feder.param("wind", 9.5, { min = 0, max = 14, help = "m/s" })
local gap = feder.param("gap", 0, { min = -0.02, max = 0.02, help = "of the pins from the wood, m" })

local width, height, mast = 2, 2.4, 0.05

return feder.scene {
  title = "Sail",
  seconds = 4,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { type = "static", shape = feder.plane() }
    world:body { name = "mast", type = "static", shape = feder.cylinder(mast, 4), position = { 0, 2, 0 }, color = "#8a6a45" }
    scene.sail = world:cloth { name = "sail", size = { width, height }, resolution = { 17, 21 }, color = "#ece6d8",
      position = { mast + gap + width / 2, 2.4, 0 }, rotation = { axis = { 1, 0, 0 }, angle = feder.deg(90) },
      pins = { "left", "bottom_right" }, area_density = 0.4, stretch = 40000, shear = 10000, bend = 8e-5,
      thickness = 0.012, self_collision = false }
    world:force { kind = "wind", velocity = { 0.3 * wind, 0, -0.95 * wind } }
    world:on("warning", function(e) scene.warned = e.code end)
    scene.most, scene.sum = 0, 0
  end,

  update = function(world, scene)
    local work = world:report().counts.cloth_row_updates
    scene.most, scene.sum = math.max(scene.most, work), scene.sum + work
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.sail:stretch() < 0.15, ("the sail is stretched by %.1f %%"):format(100 * scene.sail:stretch()))
    local mean = scene.sum / world:report().steps
    expect(scene.most < 5 * mean, ("a step took %.1f times the work of the mean"):format(scene.most / mean))
    if gap >= 0 then expect(not scene.warned, ("a warning: %s"):format(scene.warned)) end
    local belly, inside = 0, 0
    for i = 1, scene.sail:count() do
      local x, _, z = scene.sail:point(i)
      belly = math.min(belly, z)
      if i % 17 ~= 1 then inside = math.max(inside, mast - math.sqrt(x * x + z * z)) end
    end
    expect(inside < 0.002, ("a vertex lies %.1f mm inside the mast"):format(1000 * inside))
    if wind > 5 then expect(belly < -0.1, ("the belly is %.2f m deep only"):format(-belly)) end
  end,
}
