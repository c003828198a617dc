-- A sail boat: the wind fills a sail that is sewn to the mast and the boom of a floating hull, and drives it over the
-- water.
local feder = require "feder"
local fluid = require "feder.fluid"

local wind = feder.param("wind", 6, { min = 0, max = 12, help = "from astern, m/s" })
local spacing = feder.param("spacing", 0.1, { min = 0.05, max = 0.12, help = "of the particles of water, m" })

local long, wide, level = 4, 1.2, 0.5  -- of the basin, and the height of the water, m

return feder.scene {
  title = "Sail boat",
  seconds = 4,
  picture = 2,
  camera = { target = { 1.9, 0.85, 0.6 }, distance = 4.6, yaw = feder.deg(25), pitch = feder.deg(16) },

  build = function(world, scene)
    fluid.tank(world, long, 0.7, wide, 0.1)
    scene.water = world:fluid { name = "water", spacing = spacing }
    scene.water:fill { box = { { 0, 0, 0 }, { long, level, wide } } }

    -- hull, mast and boom are one body; its centre of mass lies low, as ballast in a keel would put it
    scene.boat = world:body { name = "boat", color = "wood", mass = 22, center_of_mass = { 0, -0.08, 0 },
      position = { 0.6, level + 0.08, wide / 2 }, lock = { "ry" }, shape = feder.compound {
        { shape = feder.box(0.8, 0.22, 0.36) },
        { shape = feder.cylinder(0.02, 1.1), position = { 0.05, 0.65, 0 } },
        { shape = feder.box(0.03, 0.03, 0.7), position = { 0.05, 0.3, 0 } },
      } }

    -- A sheet lies in the xz plane. This turn takes x to z, z to y and y to x: it stands upright, across the boat
    local columns, rows = 9, 9
    scene.sail = world:cloth { name = "sail", size = { 0.66, 0.8 }, resolution = { columns, rows }, area_density = 0.3,
      color = "white", position = { 0.69, level + 0.8, wide / 2 }, self_collision = false,
      rotation = { axis = { 1, 1, 1 }, angle = feder.deg(-120) } }
    -- sewn at its four corners and along the foot: attached where it is
    for i = 1, columns do
      scene.sail:attach(i, scene.boat)
      scene.sail:attach((rows - 1) * columns + i, scene.boat)
    end
    world:force { kind = "wind", velocity = { wind, 0, 0 }, on = scene.sail }
  end,

  update = function(world, scene)
    local x, y = scene.boat:position()
    feder.plot("boat x", x)
    scene.lowest = math.min(scene.lowest or y, y)
  end,

  check = function(world, scene, expect)
    local x = scene.boat:position()
    expect(x > (wind >= 5 and 1.2 or 0.3), ("the boat sailed %.2f m only"):format(x - 0.6))
    expect(scene.lowest > level - 0.1, "the boat sinks")
    local _, _, _, w = scene.boat:rotation()
    expect(w > 0.9, "the boat has capsized")
    expect(scene.sail:stretch() < 0.1, ("the sail is stretched by %.0f %%"):format(100 * scene.sail:stretch()))
  end,
}
