-- scenes/soft/cloth_over_jelly.lua: a cloth falls over a block and two balls of jelly and drapes over them. The jelly
-- bears it, keeps its volume, and no vertex of the cloth ends within it.
local feder = require "feder"

local young = feder.param("young", 4e4, { min = 1e4, max = 2e5, help = "of the jelly, Pa" })
local weight = feder.param("weight", 0.3, { min = 0.1, max = 1, help = "of the cloth, kg/m2" })

local thickness = 0.008  -- of the cloth, m
local pieces = {
  { shape = feder.box(0.3, 0.2, 0.3), position = { -0.24, 0.1, 0 }, resolution = 3, height = 0.2, color = "#c8553d" },
  { shape = feder.sphere(0.13), position = { 0.2, 0.13, 0.16 }, resolution = 5, height = 0.26, color = "#6a994e" },
  { shape = feder.sphere(0.1), position = { 0.22, 0.1, -0.18 }, resolution = 5, height = 0.2, color = "#e9a23b" },
}

-- All points {x, y, z}, their middle, and the root mean square of their speeds.
local function state(one)
  local points, middle, sum = {}, { 0, 0, 0 }, 0
  local n = one:count()
  for k = 1, n do
    local p = { one:point(k) }
    local u, v, w = one:velocity(k)
    for a = 1, 3 do middle[a] = middle[a] + p[a] / n end
    sum = sum + (u * u + v * v + w * w) / n
    points[k] = p
  end
  return points, middle, math.sqrt(sum)
end

-- Six times the volume of the tetrahedron a, b, c, d, with a sign.
local function det(a, b, c, d)
  local ux, uy, uz = b[1] - a[1], b[2] - a[2], b[3] - a[3]
  local vx, vy, vz = c[1] - a[1], c[2] - a[2], c[3] - a[3]
  local wx, wy, wz = d[1] - a[1], d[2] - a[2], d[3] - a[3]
  return ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx)
end

-- How many of `others` lie within the tetrahedra of a soft body.
local function within(soft, points, others)
  local _, cells = soft:count()
  local found = 0
  for k = 1, cells do
    local i, j, l, m = soft:tetrahedron(k)
    local a, b, c, d = points[i], points[j], points[l], points[m]
    local low, high = {}, {}
    for x = 1, 3 do
      low[x] = math.min(a[x], b[x], c[x], d[x])
      high[x] = math.max(a[x], b[x], c[x], d[x])
    end
    for _, p in ipairs(others) do
      if p[1] > low[1] and p[1] < high[1] and p[2] > low[2] and p[2] < high[2] and p[3] > low[3] and p[3] < high[3]
        and det(p, b, c, d) > 0 and det(a, p, c, d) > 0 and det(a, b, p, d) > 0 and det(a, b, c, p) > 0 then
        found = found + 1
      end
    end
  end
  return found
end

return feder.scene {
  title = "Cloth over jelly",
  seconds = 5,
  picture = 5,
  camera = { target = { 0, 0.1, 0 }, distance = 1.4, yaw = feder.deg(30), pitch = feder.deg(28) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), friction = 0.7 }
    scene.jellies = {}
    for i, piece in ipairs(pieces) do
      scene.jellies[i] = world:soft { name = "jelly" .. i, shape = piece.shape, resolution = piece.resolution,
        position = piece.position, young = young, poisson = 0.4, damping = 0.01, friction = 0.7, color = piece.color }
    end
    scene.cloth = world:cloth { name = "cloth", size = { 1, 0.8 }, resolution = { 31, 25 }, position = { 0, 0.45, 0 },
      area_density = weight, stretch = 3000, bend = 2e-4, damping = 0.01, thickness = thickness, friction = 0.5,
      color = "#8ecae6" }
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect.no_warnings()
    local cloth, _, speed = state(scene.cloth)
    expect.error(speed, "<", 0.02, "speed of the cloth")
    expect.error(scene.cloth:stretch(), "<", 0.06, "stretch of the cloth")
    expect(scene.cloth:tangles() == 0, "the cloth passes through itself")
    for i, one in ipairs(scene.jellies) do
      local piece, name = pieces[i], "jelly " .. i
      local points, middle, moves = state(one)
      expect.error(moves, "<", 0.01, "speed of " .. name)
      expect.error(math.sqrt((middle[1] - piece.position[1]) ^ 2 + (middle[3] - piece.position[3]) ^ 2), "<", 0.08,
        "way that the cloth has pulled " .. name)
      expect(one:inverted() == 0, name .. " has tetrahedra inside out")
      -- its own weight squeezes it by rho g h (1 - 2 poisson)/(2 young) where its sides are free; the floor's friction
      -- and the cloth make it up to 1.8 times as much
      local squeeze = 1000 * 9.81 * piece.height * (1 - 2 * 0.4) / (2 * young)
      expect.error(math.abs(one:volume() / one:rest_volume() - 1), "<", 2.5 * squeeze, "change of volume of " .. name)
      expect(within(one, points, cloth) == 0, "vertices of the cloth are in " .. name)
      local lowest = math.huge  -- of the cloth above its middle
      for _, p in ipairs(cloth) do
        if (p[1] - middle[1]) ^ 2 + (p[3] - middle[3]) ^ 2 < 0.05 ^ 2 then lowest = math.min(lowest, p[2]) end
      end
      expect.error(lowest, ">", 0.75 * piece.height, "height of the cloth over " .. name)
    end
  end,
}
