-- Balls of rising restitution dropped from 4 m: apex n is e^(2n) h.
local feder = require "feder"

local drop = feder.param("drop", 4, { min = 0.5, max = 40, help = "height of fall in m" })
local bounciness = { 0, 0.3, 0.5, 0.8, 0.95 }

return feder.scene {
  title = "Bounce",
  seconds = 4,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 120, substeps = 4 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    scene.balls = {}
    for i, e in ipairs(bounciness) do
      scene.balls[i] = {
        e = e, apex = {}, last = 0,
        body = world:body { name = "ball" .. i, shape = feder.sphere(0.25), restitution = e, position = { i, drop + 0.25, 0 } },
      }
    end
  end,

  update = function(world, scene)
    for _, ball in ipairs(scene.balls) do
      local _, y = ball.body:position()
      local _, vy = ball.body:velocity()
      if ball.last > 0 and vy <= 0 then ball.apex[#ball.apex + 1] = y - 0.25 end
      ball.last = vy
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    for _, ball in ipairs(scene.balls) do
      local want = ball.e * ball.e * drop
      if ball.e >= 0.3 then
        local got = ball.apex[1] or 0
        expect(math.abs(got - want) < 0.03 * drop, ("e %.2f: first apex %.4f, expected %.4f"):format(ball.e, got, want))
      end
      for n, y in ipairs(ball.apex) do
        expect(y <= ball.e ^ (2 * n) * drop + 0.03 * drop, ("e %.2f: apex %d gains energy: %.4f"):format(ball.e, n, y))
      end
    end
    local _, y = scene.balls[1].body:position()
    expect(math.abs(y - 0.25) < 0.005, "a ball without restitution rests at " .. y)
  end,
}
