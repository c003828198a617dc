-- A siphon: a tube over the rim between two tanks, full at the start. Where water bears suction it runs over the rim
-- until the levels are equal; where it does not it falls back to both sides.
local feder = require "feder"

local spacing = feder.param("spacing", 0.03, { min = 0.015, max = 0.03, help = "m" })
local tears = feder.param("tears", false, { help = "water that bears no suction" })

local wall, bore, gap = 0.04, 0.12, 0.14      -- of the tube: its walls, its width, and what is free below it, m
local left, right, rim = 0.8, 0.9, 0.6        -- sides and top of what parts the tanks
local high, low, far = 0.5, 0.24, 1.7         -- levels at the start, and the other end, m

return feder.scene {
  title = "Siphon",
  seconds = 9,
  world = { gravity = { 0, -9.81 }, dt = 1 / 60, substeps = 4, dimension = 2, sleeping = false },

  build = function(world, scene)
    local function block(x0, y0, x1, y1)
      world:body { type = "static", shape = feder.box(x1 - x0, y1 - y0, 1), position = { (x0 + x1) / 2, (y0 + y1) / 2 } }
    end
    block(-wall, -wall, far + wall, 0)
    block(-wall, 0, 0, 1)
    block(far, 0, far + wall, 1)
    block(left, 0, right, rim)
    block(left - bore - wall, gap, left - bore, rim + bore + wall)
    block(right + bore, gap, right + bore + wall, rim + bore + wall)
    block(left - bore, rim + bore, right + bore, rim + bore + wall)
    scene.water = world:fluid { name = "water", spacing = spacing, negative_pressure = tears and 0 or 1 }
    local function fill(x0, y0, x1, y1) scene.water:fill { box = { { x0, y0 }, { x1, y1 } } } end
    fill(0, 0, left - bore - wall, high)
    fill(left - bore - wall, 0, left - bore, gap)
    fill(left - bore, 0, left, rim)
    fill(left - bore, rim, right + bore, rim + bore)
    fill(right, 0, right + bore, rim)
    fill(right + bore, 0, right + bore + wall, gap)
    fill(right + bore + wall, 0, far, low)
    scene.count = scene.water:count()
    scene.left, scene.right, scene.pressure, scene.samples = 0, 0, 0, 0
  end,

  -- means of the last seconds, as it swings
  update = function(world, scene)
    if world:time() < 5 then return end
    scene.left = scene.left + (scene.water:height_at(0.3, 0) or 0)
    scene.right = scene.right + (scene.water:height_at(1.4, 0) or 0)
    scene.pressure = scene.pressure + scene.water:pressure_at((left + right) / 2, rim + bore / 2, 0)
    scene.samples = scene.samples + 1
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.water:count() == scene.count, "particles are missing")
    local l, r = scene.left / scene.samples, scene.right / scene.samples
    if not tears then
      expect(math.abs(l - r) < spacing, ("the levels end at %.3f and %.3f m"):format(l, r))
      local top = scene.pressure / scene.samples
      expect(top < 0, ("at the rim the pressure is %.0f Pa, not suction"):format(top))
    else
      expect(l - r > 0.15, ("without suction the levels became %.3f and %.3f m"):format(l, r))
    end
  end,
}
