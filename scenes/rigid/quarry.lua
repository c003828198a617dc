-- A wall that is sawn through, a cut every tenth of a second. What comes off falls as a body of its own; the field of
-- distances (feder.sdf) that is the wall's shape follows, and with it mass and inertia.
local feder = require "feder"

local cuts = feder.param("cuts", 30, { min = 1, max = 60, step = 1, help = "cuts of the saw" })

return feder.scene {
  title = "Quarry",
  seconds = 6,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    local density = 2000
    scene.wall = world:body {
      name = "wall", shape = feder.sdf { shape = feder.box(3, 2, 0.6), spacing = 0.05 }, density = density,
      position = { 0, 1, 0 },
    }
    scene.whole, scene.pieces = scene.wall:mass(), {}

    -- along a wave across the wall
    local n = 0
    world:every(0.1, function()
      if n >= cuts then return end
      n = n + 1
      local x = -1.6 + 3.2 * (n - 0.5) / cuts
      scene.wall:carve { shape = feder.box(3.4 / cuts, 0.2, 0.8), position = { x, 1.2 + 0.2 * math.sin(3 * x), 0 } }
    end)
    world:on("carved", function(e)
      if e.other then scene.pieces[#scene.pieces + 1] = e.other end
    end)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(#scene.pieces > 0, "nothing came off")
    local left = scene.wall:mass()
    for _, b in ipairs(scene.pieces) do left = left + b:mass() end
    -- a slit of .2 m along the wave, through 3 m of wall .6 m thick
    local sawn = (scene.whole - left) / 2000
    expect(math.abs(sawn - 3 * 0.2 * 0.6) < 0.08, ("%.3f m3 were sawn away"):format(sawn))
    expect(world:max_penetration() < 0.02)
  end,
}
