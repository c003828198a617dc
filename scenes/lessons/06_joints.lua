-- Lesson 6: joints: a chain of ball joints, a propeller on a hinge with a motor, a door with limits, a box on a springy
-- cord, and a shelf whose weld breaks under what falls on it.
local feder = require "feder"

local strength = feder.param("strength", 500, { min = 100, max = 200000, help = "of the shelf's weld, N" })
local up, across = { 0, 1, 0 }, { 0, 0, 1 }

return feder.scene {
  title = "6 Joints",
  seconds = 6,
  picture = 1.5,
  camera = { target = { 0.6, 1.8, 0 }, distance = 9.5, yaw = feder.deg(16), pitch = feder.deg(10) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }

    -- ball joints: bodies turn freely about a point. A joint that names one body holds it to the world
    local last
    for i = 1, 6 do
      local link = world:body { name = "link" .. i, shape = feder.capsule(0.06, 0.4), color = "steel",
        position = { -3.3 + 0.35 * i, 3.4, 0 }, rotation = { axis = across, angle = feder.deg(90) } }
      world:joint { type = "ball", a = link, b = last, anchor = { -3.3 + 0.35 * (i - 0.5), 3.4, 0 } }
      last = link
    end
    scene.link = last

    -- hinges turn about an axis: with a motor, or within limits (the angle of b seen from a, 0 as built)
    scene.propeller = world:body { name = "propeller", shape = feder.box(1.6, 0.2, 0.06), color = "red",
      position = { 0, 2.2, 0 } }
    world:joint { type = "hinge", a = scene.propeller, axis = across, motor = { speed = 3, max_torque = 500 } }
    local post = world:body { name = "post", type = "static", shape = feder.box(0.1, 2, 0.1),
      position = { 1.02, 1, -1 } }
    local door = world:body { name = "door", shape = feder.box(1, 1.8, 0.08), color = "wood", position = { 1.6, 1, -1 },
      angular_velocity = { 0, 3, 0 } }
    scene.hinge = world:joint { type = "hinge", a = post, b = door, axis = up, anchor = { 1.08, 1, -1 },
      limits = { 0, feder.deg(80) } }

    -- a distance joint keeps two points apart: rigid, or as a spring of so many swings per second
    scene.box = world:body { name = "box", shape = feder.box(0.4, 0.4, 0.4), color = "green", position = { 2, 2.6, 0 } }
    world:joint { type = "distance", a = scene.box, anchor = { 2, 3.6, 0 },
      spring = { hertz = 1, damping_ratio = 0.2 } }

    -- a weld is rigid, and may break: its event comes once
    scene.shelf = world:body { name = "shelf", shape = feder.box(1, 0.08, 0.5), density = 300, color = "wood",
      position = { 3.6, 1.2, 0 } }
    world:joint { name = "bracket", type = "weld", a = scene.shelf, anchor = { 4, 1.2, 0 }, break_force = strength }
    world:body { name = "weight", shape = feder.sphere(0.2), density = 4000, color = "black", position = { 3.4, 3, 0 } }
    world:on("joint_break", function(e)
      scene.broken = e.object:name()
      print(("%.2f s: the %s breaks at %.0f N"):format(world:time(), e.object:name(), e.force))
    end)
  end,

  check = function(world, scene, expect)
    local _, low = scene.link:position()
    expect(low > 1 and low < 3, ("the end of the chain is at %.2f m"):format(low))
    local _, _, turning = scene.propeller:angular_velocity()
    expect(math.abs(math.abs(turning) - 3) < 0.1, ("the propeller turns at %.2f rad/s"):format(turning))
    local angle = scene.hinge:angle()
    expect(angle > -0.05 and angle < feder.deg(80) + 0.05, ("the door is open by %.2f rad"):format(angle))
    -- a spring of f swings per second gives way by g / (2 pi f)^2 under a weight
    local _, y = scene.box:position()
    expect(math.abs(y - (2.6 - 9.81 / (2 * math.pi) ^ 2)) < 0.1, ("the box hangs at %.2f m"):format(y))
    if strength <= 1000 then expect(scene.broken == "bracket", "the bracket holds") end
    if strength >= 100000 then expect(not scene.broken, "the bracket breaks") end
  end,
}
