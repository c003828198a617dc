-- Oil lies under water, rises through it, and ends on top: fluids that touch are solved as one and do not mix.
local feder = require "feder"

local spacing = feder.param("spacing", 0.03, { min = 0.02, max = 0.05, help = "m" })
local ratio = feder.param("ratio", 1.25, { min = 1.25, max = 100, help = "density of the water over that of the oil" })
local start = feder.param("start", "below", { choices = { "below", "blobs" }, help = "where the oil is" })

local density = 1000                 -- of the water, kg/m^2
local across, deep = 30, 10          -- spacings, of each fluid
local width, depth = across * spacing, deep * spacing

return feder.scene {
  title = "Oil on water",
  seconds = 15,
  world = { gravity = { 0, -9.81 }, dt = 1 / 60, substeps = 4, dimension = 2 },

  build = function(world, scene)
    for _, p in ipairs { { 0, 1, 0 }, { 1, 0, 0 }, { -1, 0, -width } } do
      world:body { type = "static", shape = feder.plane(p[1], p[2], 0, p[3]) }
    end
    scene.water = world:fluid { name = "water", spacing = spacing, density = density, color = "#3b7dbb" }
    scene.oil = world:fluid { name = "oil", spacing = spacing, density = density / ratio, color = "#e0a030" }
    local function fill(of, x, y, w, h) of:fill { box = { { x, y }, { x + w, y + h } } } end
    if start == "below" then
      fill(scene.oil, 0, 0, width, depth)
      fill(scene.water, 0, depth, width, depth)
    else
      local square = 5 * spacing
      for row = 0, 2 * deep / 5 - 1 do
        for column = 0, across / 5 - 1 do
          fill((row + column) % 2 == 0 and scene.oil or scene.water, column * square, row * square, square, square)
        end
      end
    end
    scene.count = scene.oil:count() + scene.water:count()
    scene.sum, scene.samples = 0, 0
  end,

  update = function(world, scene)
    if world:time() < 11 or world:step_count() % 6 ~= 0 then return end
    for k = 1, across - 1, 4 do
      scene.sum = scene.sum + scene.water:pressure_at(k * spacing, spacing, 0)
      scene.samples = scene.samples + 1
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.oil:count() + scene.water:count() == scene.count, "particles are missing")
    -- the volumes are equal, so half of what is there lies on either side
    local function misplaced(of, wrong)
      local x, n = of:positions(), 0
      for i = 2, #x, 3 do n = n + (wrong(x[i]) and 1 or 0) end
      return n
    end
    local astray = misplaced(scene.oil, function(y) return y < depth - spacing end)
      + misplaced(scene.water, function(y) return y > depth + spacing end)
    expect(astray < 0.01 * scene.count, ("%d of %d particles lie on the wrong side"):format(astray, scene.count))
    -- over the last seconds; weight of all that lies above one spacing
    local mean, weight = scene.sum / scene.samples, 9.81 * density * (depth / ratio + depth - spacing)
    expect(math.abs(mean / weight - 1) < 0.05, ("pressure %.0f Pa, the weight above is %.0f"):format(mean, weight))
  end,
}
