-- Two cups that move to and fro together: one is tipped over the other, and what was in it is in the other then.
local feder = require "feder"

local spacing = feder.param("spacing", 0.03, { min = 0.02, max = 0.04, help = "m" })
local seconds = feder.param("seconds", 5, { min = 3, max = 6, help = "that it takes to tip the cup, s" })
local sway = feder.param("sway", 0.15, { min = 0, max = 0.2, help = "how far the cups move to either side, m" })

local high, wall, level = 0.3, 0.045, 0.21  -- of the cups, and of the water in the upper one, m
local narrow, wide = 0.3, 0.42              -- inside, of the upper and of the lower cup, m
local lip = -0.15                           -- where the upper one is tipped, m beside the middle of the lower one
local last = feder.deg(130)
local start, rest = 0.5, 2                  -- before and after it is tipped, s

local function cup(inside)
  local half, out = inside / 2, inside + 2 * wall
  return feder.compound {
    { shape = feder.box(out, wall, out), position = { 0, -wall / 2, 0 } },
    { shape = feder.box(wall, high, out), position = { -half - wall / 2, high / 2, 0 } },
    { shape = feder.box(wall, high, out), position = { half + wall / 2, high / 2, 0 } },
    { shape = feder.box(inside, high, wall), position = { 0, high / 2, -half - wall / 2 } },
    { shape = feder.box(inside, high, wall), position = { 0, high / 2, half + wall / 2 } },
  }
end

-- Pose of the upper cup: the middle of its floor, and its angle about z. It sinks as it is tipped, so that its lowest
-- corner stays above the lower cup.
local function tipped(t)
  local s = math.min(1, math.max(0, (t - start) / seconds))
  local angle = -last * s * s * (3 - 2 * s)
  local c, n = math.cos(angle), math.sin(angle)
  local x, y = narrow / 2 + wall, high  -- the lip, from the middle of its floor
  return lip - (c * x - n * y), high + 0.04 + math.max(0, c) * (high + wall) - (n * x + c * y), angle
end

-- How far both have moved aside.
local function aside(t)
  return sway * math.sin(2 * math.pi * math.max(0, t - start) / 2.5) * math.min(1, math.max(0, (t - start) / 1.5))
end

-- Where particle i is in a cup: its height above the floor of it, or nil.
local function height_in(body, inside, x, i)
  local u, v, w = body:local_point(x[i], x[i + 1], x[i + 2])
  if math.abs(u) < inside / 2 and math.abs(w) < inside / 2 and v > 0 and v < high then return v end
end

return feder.scene {
  title = "Pouring cups",
  seconds = start + seconds + rest,
  picture = start + 0.6 * seconds,
  camera = { target = { -0.1, 0.35, 0 }, distance = 2, yaw = feder.deg(35), pitch = feder.deg(35) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(0, 1, 0, -0.3) }
    scene.lower = world:body { name = "lower", type = "kinematic", shape = cup(wide), color = "#7d8a92" }
    local x, y = tipped(0)
    scene.upper = world:body { name = "upper", type = "kinematic", shape = cup(narrow), position = { x, y, 0 }, color = "#c9772b" }
    scene.water = world:fluid { name = "water", spacing = spacing, viscosity = 0.001 }
    scene.count = scene.water:fill { box = { { x - narrow / 2, y, -narrow / 2 }, { x + narrow / 2, y + level, narrow / 2 } } }
    scene.depth, scene.leaked = {}, 0
    world:on("warning", function(e) scene.said = e.message end)
  end,

  update = function(world, scene)
    local t = world:time() + world:dt()
    local x, y, angle = tipped(t)
    scene.upper:move_to(x, y, aside(t), 0, 0, math.sin(angle / 2), math.cos(angle / 2))
    scene.lower:move_to(0, 0, aside(t))
    -- who was well below the rim in the step before, and is in no cup now, has gone through a wall
    local x = scene.water:positions()
    scene.above, scene.below = 0, 0
    for i = 1, #x, 3 do
      local in_upper, in_lower = height_in(scene.upper, narrow, x, i), height_in(scene.lower, wide, x, i)
      if in_upper then scene.above = scene.above + 1 end
      if in_lower then scene.below = scene.below + 1 end
      local was = scene.depth[i]
      if was and not in_upper and not in_lower then scene.leaked = scene.leaked + 1 end
      scene.depth[i] = math.min(in_upper or high, in_lower or high) < high - 0.1
    end
    feder.plot("share that is in the lower cup", scene.below / scene.count)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(not scene.said, scene.said)
    expect(scene.water:count() == scene.count, "particles are missing")
    expect(scene.leaked == 0, ("%d particles went through walls"):format(scene.leaked))
    expect(scene.above == 0, ("%d particles are left in the upper cup"):format(scene.above))
    -- what splashes over the rim: 2 particles of 700
    expect.error(1 - scene.below / scene.count, "<", 0.02, "share of the water that is spilled")
    local _, y, z = scene.lower:position()
    local wanted, sum = scene.below * spacing ^ 3 / wide ^ 2, 0
    for k = -2, 2 do sum = sum + (scene.water:height_at(k * wide / 6, z) or 0) - y end
    expect.error(math.abs(sum / 5 - wanted), "<", 0.5 * spacing, "height of the water in the lower cup, by its volume, m")
  end,
}
