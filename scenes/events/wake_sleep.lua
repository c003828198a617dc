-- Sleep and wake with their causes: a stack falls asleep, a ball wakes it by touch, a script wakes a lone crate.
local feder = require "feder"

return feder.scene {
  title = "Wake and sleep",
  seconds = 8,
  picture = 3.6,
  camera = { yaw = feder.deg(-30), pitch = feder.deg(18) },
  world = { dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    scene.log = {}
    local function note(what, object, cause)
      scene.log[#scene.log + 1] = { what = what, name = object:name(), cause = cause, time = world:time() }
    end
    world:body { name = "ground", type = "static", shape = feder.plane() }
    for i = 1, 3 do
      world:body { name = "crate" .. i, shape = feder.box(1, 1, 1), position = { 0, i - 0.5, 0 } }
    end
    scene.lone = world:body { name = "lone", shape = feder.box(1, 1, 1), position = { 5, 0.5, 0 } }
    world:on("sleep", function(e) note("sleep", e.object) end)
    world:on("wake", function(e) note("wake", e.object, e.cause) end)
    world:after(3, function()
      world:body { name = "ball", shape = feder.sphere(0.3), position = { -4, 0.5, 0 }, velocity = { 6, 1, 0 }, density = 4000, linear_damping = 0.5, angular_damping = 2 }
      scene.lone:wake()
    end)
  end,

  check = function(world, scene, expect)
    local function first(what, name)
      for _, entry in ipairs(scene.log) do
        if entry.what == what and entry.name == name then return entry end
      end
    end
    for _, name in ipairs { "crate1", "crate2", "crate3", "lone" } do
      local slept = first("sleep", name)
      expect(slept and slept.time < 3, name .. " did not fall asleep in time")
    end
    local touched = first("wake", "crate1")
    expect(touched and touched.cause == "contact" and touched.time > 3, "crate1 was not woken by the ball")
    for _, name in ipairs { "crate2", "crate3" } do
      local woken = first("wake", name)
      expect(woken and (woken.cause == "neighbor" or woken.cause == "contact"), name .. " was not woken with its island")
    end
    local lone = first("wake", "lone")
    expect(lone and lone.cause == "script", "the script did not wake the lone crate")
    expect(not scene.lone:awake(), "the lone crate did not fall asleep again")
  end,
}
