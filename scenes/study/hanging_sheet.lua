-- A sheet hung by its upper border: each link carries what is below it, so the places of the vertices at rest are known,
-- and what a run departs from them is its solver's (Macklin et al., Small Steps in Physics Simulation, 2019).
local feder = require "feder"
local problem = require "feder.problem"

local solvers = feder.choices("cloth.solver")
local solver = feder.param("solver", solvers[1], { choices = solvers })
local rows = feder.param("rows", 20, { min = 2, max = 200, step = 1, help = "links from the top to the bottom of 1 m" })
local stiffness = feder.param("stiffness", 2000, { min = 1, max = 1e8, help = "N/m, stretch" })
local load = feder.param("load", 0, { min = 0, max = 1e4, help = "force at the lower border by the weight of the sheet" })
local seconds = feder.param("t_end", 1, { min = 0.1, max = 60, help = "s" })
local iterations = feder.param("iterations", 0, { min = 0, max = 1000, step = 1, help = "in a substep; 0: the solver's own" })

local g, columns, area_density = 9.81, 3, 0.2
local link = 1 / rows
local width = link * (columns - 1)
local row = area_density * link * width * g
local hung = load * rows * row  -- N

local rest, y = {}, 0
for j = 0, rows do
  if j > 0 then y = y - link * (1 + (row * (rows - j + 0.5) + hung) / (stiffness * width)) end
  for i = 0, columns - 1 do rest[#rest + 1] = { (i / (columns - 1) - 0.5) * width, y, 0 } end
end

local sheet, energy

return feder.scene {
  title = "Hanging sheet",
  seconds = seconds,
  world = { gravity = { 0, -g, 0 }, dt = 1 / 60, substeps = 16, sleeping = false },

  study = problem.of_cloth(function() return sheet end, rest, function() return energy end, iterations, {
    scale = { length = -y, velocity = math.sqrt(-y * g), energy = (area_density * width * g + hung) * -y },
    -- places of a metre are rounded, and stiffness makes forces of it
    certainty = { source = "each link carries the weight below it", uncertainty = 1e-9, rounding = 10 },
    ladders = problem.cloth_ladders(solvers, seconds, { 2, 4, 8, 16, 32, 64, 128 }),
  }),

  build = function(world)
    sheet = world:cloth(problem.cloth(solver, iterations, { name = "sheet", size = { width, 1 },
      resolution = { columns, rows + 1 }, area_density = area_density, stretch = stiffness, shear = 0, bend = 0,
      pins = "top" }))
    problem.place(sheet, rest)
    if load > 0 then
      local share, vertex = hung / (columns - 1), 0
      world:force { on = sheet, each = function(x)  -- asked of one vertex after the other
        vertex = vertex % #rest + 1
        if vertex <= #rest - columns then return 0, 0, 0 end
        return 0, math.abs(x) > width / 4 and -share / 2 or -share, 0  -- the outer columns hold half as much cloth
      end }
    end
    energy = problem.energy(world)
  end,

  check = function(_, _, expect)
    expect.error(problem.distance(sheet, rest), "<", 0.01, "vertices")
  end,
}
