-- Rain on a pond with crates: the pond rises by what has rained, and the crates go on floating as deep as Archimedes says.
local feder = require "feder"
local fluid = require "feder.fluid"

local spacing = feder.param("spacing", 0.05, { min = 0.035, max = 0.06, help = "m" })
local rain = feder.param("rain", 60, { min = 0, max = 120, help = "mm that fall in all" })

local long, deep, level = 1.2, 0.8, 0.3      -- of the pond, and of its water, m
local size, high = 0.28, 0.2                 -- of the crates: flat ones float upright, whatever they weigh
local starts, lasts, rest = 0.75, 2.5, 2     -- before, of and after the rain, s
local densities = { 300, 500, 700 }          -- kg/m3
local base, clouds = long * deep, 8

-- Does a crate lie on the water there?
local function covered(crates, x, z)
  for _, crate in ipairs(crates) do
    local u, _, w = crate:position()
    if (x - u) ^ 2 + (z - w) ^ 2 < (0.75 * size) ^ 2 then return true end
  end
  return false
end

return feder.scene {
  title = "Rain on a pond",
  seconds = starts + lasts + rest,
  picture = 2.6,
  camera = { target = { long / 2, 0.35, deep / 2 }, distance = 2.9, yaw = feder.deg(22), pitch = feder.deg(20) },
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    fluid.tank(world, long, 0.6, deep, 0.1)
    scene.water = world:fluid { name = "water", spacing = spacing, viscosity = 0.001 }
    scene.filled = scene.water:fill { box = { { 0, 0, 0 }, { long, level, deep } } }
    scene.drops = math.floor(rain / 1000 * long * deep / spacing ^ 3)
    scene.crates = {}
    -- wet wood: the film of water in a gap to the wall, finer than particles, would carry a crate that lies against it
    for k, density in ipairs(densities) do
      scene.crates[k] = world:body { name = "crate" .. k, shape = feder.box(size, high, size), density = density, friction = 0.05, color = "wood",
        position = { (k - 0.5) * long / 3, level + 0.02, deep * (k == 2 and 0.6 or 0.4) } }
    end
    scene.clouds = {}
    for k = 1, clouds do
      local limit = scene.drops * k // clouds - scene.drops * (k - 1) // clouds
      if limit > 0 then
        scene.clouds[#scene.clouds + 1] = scene.water:emitter { name = "cloud" .. k, radius = 0, speed = 3,
          position = { 0, 1.5, 0 }, direction = { 0, -1, 0 }, rate = limit / lasts, limit = limit }:stop()
      end
    end
    world:after(starts, function()
      for _, cloud in ipairs(scene.clouds) do cloud:start() end
    end)
    scene.level, scene.bottom, scene.load, scene.samples = 0, { 0, 0, 0 }, { 0, 0, 0 }, 0
    world:on("warning", function(e) scene.said = e.message end)
  end,

  update = function(world, scene)
    -- each drop falls somewhere else
    for _, cloud in ipairs(scene.clouds) do
      cloud:aim(long * (0.05 + 0.9 * math.random()), 1.5, deep * (0.05 + 0.9 * math.random()), 0, -1, 0)
    end
    if world:time() < starts + lasts + 1 then return end
    -- means of the last second: of the surface, the crates' undersides, and the water that lies on them
    local p, sum, n = scene.water:positions(), 0, 0
    for i = 1, 9 do
      for j = 1, 3 do
        local x, z = long * (i - 0.5) / 9, deep * (j - 0.5) / 3
        local y = not covered(scene.crates, x, z) and scene.water:height_at(x, z)
        if y then sum, n = sum + y, n + 1 end
      end
    end
    scene.level, scene.samples = scene.level + sum / n, scene.samples + 1
    for k, crate in ipairs(scene.crates) do
      local _, y = crate:position()
      scene.bottom[k] = scene.bottom[k] + y - high / 2
      for i = 1, #p, 3 do
        local u, v, w = crate:local_point(p[i], p[i + 1], p[i + 2])
        if v > high / 2 and math.max(math.abs(u), math.abs(w)) < size / 2 then scene.load[k] = scene.load[k] + 1 end
      end
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(not scene.said, scene.said)
    expect(scene.water:count() == scene.filled + scene.drops, "drops are missing")
    -- the pond holds the water, and what the crates displace
    local volume = (scene.filled + scene.drops) * spacing ^ 3
    for _, density in ipairs(densities) do volume = volume + density / 1000 * size ^ 2 * high end
    local surface = scene.level / scene.samples
    expect.error(math.abs(surface - volume / base), "<", 0.15 * spacing, "height of the pond, m")
    for k, density in ipairs(densities) do
      local draught = volume / base - scene.bottom[k] / scene.samples
      local load = scene.load[k] / scene.samples * spacing ^ 3  -- m^3
      local wanted = density / 1000 * high + load / size ^ 2
      expect.error(math.abs(draught - wanted), "<", 0.35 * spacing, ("draught of crate %d, m"):format(k))
    end
  end,
}
