-- A cloth falls over a table and drapes; then a cup and a box are set on it, and rest.
local feder = require "feder"
local cloth = require "feder.cloth"

local rows = feder.param("rows", 41, { min = 21, max = 81 })

return feder.scene {
  title = "Tablecloth",
  seconds = 6,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), friction = 0.6 }
    world:body { name = "table", type = "static", shape = feder.box(1, 0.06, 1), position = { 0, 0.77, 0 }, friction = 0.5,
      color = "#7a5230" }
    for _, x in ipairs { -0.44, 0.44 } do
      for _, z in ipairs { -0.44, 0.44 } do
        world:body { type = "static", shape = feder.box(0.07, 0.74, 0.07), position = { x, 0.37, z }, color = "#7a5230" }
      end
    end
    scene.cloth = world:cloth(cloth.of("cotton", { name = "cloth", size = { 1.5, 1.5 }, resolution = { rows, rows },
      position = { 0, 0.9, 0 }, friction = 0.5, color = "#e8e2d2", damping = 0.01 }))
    world:after(2, function()
      scene.cup = world:body { name = "cup", shape = feder.cylinder(0.06, 0.14), mass = 0.3, friction = 0.6,
        position = { 0.15, 0.95, 0.1 }, color = "#c0563d" }
      scene.box = world:body { name = "box", shape = feder.box(0.2, 0.12, 0.2), mass = 0.5, friction = 0.6,
        position = { -0.2, 0.95, -0.1 }, color = "#4d7f59" }
    end)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.cloth:stretch() < 0.1, ("the cloth is stretched by %.1f %%"):format(100 * scene.cloth:stretch()))
    -- the middle lies on the table, the corners hang
    local middle = (rows * rows + 1) // 2
    local x, y, z = scene.cloth:point(middle)
    expect(math.abs(y - 0.8) < 0.02, ("the middle is %.3f m high, the table 0.8"):format(y))
    for _, corner in ipairs { 1, rows, rows * rows - rows + 1, rows * rows } do
      local _, h = scene.cloth:point(corner)
      expect(h > 0 and h < 0.72, ("a corner hangs at %.3f m"):format(h))
    end
    -- nothing has sunk into the table
    for i = 1, rows * rows do
      local px, py, pz = scene.cloth:point(i)
      local inside = math.abs(px) < 0.49 and math.abs(pz) < 0.49 and py > 0.74 and py < 0.795
      expect(not inside, ("vertex %d is inside the table at height %.3f"):format(i, py))
    end
    for _, body in ipairs { scene.cup, scene.box } do
      local bx, by, bz = body:position()
      local half = body == scene.cup and 0.07 or 0.06
      expect(by > 0.8 + half - 0.01 and by < 0.8 + half + 0.03, ("%s lies at height %.3f"):format(body:name(), by))
      local vx, vy, vz = body:velocity()
      expect(math.sqrt(vx * vx + vy * vy + vz * vz) < 0.05, body:name() .. " still moves")
    end
  end,
}
