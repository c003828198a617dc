-- scenes/soft/ragdoll.lua: a plush doll is thrown down some stairs. Its head and limbs are soft bodies, sewn to a soft
-- torso along a line of three or four points each; it stays in one piece, comes to lie, and its stuffing springs back.
local feder = require "feder"

local young = feder.param("young", 3e4, { min = 2e4, max = 1e5, help = "of the stuffing, Pa" })
local speed = feder.param("speed", 2, { min = 1.5, max = 3, help = "that it is thrown with, m/s" })

local steps, rise, tread = 6, 0.16, 0.26  -- of the stairs, m
local start = steps * rise + 0.45         -- height of the doll's middle
local cell = 0.045                        -- of the lattice that all parts are cut from, m

-- name, box of cells { from, to }, where it is sewn to the torso: the plane and the line of it, color
local parts = {
  { "torso", { 0, 0, 0 }, { 5, 6, 2 }, nil, "#b08968" },
  { "head", { 1, 6, 0 }, { 4, 9, 2 }, { y = 6, z = 1 }, "#ddb892" },
  { "left arm", { 5, 4, 0 }, { 10, 6, 2 }, { x = 5, y = 5 }, "#7f5539" },
  { "right arm", { -5, 4, 0 }, { 0, 6, 2 }, { x = 0, y = 5 }, "#7f5539" },
  { "left leg", { 3, -6, 0 }, { 5, 0, 2 }, { y = 0, z = 1 }, "#7f5539" },
  { "right leg", { 0, -6, 0 }, { 2, 0, 2 }, { y = 0, z = 1 }, "#7f5539" },
}

-- Five tetrahedra in each cell of a box, mirrored from cell to cell so that their diagonals meet; also returns the
-- number of the point at each place of the lattice.
local function block(from, to)
  local points, cells, number = {}, {}, {}
  local function at(x, y, z) return (x * 100 + y) * 100 + z end
  for x = from[1], to[1] do
    for y = from[2], to[2] do
      for z = from[3], to[3] do
        points[#points + 1] = { (x - 2.5) * cell, (y - 3) * cell, (z - 1) * cell }
        number[at(x, y, z)] = #points
      end
    end
  end
  local even = { { 1, 2, 3, 5 }, { 4, 2, 3, 8 }, { 6, 2, 5, 8 }, { 7, 3, 5, 8 }, { 2, 3, 5, 8 } }
  local odd = { { 2, 1, 4, 6 }, { 3, 1, 4, 7 }, { 5, 1, 6, 7 }, { 8, 4, 6, 7 }, { 1, 4, 6, 7 } }
  for x = from[1], to[1] - 1 do
    for y = from[2], to[2] - 1 do
      for z = from[3], to[3] - 1 do
        local corner = {}
        for c = 0, 7 do corner[c + 1] = number[at(x + c % 2, y + c // 2 % 2, z + c // 4)] end
        for _, t in ipairs((x + y + z) % 2 == 0 and even or odd) do
          cells[#cells + 1] = { corner[t[1]], corner[t[2]], corner[t[3]], corner[t[4]] }
        end
      end
    end
  end
  return points, cells
end

-- Sews a limb to the torso along a line of points that both have; returns their numbers { i, j }, ...
local function sew(limb, torso, seam)
  local made = {}
  local line = { seam.x and (seam.x - 2.5) * cell, seam.y and (seam.y - 3) * cell, seam.z and (seam.z - 1) * cell }
  for i = 1, limb:count() do
    local p = { limb:rest_point(i) }
    local on = true
    for a = 1, 3 do on = on and (not line[a] or math.abs(p[a] - line[a]) < 1e-4) end
    for j = 1, on and torso:count() or 0 do
      local x, y, z = torso:rest_point(j)
      if math.abs(p[1] - x) + math.abs(p[2] - y) + math.abs(p[3] - z) < 1e-4 then
        limb:attach(i, torso, j)
        made[#made + 1] = { i, j }
      end
    end
  end
  return made
end

-- Of a soft body: its middle, and the root mean square of the speeds.
local function state(one)
  local n, x, y, z, sum = one:count(), 0, 0, 0, 0
  for i = 1, n do
    local a, b, c = one:point(i)
    local u, v, w = one:velocity(i)
    x, y, z, sum = x + a / n, y + b / n, z + c / n, sum + (u * u + v * v + w * w) / n
  end
  return x, y, z, math.sqrt(sum)
end

return feder.scene {
  title = "Plush ragdoll",
  seconds = 4,
  picture = 0.6,
  camera = { target = { 0.7, 0.6, 0 }, distance = 2.6, yaw = feder.deg(20), pitch = feder.deg(14) },

  build = function(world, scene)
    world:body { name = "floor", type = "static", shape = feder.plane(), friction = 0.6 }
    for k = 0, steps do  -- the landing is the first
      local h, long = (steps - math.max(k - 1, 0)) * rise, k == 0 and 0.6 or tread
      world:body { name = "stair" .. k, type = "static", shape = feder.box(long, h, 1.2), friction = 0.6,
        position = { k == 0 and -0.3 or (k - 0.5) * tread, h / 2, 0 }, color = "#ced4da" }
    end
    scene.parts, scene.stitches, scene.gap = {}, {}, 0
    for k, part in ipairs(parts) do
      local name, from, to, seam, color = table.unpack(part)
      local points, cells = block(from, to)
      -- limbs do not collide with the torso that they are stitched to
      local one = world:soft { name = name, points = points, tetrahedra = cells, young = young, poisson = 0.3,
        position = { -0.2, start, 0 },
        velocity = { speed, 0, 0 }, density = 250, damping = 0.04, friction = 0.6, color = color,
        group = k == 1 and 4 or 8, mask = k == 1 and 1 or 9 }
      scene.parts[k] = one
      if k > 1 then scene.stitches[k] = sew(one, scene.parts[1], seam) end
    end
  end,

  update = function(world, scene)
    scene.now = 0
    for k = 2, #parts do
      for _, pair in ipairs(scene.stitches[k]) do
        local a, b, c = scene.parts[k]:point(pair[1])
        local x, y, z = scene.parts[1]:point(pair[2])
        scene.now = math.max(scene.now, math.sqrt((a - x) ^ 2 + (b - y) ^ 2 + (c - z) ^ 2))
      end
    end
    scene.gap = math.max(scene.gap, scene.now)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    for _, code in ipairs { "diverged", "inverted", "non_finite", "tangled" } do expect.no_warnings(code) end
    -- where the doll strikes an edge of a stair its seams open by half a cell, by more than one with few substeps, and
    -- close again; the warning attachment_gap says so
    expect.error(scene.gap, "<", 1.8 * cell, "largest gap of a seam")
    expect.error(scene.now, "<", 0.1 * cell, "gap of a seam at the end")
    for k, one in ipairs(scene.parts) do
      local name = parts[k][1]
      local x, y, z, moves = state(one)
      expect.error(y, "<", 3 * rise, "height of the " .. name)
      expect.error(y, ">", 0, "height of the " .. name)
      expect.error(moves, "<", 0.15, "speed of the " .. name)
      expect(one:inverted() == 0, "the " .. name .. " has tetrahedra inside out")
      expect.error(math.abs(one:volume() / one:rest_volume() - 1), "<", 0.03, "change of volume of the " .. name)
    end
  end,
}
