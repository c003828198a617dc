-- A sheet falls on its edge and folds onto itself on the floor, layer upon layer, without passing through itself.
local feder = require "feder"
local cloth = require "feder.cloth"

local rows = feder.param("rows", 40, { min = 20, max = 60 })

return feder.scene {
  title = "Fold",
  seconds = 10,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), friction = 0.8 }
    scene.sheet = world:cloth(cloth.of("wool", { name = "sheet", size = { 1, 1 }, resolution = { rows, rows },
      position = { 0, 0.55, 0 }, rotation = { axis = { 1, 0, 0 }, angle = feder.deg(84) }, friction = 0.5,
      damping = 0.01, color = "#8d5fb3" }))
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    local n = select(1, scene.sheet:count())
    local high, covered = 0, {}
    for i = 1, n do
      local x, y, z = scene.sheet:point(i)
      expect(y > -0.01, ("vertex %d is %.3f m below the floor"):format(i, -y))
      high = math.max(high, y)
      covered[math.floor(z / 0.05)] = true
    end
    local columns = 0
    for _ in pairs(covered) do columns = columns + 1 end
    expect(high < 0.45, ("the sheet still stands %.2f m high"):format(high))
    expect(columns < 19, "the sheet lies flat: it did not fold")
    expect(scene.sheet:stretch() < 0.1, ("stretched by %.1f %%"):format(100 * scene.sheet:stretch()))
  end,
}
