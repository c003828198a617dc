-- Examples of the reference, each behind a line "--: title". Each is run by tests/cli/test_doc.cpp with what stands above
-- the first one. A reader pastes them into `feder repl`.
local feder = require "feder"
local world = feder.world {}
local ground = world:body { name = "ground", type = "static", shape = feder.plane() }

--: feder.world
local moon = feder.world { gravity = { 0, -1.62, 0 }, dt = 1 / 120, rigid = { solver = "impulse" } }
moon:step(60)

--: feder.scene
return feder.scene {
  title = "Drop", seconds = 2,
  build = function(world, scene)
    world:body { type = "static", shape = feder.plane() }
    scene.ball = world:body { name = "ball", shape = feder.sphere(0.5), position = { 0, 5, 0 } }
  end,
  check = function(world, scene, expect)
    local _, y = scene.ball:position()
    expect(y > 0.49, "the ball sank into the ground")
  end,
}

--: feder.param
local height = feder.param("height", 10, { min = 1, max = 40, step = 1, help = "crates in the tower" })
print(height) -- 10, or what --set height=20 says

--: feder.box
local crate = world:body { shape = feder.box(1, 0.5, 2), position = { 0, 3, 0 } }

--: feder.sphere
local ball = world:body { shape = feder.sphere(0.25), position = { 0, 2, 0 }, restitution = 0.8 }

--: feder.capsule
local pill = world:body { shape = feder.capsule(0.2, 1), position = { 0, 2, 0 } }

--: feder.hull
local wedge = feder.hull { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }
world:body { shape = wedge, position = { 0, 2, 0 } }

--: feder.mesh
local floor = feder.mesh({ { -5, 0, -5 }, { 5, 0, -5 }, { 5, 0, 5 }, { -5, 0, 5 } }, { { 1, 3, 2 }, { 1, 4, 3 } })
world:body { type = "static", shape = floor }

--: feder.compound
local hammer = feder.compound {
  { shape = feder.box(0.1, 1, 0.1) },
  { shape = feder.box(0.6, 0.3, 0.3), position = { 0, 0.6, 0 } },
}
world:body { shape = hammer, position = { 0, 2, 0 } }

--: feder.buffer
local cloth = world:cloth { size = { 1, 1 }, position = { 0, 2, 0 } }
local buffer = feder.buffer(3 * cloth:count())
cloth:positions(buffer) -- x, y, z of vertex 1 are buffer[1], buffer[2], buffer[3]

--: feder.deg
local tilted = world:body { shape = feder.box(1, 1, 1), position = { 0, 2, 0 },
  rotation = { axis = { 0, 0, 1 }, angle = feder.deg(30) } }

--: feder.wait
world:task(function()
  feder.wait(0.5)
  world:body { shape = feder.sphere(0.2), position = { 0, 4, 0 } }
end)
world:step(60)

--: feder.wait_for
world:body { name = "ball", shape = feder.sphere(0.2), position = { 0, 1, 0 } }
world:task(function()
  local e = feder.wait_for("contact_begin")
  print(e.a:name(), "touches", e.b:name())
end)
world:step(60)

--: feder.plot
local ball = world:body { shape = feder.sphere(0.2), position = { 0, 5, 0 } }
for _ = 1, 60 do
  world:step()
  feder.plot("height", select(2, ball:position()))
end

--: world:body
local crate = world:body {
  name = "crate", shape = feder.box(1, 1, 1), position = { 0, 0.5, 0 }, density = 500, friction = 0.6, tags = { "crate" },
}

--: world:joint
local door = world:body { shape = feder.box(1, 2, 0.1), position = { 0.5, 1.1, 0 } }
local hinge = world:joint { type = "hinge", a = door, anchor = { 0, 1.1, 0 }, axis = { 0, 1, 0 },
  limits = { 0, feder.deg(90) } }

--: world:net
local rope = world:net {
  points = { { 0, 3, 0 }, { 0.5, 3, 0 }, { 1, 3, 0 } }, masses = 0.1,
  springs = { { 1, 2, stiffness = 500 }, { 2, 3, stiffness = 500 } },
}
rope:pin(1)

--: world:cloth
local flag = world:cloth { size = { 1.5, 1 }, position = { 0, 2, 0 }, pins = { "left" }, area_density = 0.15 }

--: world:fluid
local water = world:fluid { spacing = 0.1, viscosity = 0.001 }
water:fill { box = { { -0.5, 0, -0.5 }, { 0.5, 0.5, 0.5 } } }

--: world:force
world:body { shape = feder.sphere(0.2), position = { 0, 2, 0 }, tags = { "leaf" } }
world:force { kind = "wind", on = "leaf", velocity = { 4, 0, 0 } }

--: world:region
local goal = world:region { box = { { -1, 0, -1 }, { 1, 1, 1 } } }
world:on("sensor_enter", { sensor = goal }, function(e) print(e.other:name(), "is in the goal") end)

--: world:on
world:on("hit", { min_speed = 2 }, function(e)
  print(e.a:name(), "hits", e.b:name(), "at", e.speed, "m/s")
end)
world:body { name = "ball", shape = feder.sphere(0.2), position = { 0, 3, 0 } }
world:step(120)

--: world:events
world:body { shape = feder.sphere(0.2), position = { 0, 1, 0 } }
for _ = 1, 60 do
  world:step()
  for e in world:events("contact_begin") do print(e.time) end
end

--: world:after
world:after(1, function() ground:set_friction(0.1) end)
world:step(90)

--: world:every
local count = 0
local clock = world:every(0.25, function() count = count + 1 end)
world:step(60)
clock:disconnect()

--: world:raycast
world:body { name = "crate", shape = feder.box(1, 1, 1), position = { 0, 0.5, 0 } }
local object, x, y, z = world:raycast(0, 5, 0, 0, -1, 0)
print(object:name(), y)

--: world:overlap
for _, object in ipairs(world:overlap { box = { { -1, -1, -1 }, { 1, 1, 1 } } }) do print(object:name()) end

--: world:snapshot
local saved = world:snapshot()
world:step(60)
world:restore(saved)

--: world:energy
local kinetic, potential, elastic = world:energy()

--: body:apply_impulse
local ball = world:body { shape = feder.sphere(0.2), position = { 0, 0.2, 0 }, mass = 2 }
ball:apply_impulse(4, 0, 0) -- 2 m/s along x

--: body:move_to
local lift = world:body { type = "kinematic", shape = feder.box(1, 0.1, 1), position = { 0, 1, 0 } }
for k = 1, 60 do
  lift:move_to(0, 1 + k / 60, 0)
  world:step()
end

--: fluid:emitter
local water = world:fluid { spacing = 0.1 }
local hose = water:emitter { position = { 0, 2, 0 }, direction = { 1, 0, 0 }, speed = 3, radius = 0.2, limit = 200 }
world:step(30)

--: cloth:attach
local pole = world:body { shape = feder.box(0.1, 2, 0.1), position = { 0, 1, 0 } }
local flag = world:cloth { size = { 1, 0.6 }, position = { 0.6, 2, 0 } }
flag:attach(1, pole)

--: hit
world:on("hit", { min_speed = 1 }, function(e) print(e.speed, "m/s", e.impulse, "N s") end)

--: sensor_enter
local gate = world:region { box = { { -1, 0, -1 }, { 1, 2, 1 } } }
world:on("sensor_enter", { sensor = gate }, function(e) print(e.other:kind()) end)

--: warning
world:on("warning", function(e) print(e.code, e.message) end)
