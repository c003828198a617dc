-- scenes/rope/bollard.lua: a rope with two turns round a post holds 40 kg by a hand of 200 g. Friction along a turn
-- multiplies the tension by e^(mu angle) (Euler, Eytelwein); half a turn more or less is all the difference.
local feder = require "feder"

local turns = feder.param("turns", 2, { min = 0.5, max = 3, step = 0.5, help = "round the post" })
local load = feder.param("load", 40, { min = 1, max = 200, help = "kg" })

local radius, post = 0.012, 0.08

return feder.scene {
  title = "Bollard",
  seconds = 6,

  build = function(world, scene)
    world:body { type = "static", shape = feder.plane() }
    world:body {
      name = "post", type = "static", shape = feder.cylinder(post, 0.6),
      position = { 0, 1.5, 0 }, rotation = { axis = { 1, 0, 0 }, angle = feder.deg(90) }, friction = 0.45,
    }
    -- up to the post on its left side, round it, down on its right side; each turn lies beside the last one
    local path, points = post + radius, {}
    local angle = 2 * math.pi * turns
    if turns % 1 ~= 0.5 then angle = angle + math.pi end
    local step, pitch = 0.03, 2.6 * radius / (2 * math.pi)
    local z0 = -pitch * angle / 2
    for i = 24, 1, -1 do points[#points + 1] = { -path, 1.5 - i * step, z0 } end
    local n = math.ceil(path * angle / step)
    for i = 0, n do
      local a = angle * i / n
      points[#points + 1] = { -path * math.cos(a), 1.5 + path * math.sin(a), z0 + pitch * a }
    end
    for i = 1, 24 do points[#points + 1] = { path, 1.5 - i * step, -z0 } end
    scene.rope = world:rope { name = "line", points = points, radius = radius, friction = 0.45, stretch = 2e5 }

    local function weight(name, mass, i, size)
      local x, y, z = scene.rope:point(i)
      local body = world:body { name = name, shape = feder.box(size, size, size), position = { x, y - size / 2, z }, mass = mass }
      scene.rope:attach(i, body, 0, size / 2, 0)
      return body
    end
    scene.hand = weight("hand", 0.2, 1, 0.08)
    scene.crate = weight("crate", load, #points, 0.25)
    world:after(2, function() scene.settled = select(2, scene.crate:position()) end)  -- the turns have drawn tight
  end,

  check = function(world, scene, expect)
    local _, y = scene.crate:position()
    expect(world:is_finite())
    expect(scene.settled - y < 0.001, "the crate has slipped by " .. (scene.settled - y) .. " m")
    expect(scene.rope:strain() < 0.01)
    local tension = scene.rope:tension(select(2, scene.rope:count()))
    expect(math.abs(tension / (load * 9.81) - 1) < 0.05, "the rope does not carry the crate: " .. tension .. " N")
  end,
}
