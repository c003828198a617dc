-- Honey and water: two columns of one size are let go, back to back. The water is three widths out, as Martin and Moyce
-- measured in 1952, before the honey has moved by one. The honey creeps: in the end as the fifth root of time,
-- x = 1.411 (g q^3 t / (3 nu))^(1/5) (Huppert, JFM 121, 1982). One solver for both.
local feder = require "feder"
local fluid = require "feder.fluid"

local spacing = feder.param("spacing", 0.005, { min = 0.004, max = 0.006, help = "m" })
local viscosity = feder.param("viscosity", 10, { min = 8, max = 100, help = "of the honey, Pa s" })

local a, wall, far = 0.1, 0.02, 0.5  -- columns a x a, walls, half of the tank, m
local density = 1420

return feder.scene {
  title = "Honey and water",
  seconds = 4.5,
  picture = 0.22,
  camera = { target = { 0, 0.08, 0 }, distance = 2.05 },
  world = { gravity = { 0, -9.81 }, dt = 1 / 60, substeps = 4, dimension = 2 },

  build = function(world, scene)
    for _, x in ipairs { -far - wall, -wall / 2, far } do
      world:body { type = "static", shape = feder.box(wall, 1.3 * a, 0.1), position = { x + wall / 2, 0.65 * a }, color = "#8d8a84" }
    end
    world:body { type = "static", shape = feder.box(2 * far + 2 * wall, wall, 0.1), position = { 0, -wall / 2 }, color = "#8d8a84" }
    scene.honey = world:fluid { name = "honey", spacing = spacing, density = density, viscosity = viscosity, color = "#d08a20" }
    scene.water = world:fluid { name = "water", spacing = spacing, viscosity = 0.001, color = "#3b7dbb" }
    local b = wall / 2
    scene.honey_count = scene.honey:fill { box = { { -b - a, 0 }, { -b, a } } }
    scene.count = scene.water:fill { box = { { b, 0 }, { b + a, a } } }
    scene.run = {}
    world:on("warning", function(e) scene.said = e.message end)
  end,

  -- how far they have come, from their walls
  update = function(world, scene)
    local x, honey = scene.honey:positions(), 0
    for i = 1, #x, 3 do honey = math.max(honey, -x[i] + spacing / 2 - wall / 2) end
    scene.run[#scene.run + 1] = { t = world:time(), water = fluid.front(scene.water) - wall / 2, honey = honey }
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(not scene.said, scene.said)
    expect(scene.water:count() == scene.count and scene.honey:count() == scene.honey_count, "particles are missing")
    -- when the water is three widths out, by the last of the films; where the honey is then
    local film, t, honey = fluid.martin_moyce[#fluid.martin_moyce], nil, nil
    for k = 2, #scene.run do
      local p, q = scene.run[k - 1], scene.run[k]
      if not t and q.water >= film[2] * a then
        t, honey = p.t + (film[2] * a - p.water) / (q.water - p.water) * (q.t - p.t), q.honey
      end
    end
    if expect(t, "the water does not run") then
      local wanted = (film[1] - fluid.diaphragm_delay) * math.sqrt(a / 9.81)
      -- fronts of dfsph are ahead of the films at any resolution
      expect.error(math.abs(t / wanted - 1), "<", 0.13, "time of the water to three widths")
      expect.error(honey, "<", 2 * a, "front of the honey by then, m")
    end
    -- the law holds once the heap has forgotten its start: four times as wide
    local last = scene.run[#scene.run]
    local law = 1.411 * (9.81 * a ^ 6 * last.t / (3 * viscosity / density)) ^ 0.2
    if law > 4 * a then expect.error(math.abs(last.honey / law - 1), "<", 0.1, "front of the honey") end
    -- in the end the water is level, and the honey still a heap
    local level = a * a / (far - wall / 2)
    for k = 1, 4 do
      local y = scene.water:height_at(k * far / 5, 0) or 0
      expect(math.abs(y - level) < spacing, ("the water stands at %.3f m, not %.3f"):format(y, level))
    end
    local heap = scene.honey:height_at(-wall, 0) or 0
    expect(heap > level + spacing, ("the honey is as flat as the water: %.3f m"):format(heap))
  end,
}
