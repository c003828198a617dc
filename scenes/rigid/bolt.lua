-- Bolts and nuts by nothing but contact: the thread is a signed distance field (feder.sdf) of a function. A nut that is
-- turned travels one pitch per turn; one on a bolt that is shaken at 2 g keeps its place, since friction exceeds the
-- tangent of the lead angle.
local feder = require "feder"

local turns = feder.param("turns", 10, { min = 1, max = 10, help = "turns of the nut that is driven" })
local friction = feder.param("friction", 0.2, { min = 0.15, max = 0.5, help = "of bolts and nuts; they lock above 0.052" })
local gap = feder.param("gap", 0.04, { min = 0.01, max = 0.07, help = "between the threads, in pitches" })

local R, lead = 0.1, math.rad(3)           -- of the thread where it is half as deep
local pitch = 2 * math.pi * R * math.tan(lead)
local half = 0.27 * pitch                  -- half the depth; flanks of 60 degrees between them
local thick, spacing = 3 * pitch, 0.0025   -- of a nut; of the fields

-- Distance from an endless thread along y.
local function thread(x, y, z)
  local rho = math.sqrt(x * x + z * z)
  local s = y / pitch - math.atan(z, x) / (2 * math.pi)
  local off = math.abs(s - math.floor(s + 0.5)) * pitch
  local flank = (rho - R - math.sqrt(3) * (pitch / 4 - off)) / 2
  return math.min(rho - (R - half), math.max(flank, rho - (R + half)))
end

local function bolt(length)
  local w = 2.4 * R
  return feder.sdf {
    fn = function(x, y, z) return math.max(thread(x, y, z), math.abs(y) - length / 2) end,
    size = { w, 1.05 * length, w }, spacing = spacing,
  }
end

local function nut()
  return feder.sdf {
    fn = function(x, y, z)
      local hexagon = -math.huge
      for k = 0, 2 do
        local a = k * math.pi / 3
        hexagon = math.max(hexagon, math.abs(x * math.cos(a) + z * math.sin(a)) - 1.7 * R)
      end
      return math.max(hexagon, math.abs(y) - thick / 2, gap * pitch - thread(x, y, z))
    end,
    size = { 4.2 * R, 1.1 * thick, 4.2 * R }, spacing = spacing,
  }
end

local way = turns * pitch
local shake = { hertz = 10, g = 2 }
shake.amplitude = shake.g * 9.81 / (2 * math.pi * shake.hertz) ^ 2

return feder.scene {
  title = "Bolts and nuts",
  seconds = 11,
  picture = 4,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60 },
  camera = { distance = 1.5 },

  build = function(world, scene)
    local shape = nut()
    local function pair(name, x, length, y)
      local screw = world:body { name = name .. " bolt", type = "kinematic", shape = bolt(length), friction = friction,
                                 position = { x, 0, 0 }, color = "#8090a0" }
      return screw, world:body {
        name = name .. " nut", shape = shape, density = 7800, friction = friction, position = { x, y, 0 },
        rotation = { axis = { 0, 1, 0 }, angle = -2 * math.pi * y / pitch }, color = "#d0a040",
      }
    end
    scene.still, scene.shaken = pair("shaken", -0.3, 0.2, 0)
    local _, driven = pair("driven", 0.3, 0.2 + way, way / 2)
    scene.driven, scene.turned = driven, 0

    world:on("step", function()
      local t, w = world:time(), 2 * math.pi * shake.hertz
      if t > 1 then scene.still:move_to({ -0.3, shake.amplitude * math.sin(w * (t + world:dt())), 0 }) end
      local _, spin = driven:angular_velocity()
      scene.turned = scene.turned + spin * world:dt() / (2 * math.pi)
      if not scene.from and t > 0.5 then
        local _, y = driven:position()
        scene.from, scene.turned = y, 0
      end
      if scene.from and scene.turned < turns then driven:apply_torque(0, 40 * (2 * math.pi - spin), 0) end
    end)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    local _, y = scene.driven:position()
    local pitches = (scene.from - y) / pitch
    expect(scene.turned > 0.9 * turns, ("the nut has made %.2f turns"):format(scene.turned))
    expect(math.abs(pitches / scene.turned - 1) < 0.02,
      ("%.2f turns moved the nut by %.2f pitches"):format(scene.turned, pitches))
    local _, at = scene.shaken:position()
    local _, of = scene.still:position()
    expect(math.abs(at - of) < 0.1 * pitch, ("the shaken nut is off by %.3f pitches"):format((at - of) / pitch))
    expect(world:max_penetration() < 0.1 * pitch)
  end,
}
