-- A tower of crates on a plane. Left alone it stands and falls asleep; --set push=20 throws a ball at it.
local feder = require "feder"

local height = feder.param("height", 10, { min = 1, max = 60, step = 1, help = "crates" })
local push = feder.param("push", 0, { min = 0, max = 60, help = "speed of the thrown ball in m/s, 0 for none" })

return feder.scene {
  title = "Tower",
  seconds = 6,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { name = "ground", type = "static", shape = feder.plane(), friction = 0.6 }
    scene.crates = {}
    for i = 1, height do
      scene.crates[i] = world:body {
        name = "crate" .. i, tags = { "crate" }, shape = feder.box(1, 1, 1),
        position = { 0, i - 0.5, 0 }, density = 500, friction = 0.6,
      }
    end
    if push > 0 then
      world:after(2, function()
        world:body {
          name = "ball", shape = feder.sphere(0.4), density = 4000,
          position = { -8, height / 2, 0 }, velocity = { push, 3, 0 },
        }
      end)
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(world:max_penetration() < 0.01, "crates sink into each other")
    if push > 0 then
      local _, y = scene.crates[height]:position()
      expect(y < height - 1 or height < 3, "the ball left the tower standing")
      return
    end
    for i, crate in ipairs(scene.crates) do
      local x, y, z = crate:position()
      expect(math.abs(x) < 1e-3 and math.abs(z) < 1e-3, crate:name() .. " moved sideways by " .. math.max(math.abs(x), math.abs(z)))
      expect(math.abs(y - (i - 0.5)) < 0.01 * i, crate:name() .. " sank to " .. y)
      expect(not crate:awake(), crate:name() .. " is awake")
    end
  end,
}
