-- Lesson 8: cloth: one sheet drapes over a ball, another hangs on a line, fills in the wind, and is let go but for one
-- corner.
local feder = require "feder"

local wind = feder.param("wind", 3, { min = 0, max = 10, help = "m/s" })
local columns, rows = 17, 13  -- of vertices

return feder.scene {
  title = "8 Cloth",
  seconds = 6,
  picture = 2.6,
  camera = { target = { 0, 1, 0 }, distance = 6, yaw = feder.deg(35), pitch = feder.deg(14) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    world:body { name = "ball", type = "static", shape = feder.sphere(0.5), color = "teal", position = { 1.1, 0.5, 0 } }

    -- a sheet is made flat, in its own xz plane: here just above the ball
    scene.cover = world:cloth { name = "cover", size = { 1.4, 1.4 }, color = "yellow", position = { 1.1, 1.1, 0 },
      wind = false }

    -- turned about x by a quarter it hangs; pins hold vertices where they are, "top" is the whole first row
    scene.sheet = world:cloth { name = "sheet", size = { 1.6, 1.2 }, resolution = { columns, rows }, color = "orange",
      position = { -1, 1.4, 0 }, rotation = { axis = { 1, 0, 0 }, angle = feder.deg(90) }, pins = { "top" } }
    scene.corner = columns * rows  -- its last vertex, bottom right

    -- wind acts on every cloth that does not say wind = false, and a force can be switched
    local breeze = world:force { kind = "wind", velocity = { 0, 0, wind } }
    breeze:set_enabled(false)
    world:task(function()
      feder.wait(1)
      scene.still = { scene.sheet:point(scene.corner) }
      breeze:set_enabled(true)
      feder.wait(2)
      scene.blown = { scene.sheet:point(scene.corner) }
      breeze:set_enabled(false)
      for i = 2, columns do scene.sheet:unpin(i) end  -- vertices count from the top left
    end)
  end,

  check = function(world, scene, expect)
    expect(math.abs(scene.still[2] - 0.8) < 0.05, ("in still air the corner was at %.2f m"):format(scene.still[2]))
    if wind >= 3 then expect(scene.blown[3] > 0.3, ("the wind moved it by %.2f m"):format(scene.blown[3])) end
    local _, y = scene.sheet:point(scene.corner)
    expect(y < 0.3, ("let go, the corner is at %.2f m"):format(y))
    local low, top = 2, 0
    for i = 1, (scene.cover:count()) do
      local _, h = scene.cover:point(i)
      low, top = math.min(low, h), math.max(top, h)
    end
    expect(top > 0.98 and top < 1.1 and low > 0 and low < 0.4, ("the cover lies from %.2f to %.2f m"):format(low, top))
  end,
}
