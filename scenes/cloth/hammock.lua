-- A hammock: a cloth between two posts, its ends gathered by clew ropes, swings with boxes lying in it and comes to rest.
local feder = require "feder"

local boxes = feder.param("boxes", 3, { min = 2, max = 5, step = 1 })
local mass = feder.param("mass", 8, { min = 1, max = 12, help = "of a box, kg" })

local length, width, span, height = 2.0, 1.2, 3.7, 1.8  -- m: of the cloth, between the posts, of their rings
local sag = 0.2  -- m: of the cloth as it is hung up, below the rings
local columns, rows, clews = 25, 15, 8

-- A rope of a given length from a to b, hanging down between them in a parabola.
local function slack(a, b, wanted, segments)
  local function hung(depth)
    local points, long = {}, 0
    for i = 0, segments do
      local t = i / segments
      local p = {}
      for k = 1, 3 do p[k] = a[k] + t * (b[k] - a[k]) end
      p[2] = p[2] - 4 * depth * t * (1 - t)
      local q = points[i]
      if q then long = long + math.sqrt((p[1] - q[1]) ^ 2 + (p[2] - q[2]) ^ 2 + (p[3] - q[3]) ^ 2) end
      points[i + 1] = p
    end
    return points, long
  end
  local low, high = 0, wanted
  for _ = 1, 40 do
    local middle = (low + high) / 2
    if select(2, hung(middle)) < wanted then low = middle else high = middle end
  end
  return (hung(low))
end

return feder.scene {
  title = "Hammock",
  seconds = 12,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },
  camera = { target = { 0, 1, 0 }, distance = 4.5, yaw = feder.deg(25), pitch = feder.deg(18) },

  build = function(world, scene)
    world:body { name = "ground", type = "static", shape = feder.plane(), friction = 0.6 }
    scene.cloth = world:cloth { name = "hammock", size = { length, width }, resolution = { columns, rows },
      position = { 0, height - sag, 0 }, area_density = 0.35, stretch = 30000, shear = 6000, bend = 2e-4,
      damping = 0.01, thickness = 0.012, friction = 0.5, color = "#b5563c" }
    scene.ropes = {}
    for _, side in ipairs { -1, 1 } do
      local post = world:body { name = side < 0 and "left post" or "right post", type = "static",
        shape = feder.cylinder(0.06, 2.1), position = { side * (span / 2 + 0.06), 1.05, 0 }, color = "#6f5a3c" }
      for k = 0, clews - 1 do
        local row = k * (rows - 1) // (clews - 1)
        local i = row * columns + (side < 0 and 1 or columns)
        local x, y, z = scene.cloth:point(i)
        -- the clews in the middle are the longest, so that the cloth hangs as a trough
        local rope = world:rope { name = ("clew %d"):format(#scene.ropes + 1), radius = 0.004, density = 900,
          points = slack({ side * span / 2, height, 0 }, { x, y, z }, 1.14 - 0.06 * (2 * z / width) ^ 2, 12),
          stretch = 40000, damping = 0.0005, self_collision = false, group = 2, mask = 1, color = "#d8c9a0" }
        rope:attach(1, post)
        rope:attach(13, scene.cloth, i)
        scene.ropes[#scene.ropes + 1] = rope
      end
    end
    scene.boxes = {}
    for k = 1, boxes do
      scene.boxes[k] = world:body { name = "box" .. k, shape = feder.box(0.24, 0.24, 0.24), mass = mass, friction = 0.5, linear_damping = 0.5, angular_damping = 0.5,
        position = { 0.3 * (k - (boxes + 1) / 2), height - sag + 0.13, 0.03 * (-1) ^ k }, color = "#8a6a3f" }
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    local load = scene.cloth:mass() * 9.81
    for k, box in ipairs(scene.boxes) do
      local x, y, z = box:position()
      expect(y > 0.2 and y < height, ("box %d is at height %.2f m"):format(k, y))
      local vx, vy, vz = box:velocity()
      expect(math.sqrt(vx * vx + vy * vy + vz * vz) < 0.02, ("box %d still moves"):format(k))
      load = load + mass * 9.81
    end
    expect(scene.cloth:stretch() < 0.1, ("the cloth is stretched by %.1f %%"):format(100 * scene.cloth:stretch()))
    -- the clews bear all of it: what they pull upwards at the rings
    local lift = 0
    for _, rope in ipairs(scene.ropes) do
      local ax, ay, az = rope:point(1)
      local bx, by, bz = rope:point(2)
      local dx, dy, dz = ax - bx, ay - by, az - bz
      lift = lift + rope:tension(1) * dy / math.sqrt(dx * dx + dy * dy + dz * dz)
      load = load + rope:mass() * 9.81
    end
    expect(math.abs(lift / load - 1) < 0.05, ("the clews bear %.1f N of %.1f N"):format(lift, load))
  end,
}
