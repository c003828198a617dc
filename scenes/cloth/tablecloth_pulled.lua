-- A tablecloth is pulled from under two boxes: fast, and they stay on the table.
local feder = require "feder"

local speed = feder.param("speed", 6, { min = 1, max = 10, help = "of the hand, m/s" })

local size, height = 1.0, 0.8

return feder.scene {
  title = "Tablecloth pulled away",
  seconds = 3,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), friction = 0.6 }
    world:body { name = "table", type = "static", shape = feder.box(1.2, 0.06, 1.2), position = { 0, height - 0.03, 0 },
      friction = 0.2, color = "#7a5230" }
    scene.cloth = world:cloth { name = "cloth", size = { size, size }, resolution = { 17, 17 },
      position = { 0.15, height + 0.006, 0 }, area_density = 0.15, stretch = 6000, friction = 0.1, damping = 0.01,
      self_collision = false, color = "#e8e2d2" }
    scene.boxes = {}
    for i, z in ipairs { -0.2, 0.2 } do
      scene.boxes[i] = world:body { name = "box" .. i, shape = feder.box(0.16, 0.1, 0.16), mass = 1.5, friction = 0.2,
        position = { 0, height + 0.065, z }, color = i == 1 and "#c0563d" or "#4d7f59" }
    end
    scene.hand = world:body { name = "hand", type = "kinematic", shape = feder.box(0.04, 0.04, size), friction = 0.2,
      position = { 0.15 + size / 2 + 0.04, height + 0.03, 0 }, color = "#40566b" }
    scene.cloth:attach("right", scene.hand)
  end,

  update = function(world, scene)
    local t = world:time() - 1
    if t <= 0 or t > 0.8 then return end
    local reach = t < 0.05 and 0.5 * speed * t * t / 0.05 or speed * (t - 0.025)
    scene.hand:move_to(0.15 + size / 2 + 0.04 + math.min(reach, 2), height + 0.03, 0)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    for _, box in ipairs(scene.boxes) do
      local x, y, z = box:position()
      expect(math.abs(y - height - 0.05) < 0.02, ("%s stands at height %.3f"):format(box:name(), y))
      expect(x < 0.3 and math.abs(z) < 0.4, ("%s was dragged to %.2f, %.2f"):format(box:name(), x, z))
    end
    for i = 1, (scene.cloth:count()) do
      local x, y = scene.cloth:point(i)
      expect(x > 0.5 or y < height - 0.05, ("vertex %d is still on the table"):format(i))
    end
  end,
}
