-- A cape on the shoulders of a figure that runs and stops: it streams out behind and falls back.
local feder = require "feder"

local speed = feder.param("speed", 3, { min = 0, max = 5, help = "m/s" })

local width, length = 0.5, 1.0

return feder.scene {
  title = "Cape",
  seconds = 6,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { type = "static", shape = feder.plane() }
    local shape = feder.compound {
      { shape = feder.capsule(0.16, 1.3), position = { 0, -0.35, 0 } },
      { shape = feder.sphere(0.13), position = { 0, 0.42, 0 } },
    }
    scene.body = world:body { name = "figure", type = "kinematic", shape = shape, position = { 0, 1.1, 0 },
      friction = 0.3, color = "#40566b" }
    scene.cape = world:cloth { name = "cape", size = { width, length }, resolution = { 13, 25 },
      position = { -0.2, 1.3 - length / 2, 0 },
      rotation = { euler = { math.pi / 2, -math.pi / 2, 0 }, order = "xyz", fixed = true },
      area_density = 0.25, stretch = 4000, bend = 5e-5, damping = 0.01, friction = 0.3, color = "#8c2230" }
    scene.cape:attach("top", scene.body)
    scene.behind, scene.x = 0, 0
  end,

  update = function(world, scene)
    local t = world:time()
    -- runs along x from 1 s to 3 s, with a smooth start and stop
    local v = speed * math.max(0, math.min(1, (t - 1) * 2, (3 - t) * 2))
    scene.x = scene.x + v * world:dt()
    scene.body:move_to(scene.x, 1.1, 0)
    local n = scene.cape:count()
    local x = scene.cape:point(n - 6)
    if t > 2 and t < 3 then scene.behind = math.max(scene.behind, scene.x - x) end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.cape:stretch() < 0.1, ("the cape is stretched by %.1f %%"):format(100 * scene.cape:stretch()))
    if speed >= 3 then
      expect(scene.behind > 0.35, ("it streams out by %.2f m only"):format(scene.behind))
    end
    -- at rest it hangs behind again, outside of the body
    local n = scene.cape:count()
    local x, y = scene.cape:point(n - 6)
    expect(y < 0.8, ("its hem hangs at %.2f m"):format(y))
    for i = 1, n do
      local px, py, pz = scene.cape:point(i)
      local off = math.sqrt((px - scene.x) ^ 2 + pz ^ 2)
      expect(off > 0.15 or py > 1.25, ("vertex %d is inside the figure"):format(i))
    end
  end,
}
