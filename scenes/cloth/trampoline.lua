-- A woven sheet, stretched in a frame: a ball falls on it and is thrown back, again and again, lower each time.
local feder = require "feder"

local stretch = feder.param("stretch", 20000, { min = 5000, max = 60000, help = "of the weave, N/m" })
local drop = feder.param("drop", 1.5, { min = 0.3, max = 3, help = "m above the sheet" })

local size, height, radius, n = 2, 1, 0.15, 21

return feder.scene {
  title = "Trampoline of cloth",
  seconds = 5,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { type = "static", shape = feder.plane() }
    for _, s in ipairs { -1, 1 } do
      world:body { type = "static", shape = feder.box(size + 0.2, 0.06, 0.1), position = { 0, height, s * (size / 2 + 0.07) },
        color = "#55595f" }
      world:body { type = "static", shape = feder.box(0.1, 0.06, size), position = { s * (size / 2 + 0.07), height, 0 },
        color = "#55595f" }
      for _, t in ipairs { -1, 1 } do
        world:body { type = "static", shape = feder.box(0.08, height, 0.08), color = "#55595f",
          position = { s * (size / 2 + 0.07), height / 2, t * (size / 2 + 0.07) } }
      end
    end
    scene.sheet = world:cloth { name = "sheet", size = { size, size }, resolution = { n, n }, position = { 0, height, 0 },
      area_density = 0.4, warp = stretch, weft = stretch, shear = stretch / 20, damping = 0.001, max_strain = 0.3,
      self_collision = false, pins = { "left", "right", "top", "bottom" }, color = "#20304a" }
    scene.ball = world:body { name = "ball", shape = feder.sphere(radius), mass = 8, color = "#d98324",
      position = { 0, height + radius + drop, 0 } }
    scene.low, scene.high, scene.bounces, scene.last = 10, 0, 0, 0
  end,

  update = function(world, scene)
    local _, y = scene.ball:position()
    local _, v = scene.ball:velocity()
    scene.low = math.min(scene.low, y)
    if scene.last < 0 and v >= 0 then scene.bounces = scene.bounces + 1 end
    if scene.bounces > 0 then scene.high = math.max(scene.high, y) end
    scene.last = v
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    local dip = height + radius - scene.low
    expect(dip > 0.1 and dip < 0.9, ("the sheet gives way by %.2f m"):format(dip))
    local back = (scene.high - height - radius) / drop
    expect(scene.bounces >= 2, ("the ball is thrown back %d times"):format(scene.bounces))
    expect(back > 0.1 and back < 1.02, ("it comes back to %.0f %% of its height"):format(100 * back))
    local x, _, z = scene.ball:position()
    expect(math.abs(x) < 0.6 and math.abs(z) < 0.6, ("it bounces to %.2f, %.2f m off"):format(x, z))
  end,
}
