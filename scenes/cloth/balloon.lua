-- A balloon is blown up on the floor until its skin bears the pressure, and a crate falls on it.
local feder = require "feder"
local cloth = require "feder.cloth"

local pressure = feder.param("pressure", 400, { min = 50, max = 1000, help = "of the gas, Pa" })
local level = feder.param("level", 3, { min = 1, max = 4, help = "of the mesh" })

local radius, stretch = 0.5, 3000

return feder.scene {
  title = "Balloon",
  seconds = 5,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), friction = 0.6 }
    local points, triangles = cloth.sphere(radius, level, 8)
    scene.balloon = world:cloth { name = "balloon", vertices = points, triangles = triangles,
      position = { 0, radius + 0.01, 0 }, area_density = 0.15, stretch = stretch, damping = 0.01, self_collision = false,
      friction = 0.6, color = "#c8423b" }
    scene.empty = scene.balloon:volume()
    for k = 1, 10 do  -- blown up in a second
      world:after(k / 10, function() scene.balloon:set_pressure(pressure * k / 10) end)
    end
    world:after(2, function()
      -- strain e of the whole: 3 stretch e = p R (1 + e)^2, by its fixed point
      local e = 0
      for _ = 1, 20 do e = pressure * radius * (1 + e) ^ 2 / (3 * stretch) end
      scene.wanted, scene.blown = e, (scene.balloon:volume() / scene.empty) ^ (1 / 3) - 1
      scene.crate = world:body { name = "crate", shape = feder.box(0.3, 0.3, 0.3), mass = 1,
        position = { 0.05, 1.9, 0.02 }, friction = 0.6, color = "#8a6a3f" }
    end)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(math.abs(scene.blown / scene.wanted - 1) < 0.1,
      ("the balloon has grown by %.2f %%, its skin bears the pressure at %.2f %%"):format(100 * scene.blown,
        100 * scene.wanted))
    local grown = (scene.balloon:volume() / scene.empty) ^ (1 / 3) - 1
    expect(math.abs(grown / scene.wanted - 1) < 0.15, ("after the crate it is larger by %.2f %%"):format(100 * grown))
    local x, y, z = scene.crate:position()
    expect(y > 0.14, ("the crate lies at height %.3f"):format(y))
  end,
}
