-- A trampoline (a net with faces) catches a towel, a jelly ball and a crate: nets, cloth and bodies meet by their surfaces.
local feder = require "feder"
local build = require "feder.build"

local stiffness = feder.param("stiffness", 800, { min = 300, max = 1000 })

return feder.scene {
  title = "Trampoline",
  seconds = 2.5,
  picture = 1.2,
  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), color = "#888888" }
    local points, springs, faces = build.grid { count = { 13, 13 }, size = { 2, 2 }, position = { 0, 0.8, 0 },
      stiffness = stiffness, damping = 1 }
    scene.net = world:net { name = "trampoline", points = points, springs = springs, faces = faces, masses = 0.1,
      radius = 0.02, color = "#4477aa" }
    for i = 1, #points do
      local x, _, z = scene.net:point(i)
      if math.abs(x) > 0.99 or math.abs(z) > 0.99 then scene.net:pin(i) end
    end
    scene.towel = world:cloth { name = "towel", size = { 0.8, 0.8 }, resolution = { 11, 11 }, position = { -0.3, 1.1, 0 },
      color = "#cc6655" }
    points, springs, faces = build.ball { radius = 0.25, position = { 0.3, 1.6, 0.2 }, stiffness = 300, damping = 1 }
    scene.jelly = world:net { name = "jelly", points = points, springs = springs, faces = faces, masses = 3 / #points,
      radius = 0.03, color = "#6fb36f" }
    scene.crate = world:body { name = "crate", shape = feder.box(0.25, 0.25, 0.25), density = 150,
      position = { -0.4, 1.8, -0.1 }, color = "#a67c4a" }
    scene.touched = {}
    world:on("contact_begin", function(e) scene.touched[e.a:name() .. "-" .. e.b:name()] = true end)
  end,
  check = function(world, scene, expect)
    local _, y = scene.crate:position()
    expect(y > 0.4, ("the crate is at %.2f m"):format(y))
    for _, soft in ipairs { scene.jelly, scene.towel } do
      for i = 1, soft:count() do
        local _, h = soft:point(i)
        expect(h > 0.2, ("%s: point %d is at %.2f m"):format(soft:name(), i, h))
      end
    end
    for _, pair in ipairs { "trampoline-towel", "trampoline-jelly" } do expect(scene.touched[pair], pair .. " never met") end
  end,
}
