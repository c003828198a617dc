-- Lesson 1: a box falls on a floor and comes to rest.
local feder = require "feder"

return feder.scene {
  title = "1 A falling box",
  seconds = 3,

  -- build makes what is in the world; scene is a table to keep things in for later
  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    scene.box = world:body { name = "box", shape = feder.box(1, 1, 1), position = { 0, 4, 0 } }
  end,

  -- check is asked at the end: each expect says what must be true
  check = function(world, scene, expect)
    local x, y, z = scene.box:position()
    expect(math.abs(y - 0.5) < 0.01, ("the middle of the box is %.2f m high, not half its edge"):format(y))
    expect(not scene.box:awake(), "the box still moves")
  end,
}
