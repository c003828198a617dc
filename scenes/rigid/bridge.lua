-- A bridge of planks on hinges between two cliffs, with crates dropped onto it.
local feder = require "feder"

local planks = feder.param("planks", 30, { min = 3, max = 160, step = 1 })
local crates = feder.param("crates", 5, { min = 0, max = 50, step = 1 })

return feder.scene {
  title = "Bridge",
  seconds = 8,
  world = { dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    -- the planks hang in a V, 3 % longer than the gap they span
    local tilt = math.acos(0.97)
    local half = 0.97 * planks / 2
    local left = world:body { name = "left", type = "static", shape = feder.box(4, 4, 4), position = { -half - 2.05, -2, 0 } }
    local right = world:body { name = "right", type = "static", shape = feder.box(4, 4, 4), position = { half + 2.05, -2, 0 } }
    scene.planks, scene.worst = {}, 0
    local last = left
    for i = 1, planks do
      local x, depth = 0.97 * (i - 0.5) - half, math.sin(tilt) * (planks / 2 - math.abs(i - 0.5 - planks / 2))
      local angle = i - 0.5 < planks / 2 and -tilt or (i - 0.5 > planks / 2 and tilt or 0)
      local plank = world:body {
        name = "plank" .. i, shape = feder.box(1, 0.2, 3), density = 400, friction = 0.6,
        position = { x, -0.1 - depth, 0 }, rotation = { axis = { 0, 0, 1 }, angle = angle },
      }
      local edge = math.sin(tilt) * (planks / 2 - math.abs(i - 1 - planks / 2))
      world:joint { type = "hinge", a = last, b = plank, anchor = { x - 0.485, -0.1 - edge, 0 }, axis = { 0, 0, 1 } }
      scene.planks[i], last = plank, plank
    end
    world:joint { type = "hinge", a = last, b = right, anchor = { half, -0.1, 0 }, axis = { 0, 0, 1 } }
    world:after(1, function()
      scene.crates = {}
      for i = 1, crates do
        scene.crates[i] = world:body { name = "crate" .. i, shape = feder.box(0.8, 0.8, 0.8), position = { i - crates / 2, 2 + i, 0 }, density = 300, friction = 0.6 }
      end
    end)
  end,

  update = function(world, scene)
    scene.worst = math.max(scene.worst, world:residuals()["rigid.joint_error_m"] or 0)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.worst < 0.05, "joints open by " .. scene.worst .. " m")
    local lowest = 0
    for _, plank in ipairs(scene.planks) do
      local _, y, z = plank:position()
      lowest = math.min(lowest, y)
      expect(math.abs(z) < 0.1, plank:name() .. " slid out of the row: z = " .. z)
    end
    -- a parabola of length 1.03 spans over 1 sags by sqrt(3/8 * 0.03) of the gap; the crates' load deepens it
    local sag = -0.1 - lowest
    expect(sag > 0.09 * 2 * 0.97 * planks / 2 and sag < 0.14 * planks, "the bridge sags by " .. sag .. " m")
    for _, crate in ipairs(scene.crates or {}) do
      local _, y = crate:position()
      expect(y > lowest, crate:name() .. " fell through the bridge")
    end
  end,
}
