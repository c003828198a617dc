-- A wall that breaks: bricks are welded to their neighbours with mortar that holds only so much, a ball is thrown at
-- it, and each joint that breaks is a point.
local feder = require "feder"

local strength = feder.param("strength", 6000, { min = 50, max = 20000, help = "of a joint of mortar, N" })
local speed = feder.param("speed", 14, { min = 0, max = 40, help = "of the ball, m/s" })

local columns, rows = 8, 7
local w, h, d = 0.5, 0.25, 0.25  -- of a brick, m

return feder.scene {
  title = "Breakable wall",
  seconds = 4,
  picture = 1.1,
  camera = { target = { 0, 0.8, 0 }, distance = 6.5, yaw = feder.deg(-40), pitch = feder.deg(14) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    scene.bricks, scene.joints = {}, 0

    -- a joint without an anchor sits midway between the two bodies
    local function mortar(a, b)
      if not (a and b) then return end
      world:joint { type = "weld", a = a, b = b, break_force = strength, tags = { "mortar" }, collide = true }
      scene.joints = scene.joints + 1
    end
    local below = {}
    for row = 1, rows do
      local here, shift = {}, row % 2 == 0 and w / 2 or 0
      for column = 1, columns do
        local brick = world:body { name = ("brick%d_%d"):format(row, column), shape = feder.box(w, h, d),
          friction = 0.7, color = (row + column) % 2 == 0 and "#b5533c" or "#c4694f",
          position = { (column - columns / 2 - 0.5) * w + shift, (row - 0.5) * h, 0 } }
        mortar(here[column - 1], brick)
        -- a brick rests on two of the row below
        mortar(below[column], brick)
        mortar(below[shift > 0 and column + 1 or column - 1], brick)
        here[column] = brick
        scene.bricks[#scene.bricks + 1] = brick
      end
      below = here
    end

    scene.score = 0
    world:on("joint_break", { tag = "mortar" }, function() scene.score = scene.score + 1 end)
    world:after(0.7, function()
      world:body { name = "ball", shape = feder.sphere(0.3), density = 3000, position = { 0, 1, 4 },
        velocity = { 0, 1, -speed }, color = "black", bullet = true }
    end)
    world:after(3.5, function() print(("score: %d of %d joints"):format(scene.score, scene.joints)) end)
  end,

  update = function(world, scene) feder.plot("score", scene.score) end,

  check = function(world, scene, expect)
    if speed == 0 then return expect(scene.score == 0, "the wall breaks by itself") end
    expect(scene.score >= 10, ("only %d joints broke"):format(scene.score))
    expect(scene.score < scene.joints, "nothing of the wall holds")
    local behind = 0
    for _, brick in ipairs(scene.bricks) do
      local _, _, z = brick:position()
      if z < -0.5 then behind = behind + 1 end
    end
    expect(behind >= 3, ("%d bricks lie behind the wall"):format(behind))
  end,
}
