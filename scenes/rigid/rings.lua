-- Bodies that are not convex: a chain of rings that hangs from a wall, a ring on a peg that swings as a pendulum does,
-- and mugs that fall in a heap. Each is a signed distance field (feder.sdf) of a function.
local feder = require "feder"

local links = feder.param("links", 12, { min = 2, max = 20, step = 1, help = "rings in the chain" })
local mugs = feder.param("mugs", 8, { min = 0, max = 40, step = 1, help = "mugs in the heap" })

local R, r = 0.5, 0.1  -- of a ring
local function torus(x, y, z)
  local q = math.sqrt(x * x + y * y) - R
  return math.sqrt(q * q + z * z) - r
end

-- Distance from a cylinder along y, half as high as h, its middle at y0.
local function cylinder(x, y, z, radius, h, y0)
  local a, b = math.sqrt(x * x + z * z) - radius, math.abs(y - y0) - h
  return math.min(math.max(a, b), 0) + math.sqrt(math.max(a, 0) ^ 2 + math.max(b, 0) ^ 2)
end
local function mug(x, y, z)
  local hx = x - 0.225
  local handle = math.sqrt((math.sqrt(hx * hx + y * y) - 0.125) ^ 2 + z * z) - 0.04
  local cup = math.max(cylinder(x, y, z, 0.2, 0.25, 0), -cylinder(x, y, z, 0.15, 0.25, 0.05))
  return math.min(cup, math.max(handle, 0.15 - math.sqrt(x * x + z * z)))
end

return feder.scene {
  title = "Rings and mugs",
  seconds = 8,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    local ring = feder.sdf { fn = torus, size = { 1.4, 1.4, 0.4 }, spacing = 0.02 }

    -- neighbours stand across each other, so that each hangs in the one above
    local pitch, top = 2 * (R - r), 12
    scene.chain = {}
    for k = 1, links do
      scene.chain[k] = world:body {
        name = "link" .. k, type = k == 1 and "static" or "dynamic", shape = ring, density = 2000,
        position = { -3, top - pitch * (k - 1), 0 },
        rotation = { axis = { 0, 1, 0 }, angle = k % 2 == 0 and math.pi / 2 or 0 },
      }
    end

    -- a ring that hangs on a thin peg: for small angles a pendulum of length (R^2 + 3/4 r^2 + d^2)/d
    local d, angle, peg = R - r - 0.005, math.rad(5), 8
    world:body {
      name = "peg", type = "static", shape = feder.cylinder(0.005, 0.5), friction = 1,
      position = { 3, peg, 0 }, rotation = { axis = { 1, 0, 0 }, angle = math.pi / 2 },
    }
    scene.swing = world:body {
      name = "swing", shape = ring, friction = 1, density = 2000, sleeping = false,
      position = { 3 + d * math.sin(angle), peg - d * math.cos(angle), 0 },
      rotation = { axis = { 0, 0, 1 }, angle = angle },
    }

    local cup = feder.sdf { fn = mug, size = { 0.9, 0.7, 0.6 }, spacing = 0.02 }
    scene.mugs = {}
    for k = 1, mugs do
      scene.mugs[k] = world:body {
        name = "mug" .. k, shape = cup, density = 2000, position = { 0.1 * (k * 7 % 5), 0.3 + 0.8 * k, 0.1 * (k * 3 % 5) },
        rotation = { axis = { 1, k % 3, 0.5 }, angle = 0.7 * k },
      }
    end

    -- the swing passes its lowest place
    local last
    world:on("step", function()
      local x = scene.swing:position() - 3
      if last and last < 0 and x >= 0 then
        local time = world:time() - world:dt() * x / (x - last)
        scene.swings = (scene.swings or -1) + 1
        scene.first = scene.first or time
        scene.period = (time - scene.first) / scene.swings
      end
      last = x
    end)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(world:max_penetration() < 0.02 * r, "rings sink into each other by " .. world:max_penetration() .. " m")
    local _, y = scene.chain[links]:position()
    expect(math.abs(y - (12 - 2 * (R - r) * (links - 1))) < 0.05, "the chain has come apart")
    local law = 2 * math.pi * math.sqrt((R ^ 2 + 0.75 * r ^ 2 + (R - r) ^ 2) / (9.81 * (R - r)))
    expect(math.abs(scene.period / law - 1) < 0.02, ("the ring swings in %.3f s, not in %.3f"):format(scene.period, law))
    for _, m in ipairs(scene.mugs) do
      local _, height = m:position()
      expect(height > 0.1 and height < 4, m:name() .. " is at " .. height)
    end
  end,
}
