-- A cube of springs on the floor, and a box dropped on it: the jelly is squeezed, carries the box, and nothing sinks.
local feder = require "feder"
local build = require "feder.build"

local cells = feder.param("cells", 4, { min = 3, max = 6 })
local box_mass = feder.param("box_mass", 4, { min = 0.1, max = 5, help = "kg; one of 8 ends on the floor" })
local stiffness = feder.param("stiffness", 900, { min = 100, max = 2000 })

local size, radius = 1, 0.06

return feder.scene {
  title = "Jelly",
  seconds = 6,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 8 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), friction = 0.8 }
    local n = cells + 1
    local points, springs, faces = build.lattice {
      count = { n, n, n }, size = { size, size, size }, position = { 0, size / 2 + radius, 0 },
      stiffness = stiffness, damping = 3,
    }
    scene.count = #points
    scene.jelly = world:net { name = "jelly", points = points, springs = springs, faces = faces,
      masses = 8 / #points, radius = radius, friction = 0.8, damping = 0.5 }
    scene.box = world:body { name = "box", shape = feder.box(0.7, 0.3, 0.7), mass = box_mass, friction = 0.8,
      position = { 0.05, size + 0.8, 0 } }
    scene.touched = false
    world:on("contact_begin", function(e)
      if (e.a == scene.box and e.b == scene.jelly) or (e.a == scene.jelly and e.b == scene.box) then
        scene.touched = true
      end
    end)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.touched, "no contact between box and jelly")

    -- nothing has sunk into the floor or been torn off
    local top = 0
    for i = 1, scene.count do
      local x, y, z = scene.jelly:point(i)
      expect(y > 0.75 * radius, ("point %d is %.4f m above the floor"):format(i, y))
      expect(math.abs(x) < size and math.abs(z) < size, "a point was thrown away")
      top = math.max(top, y)
    end
    expect(top > 0.6 * size and top < 1.15 * size, ("the jelly stands %.3f m high"):format(top))

    -- the box lies on the jelly, upright and slow
    local x, y, z = scene.box:position()
    expect(y > 0.5 * size + 0.15, ("the box is only %.3f m above the floor"):format(y))
    expect(math.abs(x) < 0.4 and math.abs(z) < 0.4, "the box slid off")
    local vx, vy, vz = scene.box:velocity()
    local speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    expect(speed < 0.1, ("the box still moves with %.3f m/s"):format(speed))
  end,
}
