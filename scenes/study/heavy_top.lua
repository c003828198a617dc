-- A disc on a weightless axle, its foot held by a ball joint, let go tilted and spinning: it precesses and nods as
-- Euler's equations say (Lagrange 1788). The errors are those of the disc's centre.
local feder = require "feder"
local problem = require "feder.problem"

local tilt = feder.param("tilt", 0.5235987755982988, { min = 0, max = 3.14, help = "of the axis from the vertical, rad" })
local spin = feder.param("spin", 50, { min = -1e3, max = 1e3, help = "about the axis, rad/s" })
local seconds = feder.param("t_end", 2, { min = 1e-3, max = 1e3, help = "s" })

local g, radius, thickness, distance = 9.81, 0.5, 0.1, 0.5  -- m; the mass is 1 kg
local about = 0.5 * radius * radius
local across = (3 * radius * radius + thickness * thickness) / 12 + distance * distance
local turning, height = 0.5 * about * spin * spin, g * distance  -- J

local disc, exact

local function course(t)
  local q, w = exact(t)
  local _, axis = problem.axes(q[1], q[2], q[3], q[4])
  local x, v = {}, problem.cross(w, axis)
  for i = 1, 3 do x[i], v[i] = distance * axis[i], distance * v[i] end
  return { x = x, v = v }
end

return feder.scene {
  title = "Heavy top",
  seconds = seconds,
  picture = 0.5,
  world = { gravity = { 0, -g, 0 }, dt = 1 / 480, substeps = 4, sleeping = false },

  study = {
    observe = function() return { x = { disc:position() }, v = { disc:velocity() } } end,
    reference = course,
    energy = turning + height * math.cos(tilt),
    constraint = function(world) return world:residuals()["rigid.joint_error_m"] / distance end,
    scale = { length = distance, velocity = math.sqrt(2 * g * distance), energy = math.max(turning, height) },
    certainty = { source = "Euler's equations, extrapolated", kind = "quad", uncertainty = 1e-12, rounding = 100 },
    axes = { dt = problem.steps(seconds, 60 * seconds, 6) },
  },

  build = function(world)
    local axis = { -math.sin(tilt), math.cos(tilt), 0 }
    local function along(s) return { s * axis[1], s * axis[2], 0 } end
    disc = world:body { name = "disc", shape = feder.cylinder(radius, thickness), mass = 1, friction = 0,
      position = along(distance), rotation = { axis = { 0, 0, 1 }, angle = tilt }, angular_velocity = along(spin) }
    world:joint { type = "ball", a = disc, anchor = { 0, 0, 0 } }
    exact = problem.top({ across, about, across }, g * distance,
      { 0, spin, 0, 0, 0, math.sin(tilt / 2), math.cos(tilt / 2) }, seconds)
  end,

  check = function(world, _, expect)
    local x, y, z = disc:position()
    local at = course(world:time()).x
    expect.error(math.sqrt((x - at[1]) ^ 2 + (y - at[2]) ^ 2 + (z - at[3]) ^ 2), "<", 5e-3 * distance, "centre of the disc")
    expect.error(world:residuals()["rigid.joint_error_m"], "<", 1e-4 * distance, "the foot leaves its joint")
  end,
}
