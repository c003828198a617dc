-- scenes/soft/torn_loaf.lua: a loaf with a waist is pulled apart by its ends. Its dough first flows, so that it stays
-- longer than it was, and tears where the stress exceeds what it bears.
local feder = require "feder"

local strength = feder.param("strength", 5e3, { min = 3e3, max = 7e3, help = "stress that tears the dough, Pa" })
local yield = feder.param("yield", 0.06, { min = 0.02, max = 0.2, help = "strain beyond which it flows" })
local speed = feder.param("speed", 0.15, { min = 0.08, max = 0.3, help = "that each end is pulled with, m/s" })

local long, ends, waist = 0.5, 0.1, 0.065  -- length, radii of its ends and between them, m
local pull = 1.6  -- s

-- A plait: a ball at each end, thinner between them. Along x.
local function shape()
  return feder.sdf { spacing = 0.01, size = { long + 0.1, 2.4 * ends, 2.4 * ends }, fn = function(x, y, z)
    local function ball(at) return math.sqrt((x - at) ^ 2 + y * y + z * z) - ends end
    local reach = long / 2 - ends
    local off = math.max(math.abs(x) - reach, 0)
    local rod = math.sqrt(off * off + y * y + z * z) - waist
    return math.min(ball(-reach), ball(reach), rod)
  end }
end

return feder.scene {
  title = "Torn loaf",
  seconds = 5,
  picture = 1.2,
  camera = { target = { 0, 0.3, 0 }, distance = 1.5, pitch = feder.deg(15), yaw = feder.deg(20) },

  build = function(world, scene)
    world:body { name = "table", type = "static", shape = feder.plane(), friction = 0.6, color = "#b08968" }
    local loaf = world:soft {
      name = "loaf", shape = shape(), resolution = 14, density = 350, young = 4e4,
      poisson = 0.3, damping = 0.01, friction = 0.6, plastic = { yield = yield, flow = 8 }, fracture_stress = strength,
      position = { 0, 0.3, 0 }, color = "#d9a066",
    }
    scene.loaf, scene.hands, scene.torn = loaf, {}, 0
    for side = -1, 1, 2 do  -- two hands hold the ends
      local hand = world:body { name = side < 0 and "left hand" or "right hand", type = "kinematic",
        shape = feder.box(0.02, 0.05, 0.05), position = { side * (long / 2 + 0.03), 0.3, 0 }, mask = 0,
        color = "#7f5539" }
      for i = 1, loaf:count() do
        if side * loaf:point(i) > long / 2 - ends then loaf:attach(i, hand) end
      end
      hand:set_velocity(side * speed, 0, 0)
      scene.hands[#scene.hands + 1] = hand
    end
    world:on("fracture", function() scene.torn = scene.torn + 1 end)
    world:after(pull, function()
      for _, hand in ipairs(scene.hands) do hand:set_velocity(0, 0, 0) end
    end)
  end,

  check = function(world, scene, expect)
    local loaf = scene.loaf
    expect(world:is_finite())
    expect(scene.torn > 0, "nothing tore")
    expect(loaf:parts() >= 2, "it is in " .. loaf:parts() .. " piece")
    expect(loaf:inverted() == 0, loaf:inverted() .. " tetrahedra are inside out")
    -- two halves hold nearly all of it, one at each hand
    local sizes = {}
    for i = 1, loaf:count() do sizes[loaf:part(i)] = (sizes[loaf:part(i)] or 0) + loaf:mass(i) end
    table.sort(sizes, function(a, b) return a > b end)
    expect(sizes[1] + sizes[2] > 0.85 * loaf:mass(), "two halves hold only " .. (sizes[1] + sizes[2]) / loaf:mass())
    expect(math.abs(loaf:volume() / loaf:rest_volume() - 1) < 0.02, "its volume changed")
  end,
}
