-- A drop without gravity, drawn out along x and let go: it passes its circle after a quarter and after three quarters of
-- a period, which is that of Rayleigh (1879), of small swings.
local feder = require "feder"
local problem = require "feder.problem"

local p = problem.fluid(24, 2.4)
local tension = feder.param("tension", 125, { min = 1, max = 1e5, help = "N/m; 125 makes a period of 2.565 s" })

return feder.scene(problem.swinging_drop(p, {
  title = "Swinging drop",
  tension = tension,
}))
