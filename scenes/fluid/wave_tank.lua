-- A wave tank: a paddle makes waves, which run as fast as w^2 = g k tanh(k h) says (Airy 1845), are as high as its stroke
-- says (Havelock 1929), and end on a beach.
local feder = require "feder"

local spacing = feder.param("spacing", 0.025, { min = 0.015, max = 0.03, help = "m" })
local period = feder.param("period", 1, { min = 0.9, max = 1.2, help = "of the paddle, s" })
local stroke = feder.param("stroke", 0.07, { min = 0.03, max = 0.09, help = "of the paddle, from end to end, m" })

local depth, flat, slope = 0.3, 3.6, 1 / 5  -- of the water, of the floor before the beach, m; of the beach
local wall, rim = 0.15, 0.5                 -- thickness of the paddle; its height, and that of the beach, m
local formed = 5 * period                   -- s, when the waves have passed all gauges

local w = 2 * math.pi / period
local gauges = {}
for i = 0, 12 do gauges[i + 1] = 0.8 + 0.2 * i end

local function tanh(x) return 1 - 2 / (math.exp(2 * x) + 1) end

-- k of waves of angular frequency w, by Newton's method.
local function wave_number()
  local k = w ^ 2 / 9.81
  for _ = 1, 20 do
    local t = tanh(k * depth)
    k = k - (9.81 * k * t - w ^ 2) / (9.81 * (t + k * depth * (1 - t * t)))
  end
  return k
end

-- Amplitude over that of a paddle that moves as a whole: 2 (cosh 2kh - 1) / (sinh 2kh + 2kh).
local function maker(k)
  local x = 2 * k * depth
  return 2 * ((math.exp(x) + math.exp(-x)) / 2 - 1) / ((math.exp(x) - math.exp(-x)) / 2 + x)
end

return feder.scene {
  title = "Wave tank",
  seconds = 9 * period,
  picture = 6.5,
  camera = { target = { 2.3, 0.3, 0 }, distance = 11.5 },
  world = { gravity = { 0, -9.81 }, dt = 1 / 60, substeps = 4, dimension = 2 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    local far = flat + rim / slope
    world:body { name = "beach", type = "static", color = "#d8c38a",
      shape = feder.polygon { { flat, 0 }, { far, 0 }, { far, rim } } }
    scene.paddle = world:body { name = "paddle", type = "kinematic", color = "#a8562a",
        shape = feder.box(wall, rim + 0.1, 0.2),
      position = { -wall / 2, rim / 2 - 0.05 } }
    scene.water = world:fluid { name = "water", spacing = spacing, viscosity = 0.001, color = "#3b7dbb" }
    scene.count = scene.water:fill { box = { { 0, 0 }, { flat, depth } } }
      + scene.water:fill { shape = feder.polygon { { flat, spacing / 2 }, { flat + depth / slope, depth }, { flat, depth } } }
    scene.real, scene.imaginary, scene.samples = {}, {}, 0
    for i = 1, #gauges do scene.real[i], scene.imaginary[i] = 0, 0 end
    world:on("warning", function(e) scene.said = e.message end)
  end,

  update = function(world, scene)
    local t = world:time() + world:dt()
    scene.paddle:move_to(-wall / 2 + stroke / 2 * math.sin(w * t) * math.min(1, t / period), rim / 2 - 0.05, 0)
    -- the part of the surface that swings with the paddle: its Fourier coefficient over whole periods
    if world:time() < formed or world:time() >= formed + 4 * period then return end
    for i, x in ipairs(gauges) do
      local y = scene.water:height_at(x, 0) or 0
      scene.real[i] = scene.real[i] + y * math.cos(w * world:time())
      scene.imaginary[i] = scene.imaginary[i] + y * math.sin(w * world:time())
    end
    scene.samples = scene.samples + 1
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(not scene.said, scene.said)
    expect(scene.water:count() == scene.count, "particles are missing")
    -- k is the slope of the line through the phases of all gauges
    local n, sx, sp, sxx, sxp, last = #gauges, 0, 0, 0, 0, nil
    for i, x in ipairs(gauges) do
      local phase = math.atan(scene.imaginary[i], scene.real[i])
      if last then phase = phase + 2 * math.pi * math.floor((last - phase) / (2 * math.pi) + 0.5) end
      last, sx, sp, sxx, sxp = phase, sx + x, sp + phase, sxx + x * x, sxp + x * phase
    end
    local measured, k = (n * sxp - sx * sp) / (n * sxx - sx * sx), wave_number()
    expect.error(math.abs(measured / k - 1), "<", 0.03, "wave number")
    -- waves lose height on their way: 8 % on each of theirs
    local near = 2 / scene.samples * math.sqrt(scene.real[1] ^ 2 + scene.imaginary[1] ^ 2)
    local wanted = stroke / 2 * maker(k)
    expect.error(math.abs(near / wanted - 1), "<", 0.2, "amplitude before the paddle")
  end,
}
