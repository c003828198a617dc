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

-- Martin and Moyce's films (Phil. Trans. R. Soc. A 244, 1952) start later than an instant release would: their
-- diaphragm took time. What to add to T = t sqrt(g/a) of a run before comparing fronts; runtime/study/martin_moyce.h
-- says whence.
fluid.diaphragm_delay = 0.124

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
