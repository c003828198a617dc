-- A catapult: a heavy counterweight swings an arm up when the catch lets go, and the stone flies at a tower of crates.
local feder = require "feder"

local weight = feder.param("weight", 400, { min = 50, max = 1000, help = "of the counterweight, kg" })
local release = feder.param("release", 1, { min = 0, max = 3, help = "when the catch lets go, s" })

local pivot, long, short = 1.6, 2.4, 0.8  -- height of the axle, arms of the lever on both sides of it, m

return feder.scene {
  title = "Catapult",
  seconds = 6,
  picture = 1.55,
  camera = { target = { 3, 1.9, 0 }, distance = 9, yaw = feder.deg(-55), pitch = feder.deg(10) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    local frame = world:body { name = "frame", type = "static", color = "brown", shape = feder.compound {
      { shape = feder.box(0.2, 1.8, 0.15), position = { 0, 0.9, 0.45 } },
      { shape = feder.box(0.2, 1.8, 0.15), position = { 0, 0.9, -0.45 } },
    } }
    -- the lever lies along x; the cup at its far end is a floor with four low walls
    local arm = world:body { name = "arm", color = "wood", density = 300, position = { 0, pivot, 0 },
      shape = feder.compound {
        { shape = feder.box(long + short, 0.12, 0.16), position = { (short - long) / 2, 0, 0 } },
        { shape = feder.box(0.5, 0.05, 0.5), position = { -long, 0.08, 0 } },
        { shape = feder.box(0.05, 0.16, 0.5), position = { -long - 0.23, 0.15, 0 } },
        { shape = feder.box(0.05, 0.16, 0.5), position = { -long + 0.23, 0.15, 0 } },
        { shape = feder.box(0.5, 0.16, 0.05), position = { -long, 0.15, 0.23 } },
        { shape = feder.box(0.5, 0.16, 0.05), position = { -long, 0.15, -0.23 } },
      } }
    -- a hinge turns about its axis. Its limits are the angle of b seen from a, 0 as it was built; turning from x to y
    -- is positive about z, so throwing, from -x up and over, is negative
    world:joint { type = "hinge", a = frame, b = arm, anchor = { 0, pivot, 0 }, axis = { 0, 0, 1 },
      limits = { feder.deg(-60), feder.deg(25) } }
    local load = world:body { name = "counterweight", color = "stone", mass = weight, shape = feder.box(0.5, 0.6, 0.5),
      position = { short, pivot - 0.45, 0 } }
    world:joint { type = "hinge", a = arm, b = load, anchor = { short, pivot, 0 }, axis = { 0, 0, 1 } }
    -- the catch: a joint without b holds to the world
    scene.catch = world:joint { type = "weld", a = arm, anchor = { -long, pivot, 0 } }
    scene.stone = world:body { name = "stone", shape = feder.sphere(0.17), mass = 8, color = "black",
      position = { -long, pivot + 0.28, 0 } }

    scene.crates = {}
    for i = 1, 6 do
      scene.crates[i] = world:body { name = "crate" .. i, tags = { "crate" }, shape = feder.box(0.6, 0.6, 0.6),
        density = 50, color = "sand", position = { 9.6, 0.6 * i - 0.3, 0 } }
    end

    world:after(release, function() scene.catch:destroy() end)
    scene.stone:on("hit", { min_speed = 2 }, function(e)
      local other = e.a == scene.stone and e.b or e.a
      print(("%.2f s: the stone hits %s with %.1f m/s"):format(world:time(), other:name(), e.speed))
      scene.first = scene.first or other:name()
    end)
  end,

  check = function(world, scene, expect)
    expect(scene.first and scene.first:find("crate"), "the stone hit " .. tostring(scene.first) .. " first")
    local _, top = scene.crates[6]:position()
    expect(top < 3, ("the top crate is still %.2f m high"):format(top))
  end,
}
