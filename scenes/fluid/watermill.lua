-- A watermill: water shoots down a chute at the paddles of a wheel that a brake holds back. It strikes them at v, a
-- distance r from the axle, and leaves their tips as fast as these are: so the wheel settles at the w where
-- T = m (v r - w R^2), m in kg/s (Euler 1754), and the brake takes, T w, at most half of what the water brings.
local feder = require "feder"

local speed = feder.param("speed", 2.5, { min = 2, max = 3.5, help = "of the water that enters the chute, m/s" })
local brake = feder.param("brake", 250, { min = 100, max = 350, help = "torque of the brake on the axle, N m" })
local spacing = feder.param("spacing", 0.025, { min = 0.02, max = 0.03, help = "m" })

local radius, deep, paddles = 0.6, 0.22, 14  -- of the wheel, height of its paddles, m
local slope, long = feder.deg(40), 1         -- of the chute, and its length, m
local stream = 0.1                           -- depth of the water that enters it, m
local bed = 0.53                             -- distance of its bed from the axle, m
local engaged, from = 2, 3.5                 -- when the brake is put on, and when the wheel has settled, s

-- A point of the chute: so far before the point next to the axle, and so high above the bed.
local dx, dy = math.cos(slope), -math.sin(slope)
local function chute(ahead, above)
  local reach = bed - above
  return reach * dy - ahead * dx, -reach * dx - ahead * dy
end

local before = math.sqrt((radius + 0.01) ^ 2 - (bed - stream) ^ 2)  -- where it ends
local _, top = chute(before + long, stream / 2)
local _, struck = chute(0, stream / 4)
local v = math.sqrt(speed ^ 2 + 2 * 9.81 * (top - struck))          -- of the water that strikes the wheel, m/s
local r = bed - stream * speed / v / 2                              -- and its distance from the axle, m

local function wheel()
  local inner, parts = radius - deep, { { shape = feder.circle(0.1) } }
  for i = 1, paddles do
    local turn = { axis = { 0, 0, 1 }, angle = 2 * math.pi * i / paddles }
    local function plank(middle, length, thick)
      parts[#parts + 1] = { shape = feder.box(length, thick), rotation = turn,
        position = { middle * math.cos(turn.angle), middle * math.sin(turn.angle) } }
    end
    plank(inner / 2, inner, 0.02)
    plank(radius - deep / 2, deep, 0.04)
  end
  return feder.compound(parts)
end

return feder.scene {
  title = "Watermill",
  seconds = 7,
  picture = 4.5,
  camera = { target = { -0.35, 0, 0 }, distance = 5 },
  world = { gravity = { 0, -9.81 }, dt = 1 / 60, substeps = 4, dimension = 2 },

  build = function(world, scene)
    local function plank(x, y, w, h)
      world:body { type = "static", shape = feder.box(w, h), position = { x, y }, rotation = { axis = { 0, 0, 1 }, angle = -slope },
        color = "#8d8a84" }
    end
    local x, y = chute(before + long / 2, -0.03)
    plank(x, y, long + 0.1, 0.06)
    x, y = chute(before + long + 0.05, 0.1)
    plank(x, y, 0.06, 0.3)
    scene.wheel = world:body { name = "wheel", shape = wheel(), density = 200, position = { 0, 0 }, color = "wood" }
    -- the axle; a motor that aims at standing still is a brake
    scene.axle = world:joint { type = "hinge", a = scene.wheel, anchor = { 0, 0 }, axis = { 0, 0, 1 },
      motor = { speed = 0, max_torque = 1 } }
    world:after(engaged, function() scene.axle:set_motor(0, brake) end)
    scene.water = world:fluid { name = "water", spacing = spacing, viscosity = 0.001, color = "#3b7dbb" }
    x, y = chute(before + long, (stream + spacing) / 2)
    scene.sluice = scene.water:emitter { name = "sluice", position = { x, y }, direction = { dx, dy }, speed = speed,
      radius = stream / 2 }
    scene.drain = scene.water:drain { box = { { -4, -3, -1 }, { 4, -1.1, 1 } } }
    scene.turned = {}
    world:on("warning", function(e) scene.said = e.message end)
  end,

  update = function(world, scene)
    local _, _, w = scene.wheel:angular_velocity()
    feder.plot("turns per second", w / (2 * math.pi))
    scene.turned[#scene.turned + 1] = (scene.turned[#scene.turned] or 0) + w * world:dt()
    if not scene.came and world:time() >= from then scene.came, scene.first = scene.sluice:count(), #scene.turned end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(not scene.said, scene.said)
    expect(scene.water:count() + scene.drain:count() == scene.sluice:count(), "particles are missing")
    local first, last = scene.first, #scene.turned
    local middle, seconds = (first + last) // 2, (last - first) * world:dt()
    local _, particle = scene.water:mass()
    local m = (scene.sluice:count() - scene.came) * particle / seconds
    local w = (scene.turned[last] - scene.turned[first]) / seconds
    local wanted = (v * r - brake / m) / radius ^ 2
    expect.error(math.abs(w / wanted - 1), "<", 0.12, "angular velocity of the wheel")
    local before_middle, after_middle = scene.turned[middle] - scene.turned[first], scene.turned[last] - scene.turned[middle]
    expect.error(math.abs(before_middle / after_middle - 1), "<", 0.1, "change of the angular velocity")
    -- T w is largest where w R is half of v: half of what the jet brings, less where it strikes within the tips
    expect.error(brake * w / (m * v ^ 2 / 2), "<", 0.5, "power taken, of that of the jet")
  end,
}
