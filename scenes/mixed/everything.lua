-- All in one world: a hose wets a banner and a jelly beside a tower of crates; then a ball throws the tower over.
-- Fluid, cloth, net and bodies push each other in the same substep.
local feder = require "feder"
local build = require "feder.build"

local fluid = feder.param("fluid", true, { help = "false leaves the water out" })
local particles = feder.param("particles", 600, { min = 100, max = 4000 })
local crates = feder.param("crates", 6, { min = 2, max = 12 })

local spacing, size = 0.05, 0.3  -- of the particles, of a crate, m

-- Counts contact pairs by the kinds of the two.
local function touched(scene, a, b)
  if not a or not b then return end
  local ka, kb = a:kind(), b:kind()
  if kb < ka then ka, kb = kb, ka end
  scene.touched[ka .. "-" .. kb] = (scene.touched[ka .. "-" .. kb] or 0) + 1
end

return feder.scene {
  title = "Everything",
  seconds = 20,
  camera = { target = { 0.1, 0.75, 0 }, distance = 5.2, yaw = feder.deg(28), pitch = feder.deg(18) },
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), friction = 0.7 }
    -- a basin
    local lx, lz, h, t = 2.8, 1.5, 0.2, 0.06
    for _, s in ipairs { -1, 1 } do
      world:body { type = "static", shape = feder.box(t, h, lz + t), position = { s * lx / 2, h / 2, 0 }, color = "#7d8a92" }
      world:body { type = "static", shape = feder.box(lx, h, t), position = { 0, h / 2, s * lz / 2 }, color = "#7d8a92" }
    end

    scene.crates = {}
    for i = 1, crates do
      scene.crates[i] = world:body { name = "crate" .. i, shape = feder.box(size, size, size), density = 600, friction = 0.6,
        position = { 0.1, size * (i - 0.5), 0 } }
    end

    local n, edge, radius = 5, 0.55, 0.04
    local points, springs, faces = build.lattice { count = { n, n, n }, size = { edge, edge, edge },
      position = { 0.62, edge / 2 + radius, 0 }, stiffness = 400, damping = 2 }
    scene.count = #points
    scene.jelly = world:net { name = "jelly", points = points, springs = springs, faces = faces, masses = 12 / #points,
      radius = radius, friction = 0.6, damping = 0.5, color = "#6fb36f" }

    -- the banner hangs between two poles, across the way of the water and of the ball
    local wide, high, top = 1.3, 1.0, 1.95
    for _, s in ipairs { -1, 1 } do
      world:body { type = "static", shape = feder.cylinder(0.025, top), color = "#6b5a48", position = { -0.5, top / 2, s * (wide / 2 + 0.03) } }
    end
    scene.banner = world:cloth { name = "banner", size = { high, wide }, resolution = { 15, 19 }, area_density = 0.4,
      stretch = 6000, damping = 0.01, friction = 0.3, color = "#b03a48", position = { -0.5, top - high / 2, 0 },
      rotation = { axis = { 0, 0, 1 }, angle = feder.deg(-90) }, pins = { "top_left", "bottom_left", "left" } }

    if fluid then
      scene.water = world:fluid { name = "water", spacing = spacing, viscosity = 0.5, max_particles = particles + 100 }
      scene.hose = scene.water:emitter { name = "hose", position = { -1.3, 1.35, 0.1 }, direction = { 1, 0.3, -0.05 },
        speed = 3, radius = 0.08, rate = particles / 6, limit = particles }
    end

    scene.touched, scene.hits, scene.causes, scene.done, scene.pressed = {}, 0, {}, nil, 0
    world:on("contact_begin", function(e) touched(scene, e.a, e.b) end)
    world:on("hit", { min_speed = 1 }, function(e) scene.hits = scene.hits + 1 end)
    world:on("wake", function(e) scene.causes[e.cause] = (scene.causes[e.cause] or 0) + 1 end)
    world:on("emitter_done", function(e) scene.done = e.count end)
    world:after(8, function()
      scene.ball = world:body { name = "ball", shape = feder.sphere(0.16), position = { -2.4, 0.8, -0.05 }, velocity = { 8, 1.6, 0.2 },
        density = 2500, color = "#30343a" }
    end)
  end,

  update = function(world, scene)
    if not fluid then return end
    local r = world:residuals()
    if (r["fluid_cloth.force_n"] or 0) ~= 0 then scene.cloth_wet = true end
    if (r["fluid_springs.impulse_ns"] or 0) > 0 then scene.jelly_wet = true end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.hits > 0, "nothing hit anything")
    expect((scene.touched["body-net"] or 0) > 0, "the jelly was never touched")
    expect((scene.touched["body-cloth"] or 0) > 0, "the banner was never touched")
    -- the tower lies
    local _, top = scene.crates[crates]:position()
    expect(top < size * (crates - 1), ("the last crate is %.2f m high"):format(top))
    for i = 1, scene.count do
      local x, y, z = scene.jelly:point(i)
      expect(y > -0.01 and math.abs(x) < 8 and math.abs(z) < 8, "a point of the jelly is where it cannot be")
    end
    expect(scene.banner:stretch() < 0.3, ("the banner is stretched by %.0f %%"):format(100 * scene.banner:stretch()))
    if not fluid then return end
    expect(scene.done == particles, "the hose has not given what it should")
    expect(scene.water:count() == particles, "water has gone")
    expect(scene.cloth_wet, "the banner was never wet")
    expect(scene.jelly_wet, "the jelly was never wet")
    local x = scene.water:positions()
    for i = 1, #x, 3 do expect(x[i + 1] > 0, "a particle went through the floor") end
  end,
}
