-- Blocks of rising friction on a slope: those with mu >= tan(angle) stay, the others slide by g (sin - mu cos).
local feder = require "feder"

local angle = feder.param("angle", 30, { min = 5, max = 60, help = "degrees" })

return feder.scene {
  title = "Incline",
  seconds = 2,
  picture = 1,
  camera = { yaw = feder.deg(6), pitch = feder.deg(20) },
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  -- feder study: largest error of the way a block slid, in metres
  study = {
    axes = { dt = { 1 / 30, 1 / 60, 1 / 120, 1 / 240 }, angle = { 20, 30 } },
    reference = function(world, scene)
      local a, t, ways = feder.deg(angle), world:time(), {}
      for i, block in ipairs(scene.blocks) do
        ways[i] = math.max(0, 9.81 * (math.sin(a) - block.mu * math.cos(a))) * t * t / 2
      end
      return ways
    end,
    error = function(world, scene, ways)
      local a, worst = feder.deg(angle), 0
      for i, block in ipairs(scene.blocks) do
        local x, y = block.body:position()
        worst = math.max(worst, math.abs(x * math.cos(a) - y * math.sin(a) - ways[i]))
      end
      return worst
    end,
  },

  build = function(world, scene)
    local a = feder.deg(angle)
    local c, s = math.cos(a), math.sin(a)
    -- the slope falls towards +x
    world:body { type = "static", shape = feder.plane(s, c, 0, 0), friction = 1 }
    scene.blocks = {}
    for i = 0, 8 do
      local mu = 0.1 * i
      -- a pair's friction is the geometric mean: mu^2 against the plane's 1
      scene.blocks[#scene.blocks + 1] = {
        mu = mu,
        body = world:body {
          name = "block" .. i, shape = feder.box(1, 0.5, 1), density = 200, friction = mu * mu,
          position = { 0.25 * s, 0.25 * c, 2 * i },
          rotation = { axis = { 0, 0, 1 }, angle = -a },
        },
      }
    end
  end,

  check = function(world, scene, expect)
    local a, g, t = feder.deg(angle), 9.81, world:time()
    for _, block in ipairs(scene.blocks) do
      local x, y = block.body:position()
      local along = x * math.cos(a) - y * math.sin(a)
      local vx, vy = block.body:velocity()
      local speed = vx * math.cos(a) - vy * math.sin(a)
      local acceleration = g * (math.sin(a) - block.mu * math.cos(a))
      if math.tan(a) < block.mu * 0.98 then
        expect(math.abs(along) < 0.002, ("mu %.1f should hold, slid %.4f m"):format(block.mu, along))
      elseif math.tan(a) > block.mu * 1.02 then
        expect(math.abs(speed - acceleration * t) < 0.02 * acceleration * t + 0.02,
          ("mu %.1f: speed %.4f, expected %.4f"):format(block.mu, speed, acceleration * t))
      end
    end
  end,
}
