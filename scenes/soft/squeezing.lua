-- scenes/soft/squeezing.lua: a plunger pushes a soft ball through a funnel with a neck narrower than the ball. Behind
-- it the ball has its volume and its shape again.
local feder = require "feder"

local hole = feder.param("hole", 0.075, { min = 0.065, max = 0.095, help = "its radius, m; the ball's is 0.1" })
local young = feder.param("young", 3e4, { min = 2e4, max = 1e5, help = "Pa" })

local radius, cell = 0.1, 0.01  -- of the ball, of the field of the block, m
local rim, shoulder, top, bottom = 0.75, 0.62, 0.47, 0.2  -- heights of the funnel, m; the last two are its neck's

-- A block with a hole that narrows from the radius `wide` to the neck's: by its exact distances near the hole.
local function funnel()
  local wide = 0.13
  local slope = (wide - hole) / (shoulder - top)
  return feder.sdf { size = { 0.44, rim - bottom + 0.08, 0.44 }, spacing = cell, fn = function(x, y, z)
    local r, h = math.sqrt(x * x + z * z), y + (rim + bottom) / 2
    local inner = math.max(hole, math.min(wide, hole + (h - top) * slope)) - r
    if h > top and h < shoulder then inner = inner / math.sqrt(1 + slope * slope) end
    return math.max(inner, r - 0.2, h - rim, bottom - h)
  end }
end

return feder.scene {
  title = "Squeezing through",
  seconds = 3,
  picture = 1.4,
  camera = { target = { 0, 0.35, 0 }, distance = 1.2, yaw = feder.deg(30), pitch = feder.deg(12) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    world:body { name = "funnel", type = "static", shape = funnel(), position = { 0, (rim + bottom) / 2, 0 },
      friction = 0.2, transparency = 0.6 }
    scene.ball = world:soft { name = "ball", shape = feder.sphere(radius), resolution = 5, position = { 0, 0.75, 0 },
      young = young, poisson = 0.4, friction = 0.2, damping = 0.005, color = "#c8553d" }
    scene.plunger = world:body { name = "plunger", type = "kinematic", shape = feder.cylinder(0.06, 0.2),
      position = { 0, 1.05, 0 }, color = "#6f5a3c" }
  end,

  update = function(world, scene)
    scene.plunger:move_to(0, math.max(1.05 - 0.4 * math.max(0, world:time() - 0.3), 0.33), 0)
    scene.narrowest = math.min(scene.narrowest or 1, scene.ball:volume() / scene.ball:rest_volume())
    for k = 1, scene.ball:count() do
      local x, y, z = scene.ball:point(k)
      if y > bottom and y < top then scene.widest = math.max(scene.widest or 0, math.sqrt(x * x + z * z)) end
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect.no_warnings()
    local ball = scene.ball
    local n, middle, size, rest_size = ball:count(), { 0, 0, 0 }, 0, 0
    local points = {}
    for k = 1, n do
      points[k] = { ball:point(k) }
      for a = 1, 3 do middle[a] = middle[a] + points[k][a] / n end
    end
    for k, p in ipairs(points) do
      local x, y, z = ball:rest_point(k)
      rest_size = rest_size + (x * x + y * y + z * z) / n
      size = size + ((p[1] - middle[1]) ^ 2 + (p[2] - middle[2]) ^ 2 + (p[3] - middle[3]) ^ 2) / n
    end
    -- it is through, and passed the neck, not its wall
    expect.error(middle[2], "<", radius, "height of the ball's middle")
    expect.error(middle[2], ">", 0.75 * radius, "height of the ball's middle")
    expect.error(scene.widest, "<", hole + cell, "radius of the ball in the neck")
    expect.error(scene.narrowest, "<", 0.5 + 0.5 * hole / radius, "share of its volume that the neck leaves")
    -- and it is what it was
    expect(ball:inverted() == 0, "the ball has tetrahedra inside out")
    expect.error(math.abs(ball:volume() / ball:rest_volume() - 1), "<", 0.02, "change of volume")
    expect.error(math.abs(math.sqrt(size / rest_size) - 1), "<", 0.01, "change of the radius of gyration")
  end,
}
