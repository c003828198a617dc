-- Two systems and nothing else, meeting each other: one golden hash for each pair of systems and each solver.
-- `below` lies or hangs, `above` falls on it. Bodies bring a floor; everything else is held by its edge, or falls.
local feder = require "feder"
local build = require "feder.build"

local kinds = { "rigid", "net", "cloth", "rope", "soft", "fluid" }
local below = feder.param("below", "rigid", { choices = kinds })
local above = feder.param("above", "rigid", { choices = kinds })
local cloth = feder.param("cloth", "xpbd", { choices = { "xpbd", "mass_spring", "vbd", "implicit" } })
local soft = feder.param("soft", "xpbd", { choices = { "xpbd", "vbd", "implicit" } })
local elasticity = feder.param("elasticity", "neo_hookean", { choices = { "neo_hookean", "corotated", "stvk" } })
local fluid = feder.param("fluid", "pbf", { choices = { "pbf", "wcsph", "dfsph" } })
local integrator = feder.param("integrator", "symplectic_euler", { choices = { "explicit_euler", "symplectic_euler",
  "midpoint", "heun", "rk2", "rk4", "leapfrog", "velocity_verlet", "yoshida4", "rk45", "implicit_euler",
  "implicit_midpoint", "bdf2", "tr_bdf2", "ros2", "exponential" } })

local make = {}

function make.rigid(world, name, y)
  world:body { name = name .. " box", shape = feder.box(0.3, 0.2, 0.3), position = { 0.02, y, 0.03 }, density = 300,
    rotation = { axis = { 1, 2, 3 }, angle = 0.4 }, friction = { static = 0.6, dynamic = 0.4 } }
  local ball = world:body { name = name .. " ball", shape = feder.sphere(0.1), position = { 0.45, y, 0 }, density = 400,
    restitution = 0.4 }
  local link = world:body { name = name .. " link", shape = feder.capsule(0.05, 0.3), position = { 0.45, y + 0.3, 0 } }
  world:joint { type = "ball", a = ball, b = link, anchor = { 0.45, y + 0.12, 0 } }
end

function make.net(world, name, y, held)
  local points, springs, faces = build.grid { count = { 9, 9 }, size = { 1.2, 1.2 }, position = { 0, y, 0 },
    stiffness = 600, damping = 0.5 }
  local net = world:net { name = name, points = points, springs = springs, faces = faces, masses = 0.02, radius = 0.04,
    damping = 0.3, integrator = integrator }
  for _, i in ipairs(held and { 1, 9, 73, 81 } or {}) do net:pin(i) end
end

function make.cloth(world, name, y, held)
  world:cloth { name = name, size = { 1.2, 1.2 }, resolution = { 9, 9 }, position = { 0, y, 0 }, solver = cloth,
    stretch = 300, pins = held and { 1, 9, 73, 81 } or nil }
end

function make.rope(world, name, y, held)
  world:rope { name = name, from = { -0.6, y, 0.1 }, to = { 0.6, y, -0.05 }, radius = 0.03, density = 300, stretch = 2000,
    pins = held and { "first", "last" } or nil }
  world:rope { name = name .. " stiff", from = { -0.1, y, -0.6 }, to = { 0.15, y, 0.6 }, radius = 0.03, density = 300,
    bend = 0.2, pins = held and "first_clamped" or nil }
end

function make.soft(world, name, y, held)
  local block = world:soft { name = name, shape = feder.box(0.8, 0.16, 0.3), resolution = 8, position = { 0.05, y, -0.02 },
    density = 400, young = 1e5, friction = 0.3, solver = soft, elasticity = elasticity }
  for i = 1, held and (block:count()) or 0 do
    if math.abs(block:rest_point(i)) > 0.39 then block:pin(i) end
  end
end

function make.fluid(world, name, y)
  local water = world:fluid { name = name, spacing = 0.08, solver = fluid, viscosity = 0.1, max_particles = 500 }
  water:fill { box = { { -0.2, y, -0.2 }, { 0.25, y + 0.4, 0.25 } } }
end

return feder.scene {
  title = "Golden pair",
  seconds = 4,
  build = function(world)
    if below == "rigid" or above == "rigid" then world:body { name = "floor", type = "static", shape = feder.plane() } end
    make[below](world, "lower", 0.5, true)
    make[above](world, "upper", 1.0, false)
  end,
}
