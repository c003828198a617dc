-- What does nothing beside what moves: static boxes in a grid, stacks of four boxes asleep, balls that glide among the
-- boxes in the middle and bounce off them. scripts/check/instructions.py --idle counts what a step of it costs.
local feder = require "feder"

local static = feder.param("static", 0, { min = 0, max = 1000000, step = 1, help = "static boxes" })
local asleep = feder.param("asleep", 0, { min = 0, max = 1000000, step = 1, help = "boxes asleep, in stacks of four" })
local moving = feder.param("moving", 0, { min = 0, max = 10000, step = 1, help = "balls that glide" })

-- calls f(k, x, z) for `count` places of a square grid around the origin
local function grid(count, pitch, f)
  local side = math.ceil(math.sqrt(count))
  for k = 0, count - 1 do
    f(k, pitch * (k % side - side // 2), pitch * (k // side - side // 2))
  end
end

return feder.scene {
  title = "What does nothing",
  seconds = 1,
  world = { dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { name = "ground", type = "static", shape = feder.plane() }
    local box, ball = feder.box(1, 1, 1), feder.sphere(0.3)
    grid(static, 4, function(_, x, z) world:body { type = "static", shape = box, position = { x, 0.5, z } } end)
    scene.sleepers = {}
    grid(math.ceil(asleep / 4), 3, function(k, x, z)
      for layer = 0, math.min(3, asleep - 4 * k - 1) do
        -- beside the static boxes
        scene.sleepers[#scene.sleepers + 1] = world:body {
          shape = box, position = { x + 2000, layer + 0.5, z }, sleeping = true,
        }
      end
    end)
    scene.balls = {}
    grid(moving, 2, function(k, x, z)
      scene.balls[#scene.balls + 1] = world:body {
        shape = ball, position = { x + 1, 0.3, z + 1 }, velocity = { 3, 0, k % 3 - 1 },
      }
    end)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    for _, body in ipairs(scene.sleepers) do expect(not body:awake(), "a box woke up") end
    for _, body in ipairs(scene.balls) do expect(body:awake(), "a ball fell asleep") end
  end,
}
