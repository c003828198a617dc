-- A grid of balls, each tied by ball joints to its upper and its left neighbour, hangs from its top row and falls into
-- its own shape: two joints per ball, nothing but joints to solve.
local feder = require "feder"

local side = feder.param("side", 20, { min = 2, max = 100, step = 1, help = "balls along an edge; 100 is the size of benchmarks" })

return feder.scene {
  title = "Joint grid",
  seconds = 5,
  world = { gravity = { 0, -10, 0 }, dt = 1 / 60, substeps = 4, sleeping = false },

  build = function(world, scene)
    local ball, grid = feder.sphere(0.4), {}
    scene.worst = 0
    for row = 1, side do
      for column = 1, side do
        local x, y = column, -row
        local body = world:body { name = ("ball%d_%d"):format(row, column), type = row == 1 and "static" or "dynamic",
          shape = ball, density = 1000, position = { x, y, 0 }, mask = 0 }
        local k = (row - 1) * side + column
        grid[k] = body
        if row > 1 then world:joint { type = "ball", a = grid[k - side], b = body, anchor = { x, y + 0.5, 0 } } end
        if column > 1 and row > 1 then world:joint { type = "ball", a = grid[k - 1], b = body, anchor = { x - 0.5, y, 0 } } end
      end
    end
    scene.grid = grid
  end,

  update = function(world, scene)
    scene.worst = math.max(scene.worst, world:residuals()["rigid.joint_error_m"] or 0)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.worst < 0.01, ("joints open by %.1f mm"):format(1000 * scene.worst))
    -- the grid hangs straight: no ball is lower than its joints, open by 2 mm each, let it
    local low = 0
    for k, body in ipairs(scene.grid) do
      local _, y = body:position()
      local row = (k - 1) // side + 1
      low = math.max(low, -y - row - 0.002 * row)
    end
    expect(low <= 0, ("a ball hangs %.1f mm too low"):format(1000 * low))
  end,
}
