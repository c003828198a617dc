-- Fluids for scenes: materials and a tank.
--   local fluid = require "feder.fluid"
--   local honey = world:fluid(fluid.of("honey", { spacing = 0.02 }))
-- density in kg/m^3, viscosity in Pa s, surface_tension in N/m, at room temperature.
local feder = require "feder"

local fluid = {}

fluid.materials = {
  water   = { density = 998, viscosity = 0.001, surface_tension = 0.0728 },
  oil     = { density = 915, viscosity = 0.07, surface_tension = 0.032 },
  honey   = { density = 1420, viscosity = 6, surface_tension = 0.05 },
  mercury = { density = 13534, viscosity = 0.00155, surface_tension = 0.485 },
  alcohol = { density = 789, viscosity = 0.0011, surface_tension = 0.0223 },
}

-- Front of a collapsing square column of width a by a, over T = t sqrt(g/a): Martin and Moyce, Phil. Trans. R. Soc. A 244
-- (1952). Their films start later than an instant release would, as their diaphragm took time: what to add to the T of a
-- run before comparing fronts is 0.1 to 0.2 by what is said of the experiment, 0.175 of t sqrt(2g/a) in comparisons of
-- other codes (Lethe's dam-break example), which is taken here, once for all solvers and resolutions.
fluid.martin_moyce = { { 0.62, 1.22 }, { 0.80, 1.44 }, { 1.02, 1.67 }, { 1.19, 1.89 }, { 1.34, 2.11 }, { 1.50, 2.33 },
  { 1.66, 2.56 }, { 1.81, 2.78 }, { 1.97, 3.00 } }
fluid.diaphragm_delay = 0.124

-- How far the front has come along x on a floor at y = 0.
function fluid.front(water)
  local x, spacing, far = water:positions(), water:spacing(), 0
  for i = 1, #x, 3 do
    if x[i + 1] < 2 * spacing then far = math.max(far, x[i] + spacing / 2) end
  end
  return far
end

-- A drop that is drawn out along x by a factor: places of its particles, evenly, but on no lattice, as rows of particles
-- are stiff: in the plane the spiral of sunflower seeds (Vogel 1979), in space the sequence of the root of g^4 = g + 1
-- (Roberts 2018).
function fluid.drop(radius, spacing, stretch, dimension)
  local points = {}
  if dimension == 3 then
    local count, g, k = math.floor(4 * math.pi / 3 * (radius / spacing) ^ 3 + 0.5), 1.22074408460575947536, 0
    local function at(step) return 2 * (k / step % 1) - 1 end
    while #points < count do
      k = k + 1
      local x, y, z = at(g), at(g * g), at(g * g * g)
      if x * x + y * y + z * z < 1 then
        points[#points + 1] = { stretch * radius * x, radius * y / math.sqrt(stretch), radius * z / math.sqrt(stretch) }
      end
    end
    return points
  end
  local count = math.floor(math.pi * radius ^ 2 / spacing ^ 2 + 0.5)
  for i = 1, count do
    local r, turn = radius * math.sqrt((i - 0.5) / count), i * math.pi * (3 - math.sqrt(5))
    points[i] = { stretch * r * math.cos(turn), r * math.sin(turn) / stretch, 0 }
  end
  return points
end

-- How long it is along x against how wide across, by the second moments: 0 when it is round.
function fluid.elongation(drop, dimension)
  local p, difference, sum, sides = drop:positions(), 0, 0, (dimension or 2) - 1
  for i = 1, #p, 3 do
    local length, width = p[i] ^ 2, (p[i + 1] ^ 2 + p[i + 2] ^ 2) / sides
    difference, sum = difference + length - width, sum + length + width
  end
  return difference / sum
end

-- Angular frequency of its swing: omega^2 = n (n^2 - 1) sigma / (rho R^3) with n = 2 in the plane (Rayleigh 1879), in
-- space l (l - 1) (l + 2) sigma / (rho R^3) with l = 2 (Lamb, Hydrodynamics, art. 275).
function fluid.swing(tension, density, radius, dimension)
  return math.sqrt((dimension == 3 and 8 or 6) * tension / (density * radius ^ 3))
end

local function names()
  local list = {}
  for name in pairs(fluid.materials) do list[#list + 1] = name end
  table.sort(list)
  return table.concat(list, ", ")
end

-- of(material, options): the options with the material's numbers where they name none.
function fluid.of(material, options)
  local m = fluid.materials[material]
  if not m then error(("fluid.of: unknown material '%s'; known: %s"):format(tostring(material), names()), 2) end
  local out = {}
  for k, v in pairs(m) do out[k] = v end
  for k, v in pairs(options or {}) do out[k] = v end
  return out
end

-- A tank without a lid: inside from 0 to length, height and depth along x, y and z. Floor and ends are boxes of
-- thickness `wall`; front and back are planes, through which one can look.
function fluid.tank(world, length, height, depth, wall)
  local function side(name, w, h, d, x, y)
    world:body { name = name, type = "static", shape = feder.box(w, h, d), position = { x, y, depth / 2 } }
  end
  side("floor", length + 2 * wall, wall, depth + 2 * wall, length / 2, -wall / 2)
  side("left", wall, height, depth, -wall / 2, height / 2)
  side("right", wall, height, depth, length + wall / 2, height / 2)
  world:body { name = "back", type = "static", shape = feder.plane(0, 0, 1, 0) }
  world:body { name = "front", type = "static", shape = feder.plane(0, 0, -1, -depth) }
end

return fluid
