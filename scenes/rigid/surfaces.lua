-- One mesh, four strips of triangles with surfaces of their own: plain ground, ice, a belt and a trampoline. A block
-- slides on the first two, one is carried by the belt, a ball bounces on the last; a sledge stands on plain ground with
-- runners of ice.
local feder = require "feder"

local speed = feder.param("speed", 3, { min = 0.5, max = 4 })

local g, friction, belt, drop = 9.81, 0.5, 1, 1

-- Strips along x, two metres wide each: the first has the body's own surface, the others those of the list.
local function ground()
  local vertices, triangles = {}, {}
  for row = 0, 4 do
    for _, x in ipairs { -2, 10 } do
      vertices[#vertices + 1] = { x, 0, 2 * row }
    end
  end
  for strip = 0, 3 do
    local a = 2 * strip + 1
    local of = strip > 0 and strip or nil
    triangles[#triangles + 1] = { a, a + 2, a + 1, of }
    triangles[#triangles + 1] = { a + 1, a + 2, a + 3, of }
  end
  return feder.mesh(vertices, triangles, {
    surfaces = { { material = "ice" }, { surface_velocity = { belt, 0, 0 } }, { restitution = 0.8 } },
  })
end

return feder.scene {
  title = "Surfaces",
  seconds = 2.5,
  picture = 1,
  camera = { target = { 3.5, 0.3, 4 }, distance = 11, pitch = feder.deg(30), yaw = feder.deg(20) },
  world = { materials = { ice = { friction = 0 } } },

  build = function(world, scene)
    world:body { name = "ground", type = "static", shape = ground(), friction = friction }
    local function block(name, z, v, shape)
      return world:body {
        name = name, shape = shape or feder.box(0.5, 0.3, 0.5), mass = 10, friction = friction,
        position = { 0, 0.15, z }, velocity = { v, 0, 0 },
      }
    end
    scene.plain, scene.ice, scene.carried = block("plain", 0.5, speed), block("ice", 3, speed), block("carried", 5, 0)
    local runner = feder.box(0.8, 0.1, 0.1)
    scene.sledge = block("sledge", 1.4, speed, feder.compound {
      { shape = runner, position = { 0, -0.1, 0.15 }, material = "ice" },
      { shape = runner, position = { 0, -0.1, -0.15 }, material = "ice" },
      { shape = feder.box(0.6, 0.1, 0.4) },
    })
    scene.ball = world:body { name = "ball", shape = feder.sphere(0.2), mass = 1, position = { 2, drop + 0.2, 7 } }
    scene.highest = 0
  end,

  update = function(world, scene)
    local _, y = scene.ball:position()
    if world:time() > 0.6 then scene.highest = math.max(scene.highest, y - 0.2) end
  end,

  check = function(_, scene, expect)
    local way = scene.plain:position()
    expect.near(way, speed ^ 2 / (2 * friction * g), 0.03)
    expect.near((scene.ice:velocity()), speed, 0.01)
    expect.near((scene.sledge:velocity()), speed, 0.01)
    expect.near((scene.carried:velocity()), belt, 0.01)
    expect.near(scene.highest, 0.64 * drop, 0.03)
  end,
}
