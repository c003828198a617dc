-- A drop in space without gravity, drawn out along x and let go: it passes its sphere after a quarter and after three
-- quarters of a period, which is Lamb's (Hydrodynamics, art. 275), of small swings.
local feder = require "feder"
local problem = require "feder.problem"

local p = problem.fluid(20, 2, { "dfsph", "wcsph" })  -- pbf draws the drop together and does not let it swing
local tension = feder.param("tension", 125, { min = 1, max = 1e5, help = "N/m; 125 makes a period of 2.221 s" })
p.world.dimension = 3

return feder.scene(problem.swinging_drop(p, {
  title = "Swinging drop in space",
  tension = tension,
}))
