-- A flag on a pole in gusty wind: it streams out and flutters, and hangs when the wind is off.
local feder = require "feder"
local cloth = require "feder.cloth"

local wind = feder.param("wind", 8, { min = 0, max = 20, help = "m/s" })
local gust = feder.param("gust", 0.5, { min = 0, max = 1 })
local columns = feder.param("columns", 33, { min = 9, max = 97 })

local width, height, top = 1.5, 1.0, 3.0

return feder.scene {
  title = "Flag",
  seconds = 8,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { type = "static", shape = feder.plane() }
    world:body { name = "pole", type = "static", shape = feder.cylinder(0.03, top + 0.2), color = "#8a8f96",
      position = { -0.045, (top + 0.2) / 2, 0 } }
    scene.flag = world:cloth(cloth.of("silk", { name = "flag", size = { width, height }, color = "#c8402f",
      resolution = { columns, columns * 2 // 3 }, position = { width / 2, top - height / 2, 0 },
      rotation = { axis = { 1, 0, 0 }, angle = feder.deg(90) }, pins = { "left" }, stretch = 12000, damping = 0.002 }))
    world:force { kind = "wind", velocity = { wind, 0, wind * 0.15 }, gust = gust, gust_hertz = 0.4 }
    scene.reach, scene.rise, scene.samples, scene.taut = 0, 0, 0, 0
  end,

  update = function(world, scene)
    if world:time() < 3 then return end
    local n = scene.flag:count()
    local x, y, z = scene.flag:point(n)
    scene.reach = scene.reach + math.sqrt(x * x + z * z)
    scene.rise = math.max(scene.rise, math.abs(z - (scene.last or z)) / world:dt())
    scene.last = z
    scene.samples = scene.samples + 1
    if scene.flag:stretch() > 0.1 then scene.taut = scene.taut + 1 end  -- an edge, where it snaps into itself
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    local taut = scene.taut / scene.samples
    expect(taut < 0.03, ("an edge is stretched by 10 %% in %.1f %% of the steps"):format(100 * taut))
    local reach = scene.reach / scene.samples
    if wind >= 8 then
      expect(reach > 0.6 * width, ("the free corner streams out to %.2f m only"):format(reach))
      expect(scene.rise > 0.2, ("the flag does not flutter: %.3f m/s"):format(scene.rise))
    end
    for i = 1, select(1, scene.flag:count()) do
      local x, y = scene.flag:point(i)
      expect(y > 0 and x > -width, "a corner is where no flag can be")
    end
  end,
}
