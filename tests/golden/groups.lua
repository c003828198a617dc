-- Cloths that do not meet: a long taut strip that wants many substeps, and slack sheets that want few.
local feder = require "feder"
require "feder.cloth"

local strips = feder.param("strips", 1, { min = 0, max = 1 })
local sheets = feder.param("sheets", 10, { min = 0, max = 10 })

return feder.scene {
  title = "One taut, ten slack",
  seconds = 1,
  build = function(world)
    if strips == 1 then
      world:cloth { size = { 0.4, 4 }, resolution = { 8, 80 }, position = { 0, 5, 0 }, pins = { "top" },
        rotation = { axis = { 1, 0, 0 }, angle = feder.deg(90) }, stretch = 20000 }
    end
    for i = 1, sheets do
      world:cloth { size = { 1, 1 }, resolution = { 16, 16 }, position = { 2 * i, 5, 0 },
        pins = { "top_left", "top_right" } }
    end
  end,
  check = function(world, _, expect) expect(world:is_finite()) end,
}
