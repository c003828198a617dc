-- A water wheel: a hose fills the buckets on one side of a wheel on an axle, and their weight turns it.
local feder = require "feder"

local speed = feder.param("speed", 1.5, { min = 0.5, max = 4, help = "of the jet, m/s" })
local brake = feder.param("brake", 2, { min = 0, max = 20, help = "torque of the brake on the axle, N m" })

local radius, width, buckets = 0.6, 0.3, 10  -- m

-- A bucket wheel about z, as one body: a drum, and around it a plank and a lip for every bucket.
local function wheel()
  local parts = { { shape = feder.cylinder(0.36, width), rotation = { axis = { 1, 0, 0 }, angle = feder.deg(90) } } }
  for i = 1, buckets do
    local a = 2 * math.pi * i / buckets
    parts[#parts + 1] = { shape = feder.box(0.3, 0.03, width), position = { 0.46 * math.cos(a), 0.46 * math.sin(a), 0 },
      rotation = { axis = { 0, 0, 1 }, angle = a } }
    parts[#parts + 1] = { shape = feder.box(0.03, 0.2, width),
      position = { 0.6 * math.cos(a) - 0.09 * math.sin(a), 0.6 * math.sin(a) + 0.09 * math.cos(a), 0 },
      rotation = { axis = { 0, 0, 1 }, angle = a } }
  end
  return feder.compound(parts)
end

return feder.scene {
  title = "Water wheel",
  seconds = 6,
  picture = 4,
  camera = { target = { 0, 0.95, 0 }, distance = 3.6, yaw = feder.deg(30), pitch = feder.deg(12) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    for _, side in ipairs { -1, 1 } do
      world:body { name = "post", type = "static", shape = feder.box(0.1, 0.95, 0.08), color = "brown",
        position = { 0, 0.475, side * 0.28 } }
    end
    scene.wheel = world:body { name = "wheel", shape = wheel(), density = 300, color = "wood",
      position = { 0, 0.85, 0 } }
    -- the axle: a hinge to the world. A motor that aims at standing still is a brake
    scene.axle = world:joint { type = "hinge", a = scene.wheel, anchor = { 0, 0.85, 0 }, axis = { 0, 0, 1 },
      motor = { speed = 0, max_torque = brake } }

    local water = world:fluid { name = "water", spacing = 0.03 }
    water:emitter { position = { -0.45, 1.75, 0 }, direction = { 0, -1, 0 }, speed = speed, radius = 0.08 }
    -- what lies on the floor goes down a drain, so the scene costs the same however long it runs
    scene.drain = water:drain { box = { { -4, -0.1, -4 }, { 4, 0.06, 4 } } }
    scene.water, scene.turned = water, 0
  end,

  update = function(world, scene)
    local _, _, turning = scene.wheel:angular_velocity()
    scene.turned = scene.turned + turning * world:dt() / (2 * math.pi)
    feder.plot("turns per second", turning / (2 * math.pi))
  end,

  check = function(world, scene, expect)
    expect(scene.turned > 0.7, ("the wheel made %.2f turns"):format(scene.turned))
    local x, y = scene.wheel:position()
    expect(math.abs(x) < 0.02 and math.abs(y - 0.85) < 0.02, "the wheel has left its axle")
    expect(scene.drain:count() > 0, "no water has come down")
  end,
}
