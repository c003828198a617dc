-- A shirt from a file, scenes/cloth/shirt.obj, on a hanger in a breeze: it swings, and hangs still when that is over.
local feder = require "feder"

local breeze = feder.param("breeze", 4, { min = 0, max = 8, help = "m/s" })
local weight = feder.param("weight", 0.18, { min = 0.1, max = 0.5, help = "of the cloth, kg/m2" })

local height, drop, reach, rod = 1.5, 0.05, 0.21, 0.012  -- m: of the hanger, of its ends below it, to the sides, radius

return feder.scene {
  title = "Shirt",
  seconds = 10,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },
  camera = { target = { 0, 1.25, 0 }, distance = 2.2, yaw = feder.deg(25), pitch = feder.deg(10) },
  picture = 3,

  build = function(world, scene)
    world:body { name = "ground", type = "static", shape = feder.plane() }
    local slope = math.atan(drop, reach)
    local function arm(side)
      return { shape = feder.capsule(rod, math.sqrt(drop ^ 2 + reach ^ 2) + 2 * rod),
        position = { side * reach / 2, -drop / 2, 0 }, rotation = { axis = { 0, 0, 1 }, angle = math.pi / 2 - side * slope } }
    end
    scene.hanger = world:body { name = "hanger", type = "static", position = { 0, height, 0 }, friction = 0.5,
      color = "#8a6a45", shape = feder.compound { arm(-1), arm(1),
        { shape = feder.capsule(rod / 2, 0.3), position = { 0, 0.15, 0 } } } }
    local mesh = feder.load_mesh "shirt.obj"
    scene.shirt = world:cloth { name = "shirt", vertices = mesh.vertices, triangles = mesh.triangles,
      position = { 0, height + 0.05, 0 }, area_density = weight, stretch = 3000, shear = 400, bend = 2e-5, damping = 0.01,
      thickness = 0.008, friction = 0.5, color = "#3f6f9a" }
    scene.vertices = #mesh.vertices
    local wind = world:force { kind = "wind", velocity = { 0.3 * breeze, 0, breeze }, gust = 0.5, gust_hertz = 0.8 }
    world:after(4, function() wind:set_enabled(false) end)
    scene.swing = 0
  end,

  update = function(world, scene)
    local z = 0
    for i = 1, scene.vertices do z = z + select(3, scene.shirt:point(i)) / scene.vertices end
    scene.swing = math.max(scene.swing, z)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.shirt:count() == scene.vertices, "the cloth has other vertices than the file")
    expect(scene.shirt:stretch() < 0.06, ("the shirt is stretched by %.1f %%"):format(100 * scene.shirt:stretch()))
    expect(scene.shirt:tangles() == 0, ("%d tangles"):format(scene.shirt:tangles()))
    local kinetic = world:energy()
    expect(kinetic < 0.05 * weight, ("it still swings: %.3f J"):format(kinetic))
    if breeze >= 3 then expect(scene.swing > 0.05, ("it swung out by %.3f m only"):format(scene.swing)) end
    -- shoulders on the hanger, hem below, nothing on the ground
    local lowest, highest, x = 10, 0, 0
    for i = 1, scene.vertices do
      local px, py = scene.shirt:point(i)
      lowest, highest, x = math.min(lowest, py), math.max(highest, py), x + px / scene.vertices
    end
    expect(highest > height and highest < height + 0.08, ("its shoulders are at %.2f m"):format(highest))
    expect(lowest > height - 0.8 and lowest < height - 0.6, ("its hem is at %.2f m"):format(lowest))
    expect(math.abs(x) < 0.05, ("it has slipped by %.2f m"):format(x))
  end,
}
