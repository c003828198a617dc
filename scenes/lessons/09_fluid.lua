-- Lesson 9: fluid: a basin of water, in which cork and wood float and a stone sinks, and a hose that fills it further.
local feder = require "feder"
local fluid = require "feder.fluid"

local spacing = feder.param("spacing", 0.06, { min = 0.03, max = 0.08, help = "of the particles, m" })
local long, deep, level, size = 1.5, 0.6, 0.35, 0.24  -- of the basin, of the water, and of the things, m

-- density in kg/m3: water has 1000
local things = { { "cork", 240, "sand" }, { "wood", 650, "wood" }, { "stone", 2600, "stone" } }

return feder.scene {
  title = "9 Fluid",
  seconds = 5,
  picture = 3,
  camera = { target = { 0.75, 0.45, 0.3 }, distance = 3, yaw = feder.deg(20), pitch = feder.deg(18) },

  build = function(world, scene)
    fluid.tank(world, long, 0.8, deep, 0.08)
    -- a fluid is particles; spacing says how fine, and a half of it means eight times as many
    scene.water = world:fluid { name = "water", spacing = spacing }
    scene.filled = scene.water:fill { box = { { 0, 0, 0 }, { long, level, deep } } }
    scene.hose = scene.water:emitter { position = { 0.15, 0.9, deep / 2 }, direction = { 0, -1, 0 }, speed = 1,
      radius = 0.09, limit = scene.filled // 10 }

    scene.things = {}
    for i, thing in ipairs(things) do
      scene.things[i] = world:body { name = thing[1], density = thing[2], color = thing[3],
        shape = feder.box(size, size, size), position = { 0.2 + 0.4 * i, level + 0.3, deep / 2 } }
    end
  end,

  check = function(world, scene, expect)
    expect(scene.water:count() == scene.filled + scene.filled // 10, "water is missing")
    local surface = scene.water:height_at(0.9, 0.1) or 0
    for i, thing in ipairs(things) do
      -- Archimedes: as much of it is under water as its density has of the water's
      local _, y = scene.things[i]:position()
      local share = thing[2] / 1000
      if share < 1 then
        local under = surface - (y - size / 2)
        expect(math.abs(under - share * size) < 1.2 * spacing,
          ("%s is %.2f m under water, not %.2f"):format(thing[1], under, share * size))
      else
        expect(y < size, ("the %s is at %.2f m, not on the floor"):format(thing[1], y))
      end
    end
  end,
}
