-- A glass is filled from a bottle: what was in the bottle is in the glass then, as high as its volume says, and nothing
-- goes through glass. With more than it holds the glass runs over.
local feder = require "feder"

local spacing = feder.param("spacing", 0.008, { min = 0.005, max = 0.008, help = "m" })
local share = feder.param("share", 0.8, { min = 0.3, max = 1.2, help = "water in the bottle, of what the glass holds" })
local seconds = feder.param("seconds", 3, { min = 2, max = 8, help = "that it takes to pour, s" })

local wall, sides = 0.008, 12              -- m
local wide, high = 0.05, 0.12              -- inner radius and height of the glass, m
local body, neck = 0.048, 0.02             -- inner radii of the bottle,
local shoulder, throat, mouth = 0.14, 0.2, 0.23  -- and where its shoulder begins, its neck, and where it ends, m
local lip, clear = -0.042, 0.01            -- where the mouth is, beside the axis of the glass and above its rim, m
local level, last = feder.deg(75), feder.deg(128)  -- turned quickly so far, then slowly
local start, rest = 0.9, 1                 -- when it begins to pour, and after it has poured, s

local polygon = sides / 2 * math.sin(2 * math.pi / sides)  -- area of the polygon of the radius 1

-- The wall of a vessel from one height and inner radius to the next, one convex piece for each side.
local function ring(parts, r1, y1, r2, y2)
  for k = 1, sides do
    local points = {}
    for _, turn in ipairs { 2 * math.pi * k / sides, 2 * math.pi * (k + 1) / sides } do
      for _, p in ipairs { { r1, y1 }, { r1 + wall, y1 }, { r2, y2 }, { r2 + wall, y2 } } do
        points[#points + 1] = { p[1] * math.cos(turn), p[2], p[1] * math.sin(turn) }
      end
    end
    parts[#parts + 1] = { shape = feder.hull(points) }
  end
end

local function vessel(profile)
  local parts = { { shape = feder.cylinder(profile[1][1] + wall, wall), position = { 0, -wall / 2, 0 } } }
  for k = 2, #profile do ring(parts, profile[k - 1][1], profile[k - 1][2], profile[k][1], profile[k][2]) end
  return feder.compound(parts)
end

local function smooth(s)
  s = math.min(1, math.max(0, s))
  return s * s * (3 - 2 * s)
end

-- Pose of the bottle: the middle of its floor, and its angle about z. It sinks as it is tipped, so that its lowest corner
-- stays above the glass.
local function tipped(t)
  local quick, slow = smooth(t / start), smooth((t - start) / seconds)
  local angle = -level * quick - (last - level) * slow
  local c, n = math.cos(angle), math.sin(angle)
  local x, y = neck + wall, mouth
  local lowest = -n * (body - neck) + c * (mouth + wall)
  return lip - (c * x - n * y), high + clear + math.max(0, lowest) - (n * x + c * y), angle
end

-- How far a particle in the bottle is from its mouth along the axis, or nil outside.
local function below_mouth(x, y, z)
  local narrowing = math.min(1, math.max(0, (y - shoulder) / (throat - shoulder)))
  local r = body + (neck - body) * narrowing
  if x * x + z * z < r * r and y > 0 and y < mouth then return mouth - y end
end

local function below_rim(x, y, z)
  if x * x + z * z < wide * wide and y > 0 and y < high then return high - y end
end

return feder.scene {
  title = "Glass and bottle",
  seconds = start + seconds + rest,
  picture = 3,
  camera = { target = { -0.04, 0.13, 0 }, distance = 0.6, yaw = feder.deg(15), pitch = feder.deg(35) },
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { name = "table", type = "static", shape = feder.plane(0, 1, 0, -wall), color = "wood" }
    scene.glass = world:body { name = "glass", type = "static", shape = vessel { { wide, 0 }, { wide, high } }, color = "#b9d3d8" }
    local x, y = tipped(0)
    scene.bottle = world:body { name = "bottle", type = "kinematic", position = { x, y, 0 }, color = "#3f7a4d",
      shape = vessel { { body, 0 }, { body, shoulder }, { neck, throat }, { neck, mouth } } }
    scene.water = world:fluid { name = "water", spacing = spacing, viscosity = 0.001 }
    local depth = share * high * wide ^ 2 / body ^ 2
    scene.count = scene.water:fill { shape = feder.cylinder(body * 0.97, depth), position = { x, y + depth / 2, 0 } }
    scene.deep, scene.leaked = {}, 0
    world:on("warning", function(e) scene.said = e.message end)
  end,

  update = function(world, scene)
    local x, y, angle = tipped(world:time() + world:dt())
    scene.bottle:move_to(x, y, 0, 0, 0, math.sin(angle / 2), math.cos(angle / 2))
    -- who was well inside in the step before, and is in neither now, has gone through glass
    local p = scene.water:positions()
    scene.poured, scene.left = 0, 0
    for i = 1, #p, 3 do
      local in_glass = below_rim(p[i], p[i + 1], p[i + 2])
      local in_bottle = below_mouth(scene.bottle:local_point(p[i], p[i + 1], p[i + 2]))
      if in_glass then scene.poured = scene.poured + 1 elseif in_bottle then scene.left = scene.left + 1 end
      if scene.deep[i] and not in_glass and not in_bottle then scene.leaked = scene.leaked + 1 end
      scene.deep[i] = math.max(in_glass or 0, in_bottle or 0) > 0.025
    end
    feder.plot("share in the glass", scene.poured / scene.count)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(not scene.said, scene.said)
    expect(scene.water:count() == scene.count, "particles are missing")
    expect(scene.leaked == 0, ("%d particles went through glass"):format(scene.leaked))
    expect.error(scene.left / scene.count, "<", 0.01, "share that is left in the bottle")
    -- all that was in the bottle, or as much as the glass holds, in volume and in height
    local base = polygon * wide ^ 2
    local volume = math.min(scene.count * spacing ^ 3, base * high)
    expect.error(math.abs(scene.poured * spacing ^ 3 / volume - 1), "<", 0.02, "volume in the glass")
    local sum = 0
    for k = -2, 2 do sum = sum + (scene.water:height_at(0, k * wide / 3) or 0) end
    expect.error(math.abs(sum / 5 - volume / base), "<", 0.7 * spacing, "height of the water in the glass, m")
  end,
}
