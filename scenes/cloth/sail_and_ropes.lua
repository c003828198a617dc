-- A foresail that is held at its corners: the tack at the bow, the head by a halyard, the clew by a sheet, whose car runs
-- to lee on its rail: the sail fills and swings out, and the ropes bear what the wind presses on it with.
local feder = require "feder"

local wind = feder.param("wind", 8, { min = 0, max = 14, help = "m/s" })
local travel = feder.param("travel", 0.3, { min = 0, max = 0.4, help = "of the car to lee, m" })

local tack, head, clew = { 2.2, 0.9, 0 }, { 0.2, 3.9, 0 }, { 0.35, 1.1, 0 }  -- m, of the sail before the wind
local masthead, car = { 0, 4.35, 0 }, { -0.3, 0.36, 0.25 }
local cells = 18

-- A triangle of cloth; returns vertices, triangles, and the numbers of its corners b and c (a is 1).
local function triangle(a, b, c)
  local vertices, triangles = {}, {}
  local function number(i, j) return i * (i + 1) // 2 + j + 1 end  -- j in row i, which has i + 1 of them
  for i = 0, cells do
    for j = 0, i do
      local u, v = (i - j) / cells, j / cells
      local p = {}
      for k = 1, 3 do p[k] = a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]) end
      vertices[#vertices + 1] = p
      if i < cells then triangles[#triangles + 1] = { number(i, j), number(i + 1, j), number(i + 1, j + 1) } end
      if i < cells and j < i then
        triangles[#triangles + 1] = { number(i, j), number(i + 1, j + 1), number(i, j + 1) }
      end
    end
  end
  return vertices, triangles, number(cells, 0), number(cells, cells)
end

local function distance(ax, ay, az, bx, by, bz) return math.sqrt((ax - bx) ^ 2 + (ay - by) ^ 2 + (az - bz) ^ 2) end

return feder.scene {
  title = "Sail and ropes",
  seconds = 8,
  world = { gravity = { 0, -9.81, 0 }, dt = 1 / 60, substeps = 4 },
  camera = { target = { 0.6, 2.2, 0.3 }, distance = 7, yaw = feder.deg(-40), pitch = feder.deg(14) },
  picture = 6,

  build = function(world, scene)
    scene.mast = world:body { name = "mast", type = "static", shape = feder.cylinder(0.05, 4.4), position = { 0, 2.2, 0 },
      color = "#8a6a45" }
    world:body { name = "deck", type = "static", shape = feder.box(5, 0.3, 1.8), position = { 0, 0.15, 0 },
      color = "#a58a5f" }
    world:body { name = "bow", type = "static", shape = feder.cylinder(0.03, 0.6), position = { 2.25, 0.6, 0 },
      color = "#8a8f96" }
    local vertices, triangles, top, free = triangle(tack, head, clew)
    scene.top, scene.free = top, free
    scene.sail = world:cloth { name = "jib", vertices = vertices, triangles = triangles, pins = { 1 },
      area_density = 0.3, stretch = 60000, shear = 20000, bend = 1e-3, damping = 0.01, thickness = 0.012,
      self_collision = false, color = "#ece6d8",
      substeps = 24 }  -- of its own choice it takes half as many, and its light corners give way to the ropes
    local function rope(name, from, to, segments)
      return world:rope { name = name, from = from, to = to, segments = segments, radius = 0.006, density = 900,
        stretch = 60000, damping = 0.01, self_collision = false, color = "#3f5f8a" }
    end
    scene.halyard = rope("halyard", masthead, head, 10)
    scene.halyard:attach(1, scene.mast)
    scene.halyard:attach(11, scene.sail, top)
    scene.car = world:body { name = "car", type = "kinematic", shape = feder.box(0.1, 0.08, 0.1), position = car,
      color = "#8a8f96" }
    scene.sheet = rope("sheet", car, clew, 24)
    scene.sheet:attach(1, scene.car)
    scene.sheet:attach(25, scene.sail, free)
    world:force { kind = "wind", velocity = { -0.35 * wind, 0, 0.94 * wind } }
    scene.warned = 0
    world:on("warning", function() scene.warned = scene.warned + 1 end)
  end,

  update = function(world, scene)
    local t = math.max(0, math.min(1, (world:time() - 3) / 2))
    scene.car:move_to(car[1], car[2], car[3] + travel * t)
    if t == 0 then scene.lee = select(3, scene.sail:point(scene.free)) end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.warned == 0, ("%d warnings"):format(scene.warned))
    expect(scene.sail:stretch() < 0.1, ("the sail is stretched by %.1f %%"):format(100 * scene.sail:stretch()))
    local hx, hy, hz = scene.sail:point(scene.top)
    local cx, cy, cz = scene.sail:point(scene.free)
    -- ropes and sail stay together
    local x, y, z = scene.halyard:point(11)
    expect(distance(x, y, z, hx, hy, hz) < 0.005, "the halyard has let go")
    x, y, z = scene.sheet:point(25)
    expect(distance(x, y, z, cx, cy, cz) < 0.005, "the sheet has let go")
    -- how far the sail lies off the plane of its corners, to lee
    local ax, ay, az = tack[1] - hx, tack[2] - hy, tack[3] - hz
    local bx, by, bz = cx - hx, cy - hy, cz - hz
    local nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    local n = math.sqrt(nx * nx + ny * ny + nz * nz)
    if nz < 0 then n = -n end
    local belly = 0
    for i = 1, (scene.sail:count()) do
      local px, py, pz = scene.sail:point(i)
      belly = math.max(belly, ((px - hx) * nx + (py - hy) * ny + (pz - hz) * nz) / n)
    end
    if wind < 4 then return end
    expect(belly > 0.2, ("the belly is %.2f m deep only"):format(belly))
    -- of the pressure of the wind on its area, 2.58 m2, the sheet bears about a half, the halyard all
    local press = 0.5 * 1.2 * wind ^ 2 * 2.58
    local sheet, halyard = scene.sheet:tension(12) / press, scene.halyard:tension(5) / press
    expect(sheet > 0.3 and sheet < 1.5, ("the sheet bears %.2f of what presses on the sail"):format(sheet))
    expect(halyard > 0.6 and halyard < 3, ("the halyard bears %.2f of what presses on the sail"):format(halyard))
    expect(cz > scene.lee + 0.1 * travel - 0.002, ("the clew is %.2f m to lee, before %.2f m"):format(cz, scene.lee))
  end,
}
