-- A jelly falls on a bed of spikes: a cube of springs is dented by what it lies on, wobbles, and is not pierced.
local feder = require "feder"
local build = require "feder.build"

local stiffness = feder.param("stiffness", 80, { min = 50, max = 2000, help = "of a spring, N/m" })
local cells = feder.param("cells", 5, { min = 3, max = 7, help = "along an edge" })

local size, spike, apart = 0.8, 0.5, 0.28  -- edge of the cube, height of a spike, distance of spikes, m

return feder.scene {
  title = "Jelly on spikes",
  seconds = 5,
  picture = 3,
  camera = { target = { 0, 0.6, 0 }, distance = 3.2, yaw = feder.deg(35), pitch = feder.deg(6) },
  world = { substeps = 8 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    for i = -1, 1 do
      for k = -1, 1 do
        world:body { name = "spike", type = "static", shape = feder.cone(0.12, spike), color = "steel",
          position = { i * apart, spike / 2, k * apart } }
      end
    end
    -- points, springs between them, and the skin, whose faces are what touches the spikes
    local n = cells + 1
    local points, springs, faces = build.lattice { count = { n, n, n }, size = { size, size, size },
      position = { 0, 1.3, 0 }, stiffness = stiffness, damping = 2 }
    scene.jelly = world:net { name = "jelly", points = points, springs = springs, faces = faces, masses = 10 / #points,
      radius = 0.03, damping = 0.3, color = "green" }
  end,

  update = function(world, scene)
    local lowest = math.huge
    for i = 1, (scene.jelly:count()) do
      local _, y = scene.jelly:point(i)
      lowest = math.min(lowest, y)
    end
    scene.lowest = lowest
    feder.plot("lowest point", lowest)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.lowest > 0.1 and scene.lowest < spike + 0.1, ("the lowest point is %.2f m high"):format(scene.lowest))
    local middle = 0
    local count = scene.jelly:count()
    for i = 1, count do
      local x, y, z = scene.jelly:point(i)
      middle = middle + y / count
      expect(math.abs(x) < 1 and math.abs(z) < 1, "the jelly has fallen off")
    end
    expect(middle > spike + 0.1, ("its middle is %.2f m high: it sank between the spikes"):format(middle))
  end,
}
