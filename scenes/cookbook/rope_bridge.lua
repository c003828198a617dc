-- A rope bridge: planks tied to each other by ball joints, with flags that flutter at its hand posts, and a barrel that
-- rolls across.
local feder = require "feder"

local planks = feder.param("planks", 14, { min = 6, max = 30 })
local wind = feder.param("wind", 7, { min = 0, max = 12, help = "m/s, across the bridge" })

local step, width = 0.5, 1.4  -- from plank to plank and across, m

return feder.scene {
  title = "Rope bridge",
  seconds = 8,
  picture = 3,
  camera = { target = { 0, -0.1, 0 }, distance = 8.5, yaw = feder.deg(28), pitch = feder.deg(20) },

  build = function(world, scene)
    local half = planks * step / 2
    local function cliff(name, side)
      return world:body { name = name, type = "static", color = "stone", position = { side * (half + 1), 0, 0 },
        shape = feder.compound {
          { shape = feder.box(2, 3, 3), position = { 0, -1.5, 0 } },
          { shape = feder.box(0.3, 0.4, 3), position = { side * 0.85, 0.2, 0 } },  -- a low wall stops the barrel
        } }
    end
    local left, right = cliff("left", -1), cliff("right", 1)

    -- two ball joints side by side tie each plank to the last: they let it tilt, and keep it from twisting
    local function tie(a, b, x)
      for _, z in ipairs { -width / 2, width / 2 } do
        world:joint { type = "ball", a = a, b = b, anchor = { x, 0, z } }
      end
    end
    scene.planks, scene.flags = {}, {}
    local last = left
    for i = 1, planks do
      local x = (i - 0.5) * step - half
      local post = i % 4 == 3
      local shape = feder.box(step - 0.06, 0.08, width)
      if post then
        shape = feder.compound { { shape = shape },
          { shape = feder.cylinder(0.025, 1), position = { 0, 0.5, -width / 2 + 0.03 } } }
      end
      local plank = world:body { name = "plank" .. i, shape = shape, density = 500, color = "wood",
        position = { x, 0, 0 }, angular_damping = 0.5 }
      tie(last, plank, x - step / 2)
      scene.planks[i], last = plank, plank
      if post then scene.flags[#scene.flags + 1] = { plank = plank, x = x } end
    end
    tie(last, right, half)

    -- A sheet is made flat, row by row; turned about x it hangs, and the first vertex of each row is at the post. So
    -- small and light a thing whips about fast: allowing 10 % of stretch saves most of its solver substeps.
    for i, flag in ipairs(scene.flags) do
      local columns, rows = 8, 6
      local cloth = world:cloth { name = "flag" .. i, size = { 0.5, 0.3 }, resolution = { columns, rows },
        color = ({ "red", "yellow", "blue" })[(i - 1) % 3 + 1], stretch_error = 0.1,
        position = { flag.x + 0.28, 0.84, -width / 2 + 0.03 },
        rotation = { axis = { 1, 0, 0 }, angle = feder.deg(90) } }
      for row = 1, rows do cloth:attach((row - 1) * columns + 1, flag.plank) end
      flag.cloth = cloth
    end
    world:force { kind = "wind", velocity = { wind, 0, -0.3 * wind }, gust = 0.4, gust_hertz = 0.5 }

    scene.barrel = world:body { name = "barrel", shape = feder.cylinder(0.3, 0.8), mass = 30, color = "orange",
      position = { -half - 0.6, 0.32, 0.15 }, rotation = { axis = { 1, 0, 0 }, angle = feder.deg(90) },
      velocity = { 3.2, 0, 0 } }
  end,

  update = function(world, scene)
    for _, flag in ipairs(scene.flags) do
      local x, _, z = flag.cloth:point(8)
      flag.reach = math.max(flag.reach or 0, x - (flag.plank:position()))
    end
  end,

  check = function(world, scene, expect)
    local _, lowest = scene.planks[planks // 2]:position()
    expect(lowest < -0.05 and lowest > -1, ("the middle of the bridge hangs at %.2f m"):format(lowest))
    local x, y = scene.barrel:position()
    expect(x > planks * step / 2 and y > 0, ("the barrel is at %.2f, %.2f: it has not crossed"):format(x, y))
    for i, flag in ipairs(scene.flags) do
      expect(flag.reach > 0.3, ("flag %d streamed out by %.2f m only"):format(i, flag.reach))
    end
  end,
}
