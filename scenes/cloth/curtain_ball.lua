-- A ball is thrown into a curtain: the curtain gives, catches it and lets it drop.
local feder = require "feder"
local cloth = require "feder.cloth"

local speed = feder.param("speed", 6, { min = 1, max = 12, help = "m/s" })
local rows = feder.param("rows", 33, { min = 17, max = 65 })

return feder.scene {
  title = "Curtain and ball",
  seconds = 5,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), friction = 0.6 }
    world:body { name = "rail", type = "static", shape = feder.box(2.4, 0.05, 0.05), position = { 0, 2.53, 0 },
      color = "#6b4a2f" }
    scene.curtain = world:cloth(cloth.of("cotton", { name = "curtain", size = { 2.2, 2.3 }, color = "#3f7fbf",
      resolution = { rows, rows }, position = { 0, 1.35, 0 }, pins = { "top" },
      rotation = { axis = { 1, 0, 0 }, angle = feder.deg(90) } }))
    scene.ball = world:body { name = "ball", shape = feder.sphere(0.18), mass = 0.8, position = { 0.1, 1.5, 2.5 },
      velocity = { 0, 1, -speed }, color = "#e0a526" }
    scene.hits, scene.through = 0, 0
    world:on("hit", function(e)
      if e.a == scene.curtain or e.b == scene.curtain then scene.hits = scene.hits + 1 end
    end)
  end,

  update = function(world, scene)
    local x, y, z = scene.ball:position()
    -- behind the curtain by more than it can give
    if z < -1.8 and y > 0.3 then scene.through = scene.through + 1 end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.hits > 0, "the ball never hit the curtain")
    expect(scene.through == 0, "the ball went through the curtain")
    expect(scene.curtain:stretch() < 0.15, ("the curtain is stretched by %.1f %%"):format(100 * scene.curtain:stretch()))
    local x, y, z = scene.ball:position()
    expect(y < 0.6, "the ball still hangs in the air")
    for i = 1, select(1, scene.curtain:count()) do
      local _, height = scene.curtain:point(i)
      expect(height > -0.01, "a part of the curtain is below the floor")
    end
  end,
}
