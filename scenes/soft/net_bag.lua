-- scenes/soft/net_bag.lua: balls of foam are dropped into a bag of close-knit net, which hangs by its hoop from a hook.
-- The bag, which is a cloth, takes all of them, none slips through, and the cords bear the weight of everything.
local feder = require "feder"
local fabric = require "feder.cloth"

local count = feder.param("balls", 3, { min = 1, max = 5, step = 1 })
local young = feder.param("young", 4e4, { min = 2e4, max = 2e5, help = "of the balls, Pa" })

local radius = 0.07  -- of a ball, m
local hoop, depth, hook, height = 0.2, 0.42, 0.55, 1.1  -- of the bag; of the hook above it; of the hoop above the floor

-- The lower half of a ball drawn out to the depth of the bag: points, triangles, and the points at the hoop.
local function bag()
  local all, triangles = fabric.sphere(1, 3, 8)
  local points, number, faces, border = {}, {}, {}, {}
  for i, p in ipairs(all) do
    if p[2] < 1e-6 then
      points[#points + 1] = { hoop * p[1], height + depth * p[2], hoop * p[3] }
      number[i] = #points
      if p[2] > -1e-6 then border[#border + 1] = #points end
    end
  end
  for _, t in ipairs(triangles) do
    local i, j, k = number[t[1]], number[t[2]], number[t[3]]
    if i and j and k then faces[#faces + 1] = { i, j, k } end
  end
  return points, faces, border
end

-- Of a soft thing: its middle, lowest point, and root mean square of the speeds.
local function state(one)
  local n, x, y, z, low, sum = one:count(), 0, 0, 0, math.huge, 0
  for i = 1, n do
    local a, b, c = one:point(i)
    local u, v, w = one:velocity(i)
    x, y, z, low, sum = x + a / n, y + b / n, z + c / n, math.min(low, b), sum + (u * u + v * v + w * w) / n
  end
  return x, y, z, low, math.sqrt(sum)
end

return feder.scene {
  title = "Net bag",
  seconds = 5,
  picture = 5,
  camera = { target = { 0, 1.1, 0 }, distance = 1.5, yaw = feder.deg(30), pitch = feder.deg(52) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    local parts, sides = {}, 12
    for k = 1, sides do
      local a = 2 * math.pi * k / sides
      parts[k] = { shape = feder.capsule(0.008, 2 * hoop * math.tan(math.pi / sides) + 0.016),
        position = { hoop * math.cos(a), 0, hoop * math.sin(a) },
        rotation = { euler = { math.pi / 2, -a, 0 }, fixed = true } }
    end
    scene.hoop = world:body { name = "hoop", shape = feder.compound(parts), position = { 0, height, 0 }, mass = 0.4,
      linear_damping = 0.5, angular_damping = 0.5, color = "#6f5a3c", group = 2, mask = 1 }
    scene.cords = {}
    for k = 1, 3 do
      local a = 2 * math.pi * k / 3
      scene.cords[k] = world:rope { name = "cord" .. k, from = { 0, height + hook, 0 }, pins = { "first" },
        to = { hoop * math.cos(a), height, hoop * math.sin(a) }, segments = 8, radius = 0.004, stretch = 20000,
        self_collision = false, group = 2, mask = 1, color = "#6f5a3c" }
      scene.cords[k]:attach(9, scene.hoop)
    end
    local points, faces, border = bag()
    scene.bag = world:cloth { name = "bag", vertices = points, triangles = faces, area_density = 0.3, stretch = 20000,
      shear = 2000, damping = 0.01, thickness = 0.008, friction = 0.4, color = "#8d99ae" }
    for _, i in ipairs(border) do scene.bag:attach(i, scene.hoop) end
    scene.balls = {}
    local colors = { "#c8553d", "#e9a23b", "#6a994e", "#b56fae" }
    for k = 1, count do
      world:after(0.4 * (k - 1), function()
        scene.balls[k] = world:soft { name = "ball" .. k, shape = feder.sphere(radius), resolution = 4, young = young,
          position = { 0.03 * math.cos(2.4 * k), height + 0.12, 0.03 * math.sin(2.4 * k) }, poisson = 0.4, density = 300,
          damping = 0.005, friction = 0.4, color = colors[(k - 1) % #colors + 1] }
      end)
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect.no_warnings()
    -- the balls' weight stretches it by less than 1 %; what pairs of light vertices and heavy balls leave is up to 7 %
    expect.error(scene.bag:stretch(), "<", 0.12, "stretch of the bag")
    expect(#scene.balls == count, "not all balls were dropped")
    local _, _, _, bottom = state(scene.bag)
    local x0, y0, z0 = scene.hoop:position()
    local weight = 9.81 * (scene.hoop:mass() + scene.bag:mass())
    for k, one in ipairs(scene.balls) do
      local x, y, z, low, speed = state(one)
      local name = "ball " .. k
      local aside = math.sqrt((x - x0) ^ 2 + (z - z0) ^ 2)
      expect.error(aside, "<", hoop - radius / 2, "way from the bag's axis of " .. name)
      expect.error(y, "<", y0, "height of " .. name)
      expect.error(low, ">", bottom, "lowest point of " .. name)
      expect.error(speed, "<", 0.15, "speed of " .. name)
      expect(one:inverted() == 0, name .. " has tetrahedra inside out")
      expect.error(math.abs(one:volume() / one:rest_volume() - 1), "<", 0.02, "change of volume of " .. name)
      weight = weight + 9.81 * one:mass()
    end
    local lift = 0
    for _, cord in ipairs(scene.cords) do
      local ax, ay, az = cord:point(1)
      local bx, by, bz = cord:point(2)
      local dx, dy, dz = ax - bx, ay - by, az - bz
      lift = lift + cord:tension(1) * dy / math.sqrt(dx * dx + dy * dy + dz * dz)
      weight = weight + 9.81 * cord:mass()
    end
    expect.error(math.abs(lift / weight - 1), "<", 0.05, "share by which the cords miss the weight")
  end,
}
