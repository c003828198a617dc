-- Field stones are poured into a crib and come to rest on each other: hulls of random points, whose closest features
-- hardly change from one step to the next. narrow_phase = "voronoi" keeps them; --set narrow_phase=gjk starts anew.
local feder = require "feder"

local count = feder.param("count", 120, { min = 1, max = 600, step = 1, help = "stones" })
local corners = feder.param("corners", 24, { min = 12, max = 200, step = 1, help = "points of a stone's hull" })
local narrow = feder.param("narrow_phase", "voronoi", { choices = { "voronoi", "gjk", "auto" } })

-- flat, as frost splits them
local function stone(size)
  local points = {}
  for i = 1, corners do
    local x, y, z = math.random() * 2 - 1, math.random() * 2 - 1, math.random() * 2 - 1
    local n = math.sqrt(x * x + y * y + z * z) + 1e-6
    points[i] = { x / n * size, 0.55 * y / n * size, 0.8 * z / n * size }
  end
  return feder.hull(points)
end

return feder.scene {
  title = "Stones",
  seconds = 8,
  picture = 7,
  camera = { target = { 0, 0.5, 0 }, distance = 7, pitch = feder.deg(25) },
  world = { dt = 1 / 60, substeps = 4, narrow_phase = narrow },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), friction = 0.8 }
    for k = 0, 3 do
      local along = k % 2 == 0
      world:body {
        name = "side", type = "static", shape = feder.box(along and 2.4 or 0.2, 0.6, along and 0.2 or 2.4), friction = 0.7,
        position = { along and 0 or 1.1 * (2 - k), 0.3, along and 1.1 * (1 - k) or 0 }, color = { 0.55, 0.4, 0.25 },
      }
    end
    scene.stones = {}
    for i = 1, count do
      scene.stones[i] = world:body {
        shape = stone(0.2 + 0.15 * math.random()), density = 2600, friction = 0.7, rolling_friction = 0.005,
        position = { 0.6 * (i % 2) - 0.3 + 0.1 * math.random(), 0.5 + 0.35 * (i // 4), 0.6 * (i // 2 % 2) - 0.3 },
        rotation = { axis = { math.random() - 0.5, math.random(), math.random() - 0.5 }, angle = 3 * math.random() },
        angular_damping = 0.05,
      }
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(world:max_penetration() < 0.02, ("overlap of %.3f m"):format(world:max_penetration()))
    local mass, energy, top = 0, 0, 0
    for _, s in ipairs(scene.stones) do
      local _, y = s:position()
      expect(y > -0.1, "a stone fell through the floor: y = " .. y)
      mass, top = mass + s:mass(), math.max(top, y)
      local vx, vy, vz = s:velocity()
      energy = energy + s:mass() * (vx * vx + vy * vy + vz * vz) / 2
    end
    local handed_on = world:residuals()["collide.handed_on"]
    expect((handed_on ~= nil) == (narrow == "voronoi"), "only marching hands pairs on")
    expect((handed_on or 0) < count / 4, ("%d pairs went in circles, or are bent"):format(handed_on or 0))
    expect(energy / mass < 1e-3, ("still moving: %.5f J/kg"):format(energy / mass))
    expect(count < 120 or top > 0.7, ("a layer, not a heap: %.2f m high"):format(top))
  end,
}
