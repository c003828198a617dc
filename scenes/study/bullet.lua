-- A ball at high speed against a thin wall, without restitution: it must lie before the wall in the end. What discrete
-- collision would miss is continuous collision's to find (Mirtich 1996).
local feder = require "feder"
local problem = require "feder.problem"

local radius, way = 0.1, 5  -- m

local speed = feder.param("speed", 1000, { min = 0.1, max = 1e5, help = "m/s" })
local thickness = feder.param("thickness", 0.01, { min = 1e-4, max = 1, help = "of the wall, m" })
local bullet = feder.param("bullet", true, { help = "whether the ball is declared a bullet" })
local seconds = math.max(1 / 6, 2 * way / speed)

local function course(t)
  if speed * t >= way - radius then return way - radius, 0 end
  return speed * t, speed
end

return feder.scene {
  title = "Bullet",
  seconds = seconds,
  picture = 0.1,
  camera = { target = { way, 0, 0 }, distance = 7, yaw = feder.deg(-50), pitch = feder.deg(20) },
  world = { gravity = { 0, 0, 0 }, dt = 1 / 60, substeps = 4, sleeping = false },

  study = {
    reference = function(t)
      local x, v = course(t)
      return { x = { x, 0, 0 }, v = { v, 0, 0 } }
    end,
    energy = function(t)
      local _, v = course(t)
      return v * v / 2
    end,
    constraint = function(world) return math.max(0, world:max_penetration()) / (2 * radius) end,
    interpolate = false,  -- there is nothing between the steps of an impact
    scale = { length = way, velocity = speed, energy = speed * speed / 2 },
    certainty = { source = "stopped by the wall" },
    axes = { dt = problem.steps(seconds, 60 * seconds, 5) },
  },

  build = function(world, scene)
    world:body { type = "static", shape = feder.box(thickness, 4, 4), position = { way + thickness / 2, 0, 0 },
      friction = 0 }
    scene.ball = world:body { name = "ball", shape = feder.sphere(radius), mass = 1, friction = 0,
      velocity = { speed, 0, 0 }, bullet = bullet }
  end,

  check = function(world, scene, expect)
    local x, y, z = scene.ball:position()
    expect.error(math.abs(x - course(world:time())) + math.abs(y) + math.abs(z), "<", radius, "place before the wall")
  end,
}
