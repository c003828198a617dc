-- scenes/soft/block_in_water.lua: a soft block is laid on the water of a tank, and floats as deep as Archimedes says. One
-- heavier than water lies on the ground.
local feder = require "feder"

local density = feder.param("density", 500, { min = 200, max = 1500, help = "of the block, kg/m3" })
local young = feder.param("young", 1e5, { min = 3e4, max = 1e6, help = "of the block, Pa" })

local wide, high, side, cells, spacing = 1, 0.6, 0.4, 6, 0.05  -- m; cells along a side

return feder.scene {
  title = "A block in water",
  seconds = 5,
  picture = 0.5,
  camera = { target = { 0, 0.5, 0 }, distance = 2.6, yaw = feder.deg(35), pitch = feder.deg(22) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    for k = 0, 3 do
      local along = k % 2 == 0
      local far = (wide / 2 + 0.02) * (k < 2 and 1 or -1)
      world:body { name = "wall", type = "static",
        shape = feder.box(along and 0.04 or wide + 0.08, 1, along and wide or 0.04),
        position = { along and far or 0, 0.5, along and 0 or far }, transparency = 0.85 }
    end
    scene.water = world:fluid { name = "water", spacing = spacing, color = "#4f8fc0", transparency = 0.5 }
    scene.water:fill { shape = feder.box(wide, high, wide), position = { 0, high / 2, 0 } }
    scene.block = world:soft { name = "block", shape = feder.box(side, side, side), resolution = cells,
      position = { 0, high + side / 2 + 0.01, 0 }, density = density, young = young, color = "#d9843b" }
    scene.depth, scene.force, scene.count = 0, 0, 0
  end,

  -- Over the last second: the level of the water beside the block less the height of its underside, by its middle.
  update = function(world, scene)
    if world:time() < 4 then return end
    local middle, n = 0, scene.block:count()
    for k = 1, n do
      local _, y = scene.block:point(k)
      middle = middle + y / n
    end
    local heights, p = {}, scene.water:positions()
    for i = 1, #p, 3 do
      if math.max(math.abs(p[i]), math.abs(p[i + 2])) > 0.3 then heights[#heights + 1] = p[i + 1] end
    end
    table.sort(heights)
    local level = heights[math.floor(0.97 * #heights)] + spacing / 2
    scene.depth = scene.depth + level - (middle - side / 2)
    scene.force = scene.force - world:residuals()["fluid_soft.force_n"]
    scene.lowest = middle - side / 2
    scene.count = scene.count + 1
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect.no_warnings()
    expect.error(world:residuals()["fluid_soft.impulse_mismatch"], "<", 1e-4, "impulses that only one side got")
    local depth, force, weight = scene.depth / scene.count, scene.force / scene.count, density * side ^ 3 * 9.81
    if density < 950 then
      -- one that dives as it is laid down may keep a layer of particles on its top, and lies that much deeper
      local layer = density > 850 and spacing or 0
      expect.error(math.abs(depth - side * density / 1000), "<", side / cells / 2 + layer, "depth, m")
      expect.error(math.abs(force / weight - 1), "<", 0.05, "what presses it up over its weight")
      expect(scene.block:awake(), "a block that floats went to sleep")
    elseif density > 1100 then
      -- on the ground, or on a layer of particles that cannot leave
      expect.error(scene.lowest, "<", 1.25 * spacing, "height of a block that is heavier than water")
    end
  end,
}
