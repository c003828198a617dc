-- A block of a hundred thousand springs hangs from its top: at rest the top carries the block's weight, every layer
-- stretches by what hangs below it, and what swings is damped away.
local feder = require "feder"
local build = require "feder.build"

local nx = feder.param("nx", 20, { min = 3, max = 60, help = "points along x and z" })
local ny = feder.param("ny", 22, { min = 3, max = 60, help = "points from top to bottom" })
local stiffness = feder.param("stiffness", 6000, { min = 3000, max = 6500, help = "N/m; stiffer blocks want more substeps" })

local gravity, spacing, density = 9.81, 0.1, 500

return feder.scene {
  title = "Lattice",
  seconds = 4,
  world = { gravity = { 0, -gravity, 0 }, dt = 1 / 60, substeps = 8 },

  build = function(world, scene)
    local width, height = (nx - 1) * spacing, (ny - 1) * spacing
    local points, springs, faces = build.lattice {
      count = { nx, ny, nx }, size = { width, height, width }, position = { 0, height / 2, 0 },
      stiffness = stiffness, damping = 2,
    }
    scene.mass = density * spacing ^ 3
    scene.points, scene.springs, scene.top = points, springs, height
    scene.net = world:net { name = "block", points = points, springs = springs, faces = faces, masses = scene.mass,
      damping = 3 }
    for i, p in ipairs(points) do
      if p[2] > height - spacing / 2 then scene.net:pin(i) end
    end
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    local row = feder.advise(world)[1]
    expect(row.verdict == "stable", row.text)

    -- what the springs pull on the top against the weight of all points below
    local pull, free = 0, #scene.points - nx * nx
    for k, s in ipairs(scene.springs) do
      local i, j = s[1], s[2]
      local yi, yj = scene.points[i][2], scene.points[j][2]
      local i_held, j_held = yi > scene.top - spacing / 2, yj > scene.top - spacing / 2
      if i_held ~= j_held then
        local ax, ay, az = scene.net:point(i)
        local bx, by, bz = scene.net:point(j)
        local now = math.sqrt((ax - bx) ^ 2 + (ay - by) ^ 2 + (az - bz) ^ 2)
        pull = pull + stiffness * (now - now / (1 + scene.net:strain(k))) * math.abs(ay - by) / now
      end
    end
    local weight = free * scene.mass * gravity
    expect(math.abs(pull / weight - 1) < 0.02, ("the top carries %.3f N of %.3f N"):format(pull, weight))

    -- layers stretch the less the less hangs below them; near the top the held layer keeps the block wide, and stiff
    local middle = (nx + 1) // 2
    local function height_of(j) return select(2, scene.net:point(((middle - 1) * ny + j - 1) * nx + middle)) end
    for j = 2, ny // 2 do
      local below, above = height_of(j) - height_of(j - 1), height_of(j + 1) - height_of(j)
      expect(above > below - 1e-5, ("layer %d stretches to %.6f m, the one above it to %.6f m"):format(j, below, above))
    end
    local kinetic = world:energy()
    expect(kinetic < 1e-4 * weight, ("not at rest: %.2e J"):format(kinetic))
  end,
}
