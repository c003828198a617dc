-- Three balls of tetrahedra, soft to stiff, fall on the floor: they are squeezed, bounce, come to rest the flatter the
-- softer, and no tetrahedron is turned inside out.
local feder = require "feder"
local build = require "feder.build"

local layers = feder.param("layers", 3, { min = 2, max = 4, help = "of tetrahedra between middle and skin" })

local radius, mass, skin = 0.5, 6, 0.04
local STIFFNESS = { 300, 800, 2400 }

return feder.scene {
  title = "Balls of tetrahedra",
  seconds = 8,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 16 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), friction = 0.8 }
    scene.balls = {}
    for b, stiffness in ipairs(STIFFNESS) do
      local points, springs, faces, cells = build.ball {
        radius = radius, layers = layers, position = { 1.5 * (b - 2), 0.8, 0 }, stiffness = stiffness, damping = 1.4,
      }
      local net = world:net { name = "ball" .. b, points = points, springs = springs, faces = faces,
        masses = mass / #points, radius = skin, friction = 0.8, damping = 0.8 }
      scene.balls[b] = { net = net, points = points, cells = cells, lowest = math.huge, shortest = math.huge }
    end
  end,

  -- lowest and highest point, and the middle
  update = function(world, scene)
    for _, ball in ipairs(scene.balls) do
      local low, high = math.huge, -math.huge
      for i = 1, #ball.points do
        local _, y = ball.net:point(i)
        low, high = math.min(low, y), math.max(high, y)
      end
      ball.low, ball.height = low, high - low
      ball.lowest, ball.shortest = math.min(ball.lowest, low), math.min(ball.shortest, high - low)
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    for b, ball in ipairs(scene.balls) do
      expect(ball.lowest > 0, ("ball %d sank to %.4f m"):format(b, ball.lowest))
      expect(ball.low > 0.75 * skin, ("ball %d lies %.4f m deep"):format(b, ball.low))
      expect(ball.shortest < ball.height, ("ball %d was not squeezed"):format(b))

      -- the volumes of the tetrahedra: all of one sign, and in sum nearly what they were
      local now, before, volume, inverted = {}, 0, 0, 0
      for i = 1, #ball.points do now[i] = { ball.net:point(i) } end
      for _, cell in ipairs(ball.cells) do
        local v = build.volume(now, cell)
        volume, before = volume + v, before + build.volume(ball.points, cell)
        if v <= 0 then inverted = inverted + 1 end
      end
      expect(inverted == 0, ("ball %d: %d tetrahedra inside out"):format(b, inverted))
      expect(math.abs(volume / before - 1) < 0.25, ("ball %d kept %.3f of its volume"):format(b, volume / before))
      local sphere = 4 / 3 * math.pi * radius ^ 3
      expect(before > 0.8 * sphere and before < sphere, ("%.3f m3 of %.3f m3"):format(before, sphere))
      if b > 1 then
        expect(ball.height > scene.balls[b - 1].height, ("ball %d is flatter than the softer one"):format(b))
      end
    end
    local kinetic = world:energy()
    expect(kinetic < 0.05, ("still moving: %.3f J"):format(kinetic))
  end,
}
