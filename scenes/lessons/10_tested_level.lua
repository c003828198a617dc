-- Lesson 10: a level of a game, and its test: push the ball over the ramp, collect coins in the air, land in the goal.
local feder = require "feder"

local push = feder.param("push", 9, { min = 1, max = 15, help = "speed of the ball, m/s" })

local deadline = 5  -- s
local coins = { { 2.2, 1.05 }, { 3, 0.95 }, { 3.7, 0.65 } }  -- x, y, m

return feder.scene {
  title = "10 A tested level",
  seconds = 6,
  picture = 0.75,
  camera = { target = { 2, 0.2, 0 }, distance = 13, yaw = feder.deg(14), pitch = feder.deg(16) },

  build = function(world, scene)
    local function block(name, w, h, x, y, tilt)
      return world:body { name = name, type = "static", shape = feder.box(w, h, 1.2), color = "stone",
        position = { x, y, 0 }, rotation = { axis = { 0, 0, 1 }, angle = feder.deg(tilt or 0) } }
    end
    block("start", 4, 1, -2, -0.5)
    block("ramp", 1.6, 0.3, 0.66, 0.13, 25)
    block("far", 4, 1, 6.5, -0.5)
    block("wall", 0.2, 1.2, 7.4, 0.6)
    scene.score, scene.outcome = 0, "playing"

    scene.ball = world:body { name = "ball", shape = feder.sphere(0.2), color = "orange", position = { -3, 0.2, 0 },
      velocity = { push, 0, 0 } }

    -- a coin is a body that only notices; it is gone when the ball has it
    for i, at in ipairs(coins) do
      local coin = world:body { name = "coin" .. i, type = "static", sensor = true, shape = feder.cylinder(0.2, 0.06),
        color = "gold", position = { at[1], at[2], 0 }, rotation = { axis = { 1, 0, 0 }, angle = feder.deg(90) } }
      coin:on("sensor_enter", { other = scene.ball }, function()
        scene.score = scene.score + 10
        coin:destroy()
      end)
    end

    -- the goal ends the level; what is left of the time counts as well
    local function finish(outcome)
      if scene.outcome ~= "playing" then return end
      scene.outcome, scene.time = outcome, world:time()
      if outcome == "won" then scene.score = scene.score + math.floor(10 * (deadline - scene.time)) end
      print(("%s after %.2f s with %d points"):format(outcome, scene.time, scene.score))
    end
    local goal = world:region { name = "goal", box = { { 4.6, 0, -0.6 }, { 7.3, 0.5, 0.6 } } }
    goal:on("sensor_enter", { other = scene.ball }, function() finish("won") end)
    world:after(deadline, function() finish("late") end)
    scene.finish = finish
  end,

  update = function(world, scene)
    local _, y = scene.ball:position()
    if y < -2 then scene.finish("fallen") end
    feder.plot("score", scene.score)
  end,

  -- the level is good when a good push wins all of it, and a lazy one does not
  check = function(world, scene, expect)
    expect(scene.outcome ~= "playing", "the level never ends")
    if push < 8 then
      expect(scene.outcome ~= "won", ("a push of %.1f m/s wins: the level is too easy"):format(push))
    elseif push == 9 then
      expect(scene.outcome == "won", "the level ended " .. scene.outcome)
      expect(scene.score > 10 * #coins, ("only %d points"):format(scene.score))
    end
  end,
}
