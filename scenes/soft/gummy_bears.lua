-- scenes/soft/gummy_bears.lua: gummy bears fall into a cup. Their shape is a union of balls and capsules, filled with
-- tetrahedra.
local feder = require "feder"

local bears = feder.param("bears", 5, { min = 1, max = 20 })
local young = feder.param("young", 3e4, { min = 5e3, max = 1e6, help = "Pa" })

-- a bear of 10 cm
local function bear()
  local parts = {
    { shape = feder.capsule(0.022, 0.06), position = { 0, 0, 0 } },
    { shape = feder.sphere(0.02), position = { 0, 0.042, 0 } },
    { shape = feder.sphere(0.009), position = { 0.014, 0.06, 0 } },
    { shape = feder.sphere(0.009), position = { -0.014, 0.06, 0 } },
  }
  for _, side in ipairs { 1, -1 } do
    parts[#parts + 1] = { shape = feder.capsule(0.01, 0.036), position = { side * 0.02, 0.012, 0.012 },
                          rotation = { axis = { 1, 0, 0 }, angle = feder.deg(70) } }
    parts[#parts + 1] = { shape = feder.capsule(0.011, 0.04), position = { side * 0.014, -0.028, 0.014 },
                          rotation = { axis = { 1, 0, 0 }, angle = feder.deg(70) } }
  end
  return feder.compound(parts)
end

return feder.scene {
  title = "Gummy bears",
  seconds = 6,

  build = function(world, scene)
    world:body { type = "static", shape = feder.plane() }
    local walls, height, radius = 12, 0.16, 0.1
    for i = 1, walls do  -- the cup
      local a = 2 * math.pi * i / walls
      world:body {
        name = "cup" .. i, type = "static", shape = feder.box(0.01, height, 2 * (radius + 0.005) * math.tan(math.pi / walls)),
        position = { radius * math.cos(a), height / 2, -radius * math.sin(a) }, rotation = { axis = { 0, 1, 0 }, angle = a },
        transparency = 0.7,
      }
    end
    local colors = { "#c1121f", "#f4a300", "#3a9d23", "#f2d13a", "#e8e4d8" }
    scene.bears = {}
    for i = 1, bears do
      scene.bears[i] = world:soft {
        name = "bear" .. i, shape = bear(), resolution = 9, young = young, poisson = 0.4, density = 1300, friction = 0.4,
        position = { 0.035 * math.cos(2.4 * i), 0.08 + 0.11 * i, 0.035 * math.sin(2.4 * i) },
        rotation = { axis = { math.sin(i), math.cos(2 * i), math.sin(3 * i) }, angle = 2 * i },
        color = colors[(i - 1) % #colors + 1],
      }
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    for i, one in ipairs(scene.bears) do
      expect(one:inverted() == 0, "bear " .. i .. " has tetrahedra inside out")
      expect(math.abs(one:volume() / one:rest_volume() - 1) < 0.05, "bear " .. i .. " has lost its volume")
      local x, y, z = one:point(1)
      expect(y > -0.001, "bear " .. i .. " is below the table")
      expect(x * x + z * z < 0.11 ^ 2, "bear " .. i .. " is not in the cup")
    end
  end,
}
