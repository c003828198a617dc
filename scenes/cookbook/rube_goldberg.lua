-- A Rube Goldberg machine: a ball rolls down a ramp and tips dominoes, the last one pushes a weight off its shelf, the
-- weight falls on a seesaw, the seesaw throws a ball through a hoop, and the hoop, a sensor, lets a banner down.
local feder = require "feder"

local dominoes = feder.param("dominoes", 9, { min = 3, max = 20 })
local gap = 0.22  -- from domino to domino, m

return feder.scene {
  title = "Rube Goldberg",
  seconds = 8,
  picture = 3.6,
  camera = { target = { 1.2, 1.4, 0 }, distance = 6, yaw = feder.deg(14), pitch = feder.deg(12) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    -- 1. the ramp, and a table for the dominoes
    local edge = dominoes * gap
    world:body { name = "table", type = "static", shape = feder.box(edge + 0.4, 0.1, 0.6), color = "brown",
      position = { edge / 2 - 0.1, 1.15, 0 } }
    world:body { name = "ramp", type = "static", shape = feder.box(1.2, 0.06, 0.4), color = "wood",
      position = { -0.75, 1.42, 0 }, rotation = { axis = { 0, 0, 1 }, angle = feder.deg(-22) } }
    local ball = world:body { name = "ball", shape = feder.sphere(0.1), density = 2000, color = "red",
      position = { -1.2, 1.78, 0 } }
    -- 2. dominoes
    for i = 1, dominoes do
      world:body { name = "domino" .. i, shape = feder.box(0.06, 0.4, 0.24), density = 800,
        color = i % 2 == 0 and "white" or "teal", position = { (i - 0.5) * gap, 1.4, 0 } }
    end
    -- 3. the weight on the edge, 4. the seesaw below it with the ball to be thrown on its other end
    local weight = world:body { name = "weight", shape = feder.sphere(0.14), density = 1500, color = "black",
      position = { edge + 0.08, 1.34, 0 } }
    local x = edge + 0.85
    world:body { name = "stand", type = "static", shape = feder.box(0.06, 0.2, 0.3), color = "brown",
      position = { x, 0.1, 0 } }
    local seesaw = world:body { name = "seesaw", density = 400, color = "wood", position = { x, 0.28, 0 },
      shape = feder.compound {
        { shape = feder.box(1.4, 0.05, 0.4) },
        { shape = feder.box(0.04, 0.16, 0.4), position = { 0.46, 0.1, 0 } },  -- a cup for the ball
        { shape = feder.box(0.04, 0.16, 0.4), position = { 0.7, 0.1, 0 } },
      } }
    world:joint { type = "hinge", a = seesaw, anchor = { x, 0.28, 0 }, axis = { 0, 0, 1 } }
    local thrown = world:body { name = "thrown", shape = feder.sphere(0.08), density = 500, color = "yellow",
      position = { x + 0.58, 0.42, 0 } }
    -- 5. the hoop is a sensor, 6. the banner lies flat in the air, held by two edges, until one of them is let go
    local hoop = world:region { name = "hoop", shape = feder.box(0.6, 0.1, 0.6), position = { x + 0.1, 0.9, 0 } }
    local columns, rows = 25, 13
    local banner = world:cloth { name = "banner", size = { 2, 0.9 }, resolution = { columns, rows }, color = "red",
      position = { 0.9, 2.9, -0.5 }, pins = { "top", "bottom" }, self_collision = false }

    scene.stages = {}
    local function stage(name)
      scene.stages[#scene.stages + 1] = { name = name, time = world:time() }
      print(("%.2f s: %s"):format(world:time(), name))
    end
    world:task(function()
      feder.wait_for("hit", { object = world:find("domino1") })
      stage "the ball tips the first domino"
      feder.wait_for("contact_begin", { a = weight, b = world:find("domino" .. dominoes) })
      stage "the last domino pushes the weight"
      feder.wait_for("contact_begin", { a = weight, b = seesaw })
      stage "the weight falls on the seesaw"
      feder.wait_for("sensor_enter", { sensor = hoop, other = thrown })
      stage "the ball flies through the hoop"
      for i = 1, columns do banner:unpin((rows - 1) * columns + i) end
      feder.wait_until(function() return select(2, banner:point(rows * columns)) < 2.1 end)
      stage "the banner is down"
    end)
  end,

  check = function(world, scene, expect)
    expect(#scene.stages == 5, ("the machine stopped after stage %d"):format(#scene.stages))
  end,
}
