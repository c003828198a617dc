-- Ragdolls of ten parts fall on each other: balls at neck, shoulders and hips, hinges with limits at elbows and knees.
-- Joints have no friction; damping stands for it, else heads and arms would swing for minutes. Limbs are soft: they
-- hardly roll.
local feder = require "feder"

local count = feder.param("count", 20, { min = 1, max = 200, step = 1 })
local seed = feder.param("seed", 0, { min = 0, max = 60, step = 1 })  -- another one turns the places by 0.1 rad
local highest = feder.param("highest", 36, { min = 2, max = 500 })

-- Name, shape, middle beside that of the hips, kg; in this order.
local limb = feder.capsule(0.05, 0.3)
local parts = {
  { "torso", feder.box(0.35, 0.6, 0.2), { 0, 0.3, 0 }, 30 },
  { "head", feder.sphere(0.11), { 0, 0.75, 0 }, 5 },
}
-- Kind, the two parts, place, limits.
local joints = { { "ball", "torso", "head", { 0, 0.62, 0 } } }
for side, s in pairs { left = -1, right = 1 } do
  parts[#parts + 1] = { side .. " upper arm", limb, { 0.24 * s, 0.4, 0 }, 2.5 }
  parts[#parts + 1] = { side .. " forearm", limb, { 0.24 * s, 0.08, 0 }, 1.5 }
  parts[#parts + 1] = { side .. " thigh", feder.capsule(0.07, 0.44), { 0.1 * s, -0.25, 0 }, 8 }
  parts[#parts + 1] = { side .. " shin", feder.capsule(0.055, 0.44), { 0.1 * s, -0.7, 0 }, 4 }
  joints[#joints + 1] = { "ball", "torso", side .. " upper arm", { 0.2 * s, 0.53, 0 } }
  joints[#joints + 1] = { "hinge", side .. " upper arm", side .. " forearm", { 0.24 * s, 0.24, 0 }, { -2.4, 0.1 } }
  joints[#joints + 1] = { "ball", "torso", side .. " thigh", { 0.1 * s, 0, 0 } }
  joints[#joints + 1] = { "hinge", side .. " thigh", side .. " shin", { 0.1 * s, -0.48, 0 }, { -0.1, 2.4 } }
end
table.sort(parts, function(a, b) return a[1] < b[1] end)
table.sort(joints, function(a, b) return a[2] .. a[3] < b[2] .. b[3] end)

return feder.scene {
  title = "Ragdolls",
  seconds = 20,
  picture = 6,
  camera = { target = { 0, 0.5, 0 }, distance = 6, pitch = feder.deg(25) },
  world = { dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), friction = 0.6 }
    scene.parts, scene.joints, scene.worst, scene.most = {}, {}, 0, 0
    for k = 1, count do
      local turn = 2.4 * k + 0.1 * seed
      local x, y, z = 0.5 * math.sin(turn), 2 + (highest - 2) * (k - 1) / math.max(count - 1, 1), 0.5 * math.cos(turn)
      local body = {}
      for _, part in ipairs(parts) do
        local at = part[3]
        body[part[1]] = world:body {
          name = part[1] .. k, shape = part[2], mass = part[4], friction = 0.6, angular_damping = 2, linear_damping = 0.2,
          rolling_friction = 0.02,
          position = { x + at[1], y + at[2], z + at[3] },
        }
        scene.parts[#scene.parts + 1] = body[part[1]]
      end
      for _, joint in ipairs(joints) do
        local at = joint[4]
        local a, b, ax, ay, az = body[joint[2]], body[joint[3]], x + at[1], y + at[2], z + at[3]
        world:joint {
          type = joint[1], a = a, b = b, anchor = { ax, ay, az },
          axis = joint[1] == "hinge" and { 1, 0, 0 } or nil, limits = joint[5],
        }
        scene.joints[#scene.joints + 1] = { a, b, { a:local_point(ax, ay, az) }, { b:local_point(ax, ay, az) } }
      end
    end
    local kinetic, potential = world:energy()
    scene.start = kinetic + potential
  end,

  update = function(world, scene)
    for _, joint in ipairs(scene.joints) do
      local ax, ay, az = joint[1]:world_point(table.unpack(joint[3]))
      local bx, by, bz = joint[2]:world_point(table.unpack(joint[4]))
      scene.worst = math.max(scene.worst, math.sqrt((bx - ax) ^ 2 + (by - ay) ^ 2 + (bz - az) ^ 2))
    end
    local kinetic, potential = world:energy()
    scene.most = math.max(scene.most, kinetic + potential - scene.start)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.worst < 0.1, ("joints open by %.3f m"):format(scene.worst))
    local open = world:residuals()["rigid.joint_error_m"]
    expect(open < 0.01, ("a joint is open or bent by %.3f m or rad at the end"):format(open))
    expect(scene.most < 1e-3 * math.abs(scene.start), ("energy grows by %.1f J"):format(scene.most))
    for _, part in ipairs(scene.parts) do
      expect(not part:awake(), part:name() .. " is awake")
    end
  end,
}
