-- scenes/soft/tyre.lua: a soft tyre on a rigid rim stands on the floor, flattened by its load, is driven by a torque,
-- rolls without slipping, and is round again when a jack lifts it.
local feder = require "feder"

local young = feder.param("young", 2e5, { min = 1e5, max = 5e5, help = "of the tyre, Pa" })
local load = feder.param("load", 12, { min = 6, max = 20, help = "mass of the rim, kg" })
local torque = feder.param("torque", 3, { min = 1, max = 4, help = "N m" })

local inner, outer, width, poisson = 0.15, 0.25, 0.1, 0.4  -- m
local sectors, layers, slices = 48, 3, 2

-- A ring about z: points by sector, layer from the rim outwards, slice; five tetrahedra a cell, mirrored from cell to
-- cell so that their diagonals meet.
local function ring()
  local points, cells = {}, {}
  local function at(s, l, k) return ((s % sectors) * (layers + 1) + l) * (slices + 1) + k + 1 end
  for s = 0, sectors - 1 do
    for l = 0, layers do
      for k = 0, slices do
        local a, r = 2 * math.pi * s / sectors, inner + (outer - inner) * l / layers
        points[at(s, l, k)] = { r * math.cos(a), r * math.sin(a), width * (k / slices - 0.5) }
      end
    end
  end
  local even = { { 1, 2, 3, 5 }, { 4, 2, 3, 8 }, { 6, 2, 5, 8 }, { 7, 3, 5, 8 }, { 2, 3, 5, 8 } }
  local odd = { { 2, 1, 4, 6 }, { 3, 1, 4, 7 }, { 5, 1, 6, 7 }, { 8, 4, 6, 7 }, { 1, 4, 6, 7 } }
  for s = 0, sectors - 1 do
    for l = 0, layers - 1 do
      for k = 0, slices - 1 do
        local corner = {}
        for c = 0, 7 do corner[c + 1] = at(s + c % 2, l + c // 2 % 2, k + c // 4) end
        for _, t in ipairs((s + l + k) % 2 == 0 and even or odd) do
          cells[#cells + 1] = { corner[t[1]], corner[t[2]], corner[t[3]], corner[t[4]] }
        end
      end
    end
  end
  return points, cells
end

-- The angle from one direction in the plane to another.
local function angle(ax, ay, bx, by) return math.atan(ax * by - ay * bx, ax * bx + ay * by) end

return feder.scene {
  title = "Tyre",
  seconds = 5,
  picture = 3,
  camera = { target = { 0.3, 0.2, 0 }, distance = 1.4, yaw = feder.deg(20), pitch = feder.deg(10) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), friction = 1 }
    scene.rim = world:body { name = "rim", shape = feder.cylinder(inner - 0.005, width), mass = load, color = "#adb5bd",
      position = { 0, outer + 0.02, 0 }, rotation = { axis = { 1, 0, 0 }, angle = feder.deg(90) }, group = 2, mask = 1,
      lock = { "z", "rx", "ry" } }
    local points, cells = ring()
    scene.tyre = world:soft { name = "tyre", points = points, tetrahedra = cells, position = { 0, outer + 0.02, 0 },
      density = 1100, young = young, poisson = poisson, damping = 0.01, friction = 1, color = "#495057" }
    for i, p in ipairs(points) do
      if math.sqrt(p[1] ^ 2 + p[2] ^ 2) < inner + 1e-6 then scene.tyre:attach(i, scene.rim) end
    end
    scene.height, scene.turned, scene.samples, scene.fastest = 0, 0, 0, 0
  end,

  -- it comes to rest, is driven for two seconds, and lifted by a jack
  update = function(world, scene)
    local t, rim = world:time(), scene.rim
    local x, y = rim:position()
    local sx, sy = rim:world_point(1, 0, 0)  -- a spoke
    sx, sy = sx - x, sy - y
    if scene.spoke then scene.turned = scene.turned - angle(scene.spoke[1], scene.spoke[2], sx, sy) end
    scene.spoke = { sx, sy }
    if t > 1 and t < 1.5 then
      scene.samples = scene.samples + 1
      scene.height = scene.height + (y - scene.height) / scene.samples  -- the mean
      scene.low = math.huge
      for k = 1, scene.tyre:count() do
        local _, low = scene.tyre:point(k)
        scene.low = math.min(scene.low, low)
      end
    elseif t > 1.5 and t < 3.5 then
      rim:apply_torque(0, 0, -torque)
      scene.fastest = math.max(scene.fastest, (rim:velocity()))
    elseif t > 3.75 then
      if not scene.jack then
        scene.rolled, scene.radius = x, x / scene.turned
        scene.jack = { x, y, rim:rotation() }
        rim:set_type("kinematic")
      end
      local ax, ay, qx, qy, qz, qw = table.unpack(scene.jack)
      rim:move_to(ax, ay + 0.2 * math.min(t - 3.75, 0.5), 0, qx, qy, qz, qw)
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect.no_warnings()
    local tyre = scene.tyre
    -- At rest it is flattened as a layer of springs on a rigid rim would be: with a stiffness K per area and thickness,
    -- the weight is width K/(outer - inner) 4/3 sqrt(2 outer) depth^1.5. K is Young's modulus where rubber may bulge
    -- to the sides, (1 - nu)/((1 + nu)(1 - 2 nu)) times that where it may not: the truth lies between.
    local mass = tyre:mass() + load
    local function flattened(stiffness)
      return (9.81 * mass * (outer - inner) / (width * stiffness * 4 / 3 * math.sqrt(2 * outer))) ^ (2 / 3)
    end
    local depth = outer + scene.low - scene.height
    expect.error(depth, "<", flattened(young), "how far it is flattened")
    local confined = young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))
    expect.error(depth, ">", flattened(confined), "how far it is flattened")
    -- it rolls without slipping, at a radius between that of its axle's height and its own
    expect.error(scene.rolled, ">", 0.2, "how far it rolled")
    expect.error(scene.radius, ">", scene.height, "rolling radius")
    expect.error(scene.radius, "<", outer + scene.low, "rolling radius")
    -- and somewhat slower than a rigid wheel, as rubber loses energy where it is squeezed
    local inertia = 0.5 * load * (inner - 0.005) ^ 2 + 0.5 * tyre:mass() * (outer ^ 2 + inner ^ 2)
    local rigid = 2 * torque / outer / (mass + inertia / outer ^ 2)
    expect.error(scene.fastest, "<", rigid, "speed")
    expect.error(scene.fastest, ">", 0.75 * rigid, "speed")
    -- lifted it is round again
    local x, y = scene.rim:position()
    local off, low = 0, 9
    for k = 1, tyre:count() do
      local a, b = tyre:point(k)
      local p, q = tyre:rest_point(k)
      low = math.min(low, b)
      off = math.max(off, math.abs(math.sqrt((a - x) ^ 2 + (b - y) ^ 2) - math.sqrt(p * p + q * q)))
    end
    expect.error(low, ">", 0.05, "height that it is lifted to")
    expect.error(off, "<", 0.01 * outer, "what it is out of round")
    expect(tyre:inverted() == 0, "the tyre has tetrahedra inside out")
    expect.error(math.abs(tyre:volume() / tyre:rest_volume() - 1), "<", 0.002, "change of volume")
  end,
}
