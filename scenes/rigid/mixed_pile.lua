-- Every convex shape, dropped into a bin: boxes, balls, capsules, cylinders, cones and hulls of random points.
local feder = require "feder"

local count = feder.param("count", 120, { min = 1, max = 2000, step = 1 })

local function random_hull(radius)
  local points = {}
  for i = 1, 16 do
    local x, y, z = math.random() * 2 - 1, math.random() * 2 - 1, math.random() * 2 - 1
    local n = math.sqrt(x * x + y * y + z * z) + 1e-6
    points[i] = { x / n * radius, y / n * radius, z / n * radius }
  end
  return feder.hull(points)
end

return feder.scene {
  title = "Mixed pile",
  seconds = 8,
  picture = 5,
  camera = { target = { 0, 0.6, 0 }, distance = 16, pitch = feder.deg(50) },
  world = { dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), friction = 0.7 }
    for _, side in ipairs { { 1, 0 }, { -1, 0 }, { 0, 1 }, { 0, -1 } } do
      world:body {
        name = "side", type = "static", shape = feder.box(side[1] ~= 0 and 0.5 or 7, 4, side[1] ~= 0 and 7 or 0.5),
        position = { 3.25 * side[1], 2, 3.25 * side[2] }, friction = 0.5,
      }
    end
    local makers = {
      function() return feder.box(0.6, 0.4, 0.8) end,
      function() return feder.sphere(0.3) end,
      function() return feder.capsule(0.2, 0.9) end,
      function() return feder.cylinder(0.3, 0.6) end,
      function() return feder.cone(0.35, 0.7) end,
      function() return random_hull(0.45) end,
    }
    scene.things = {}
    for i = 0, count - 1 do
      scene.things[#scene.things + 1] = world:body {
        shape = makers[i % #makers + 1](), density = 700, friction = 0.6, rolling_friction = 0.01,
        position = { (i % 4) * 1.3 - 1.95 + 0.05 * math.random(), 1 + math.floor(i / 16) * 1.2, (math.floor(i / 4) % 4) * 1.3 - 1.95 },
        rotation = { axis = { math.random() - 0.5, math.random() - 0.5, math.random() - 0.5 }, angle = 6 * math.random() },
        angular_damping = 0.05,
      }
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(world:max_penetration() < 0.04, "overlap of " .. world:max_penetration() .. " m")
    local kinetic = world:energy()
    local mass = 0
    for _, thing in ipairs(scene.things) do
      local x, y, z = thing:position()
      expect(y > 0.05, "something fell through the floor: y = " .. y)
      expect(math.abs(x) < 3.5 and math.abs(z) < 3.5 or y > 3, "something left the bin through a side: " .. x .. ", " .. z)
      mass = mass + thing:mass()
    end
    expect(kinetic / mass < 0.01, ("still moving: %.4f J/kg"):format(kinetic / mass))
  end,
}
