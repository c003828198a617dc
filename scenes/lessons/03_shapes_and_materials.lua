-- Lesson 3: shapes and materials on a slope: what is round rolls, ice slides, wood and rubber stay.
local feder = require "feder"

local slope = feder.param("slope", 14, { min = 0, max = 40, help = "degrees" })

-- one row per lane: name, shape, material, and whether it should leave its place on a slope of 14 degrees
local lanes = {
  { "ice", feder.box(0.5, 0.5, 0.5), "ice", true },
  { "crate", feder.box(0.5, 0.5, 0.5), "wood", false },
  { "tyre", feder.box(0.5, 0.5, 0.5), "rubber", false },
  { "ball", feder.sphere(0.25), "rubber", true },
  { "can", feder.cylinder(0.25, 0.5), "wood", false },
  { "hat", feder.cone(0.3, 0.5), "wood", false },
  { "table", feder.compound {
    { shape = feder.box(0.6, 0.06, 0.6), position = { 0, 0.22, 0 } },
    { shape = feder.box(0.3, 0.44, 0.3), position = { 0, -0.03, 0 } },
  }, "wood", false },
}

return feder.scene {
  title = "3 Shapes and materials",
  seconds = 2.5,
  picture = 0.7,
  camera = { target = { 0.5, 0.6, 0 }, distance = 9, yaw = feder.deg(-35), pitch = feder.deg(20) },
  -- materials hold what bodies have in common; friction of a pair is the root of the product of both
  world = { materials = {
    ice = { friction = 0.02, density = 917, color = "ice" },
    wood = { friction = 0.5, density = 600, color = "wood" },
    rubber = { friction = 0.9, density = 1100, restitution = 0.6, color = "rubber" },
  } },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    local tilt = feder.deg(slope)
    local turned = { axis = { 0, 0, 1 }, angle = -tilt }
    world:body { name = "slope", type = "static", shape = feder.box(6, 0.2, 8), material = "wood",
      position = { 0, 1.2, 0 }, rotation = turned }
    scene.things, scene.start = {}, {}
    -- near the upper end: 2 m up along the slope, and off its surface by half a thing's height
    local up, off = 2, 0.1 + 0.25
    for i, lane in ipairs(lanes) do
      scene.start[i] = off * math.sin(tilt) - up * math.cos(tilt)
      scene.things[i] = world:body { name = lane[1], shape = lane[2], material = lane[3], rotation = turned,
        position = { scene.start[i], 1.2 + up * math.sin(tilt) + off * math.cos(tilt), i - 4 } }
    end
  end,

  check = function(world, scene, expect)
    for i, lane in ipairs(lanes) do
      local way = scene.things[i]:position() - scene.start[i]
      if lane[4] then
        expect(way > 1, ("%s has moved by %.2f m only"):format(lane[1], way))
      else
        expect(math.abs(way) < 0.05, ("%s has moved by %.2f m"):format(lane[1], way))
      end
    end
  end,
}
