-- A chain of 20 links with a ball at its end of 512 times a link's mass, released horizontally.
local feder = require "feder"

local links = feder.param("links", 20, { min = 2, max = 60, step = 1 })
local chains = feder.param("chains", 1, { min = 1, max = 20, step = 1, help = "chains side by side, 6 m apart" })
local radius = feder.param("radius", 2, { min = 0.25, max = 4, help = "of the end ball; a link has 0.25 m" })

return feder.scene {
  title = "Heavy chain",
  seconds = 10,
  world = { gravity = { 0, -10, 0 }, dt = 1 / 60, substeps = 4, sleeping = false },

  build = function(world, scene)
    scene.worst, scene.ends = 0, {}
    local link, ball = feder.sphere(0.25), feder.sphere(radius)
    for c = 1, chains do
      local last
      for i = 0, links - 1 do
        local at = { 0.5 * i, 0, 6 * c }
        local body = world:body {
          type = i == 0 and "static" or "dynamic", shape = i == links - 1 and ball or link,
          position = at, density = 1000, mask = 0,
        }
        if last then world:joint { type = "ball", a = last, b = body, anchor = { at[1] - 0.25, 0, at[3] } } end
        last = body
      end
      scene.ends[c] = last
    end
  end,

  update = function(world, scene)
    scene.worst = math.max(scene.worst, world:residuals()["rigid.joint_error_m"] or 0)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    expect(scene.worst < 0.05, ("joints open by %.4f m"):format(scene.worst))
    for _, ball in ipairs(scene.ends) do
      local x, y, z = ball:position()
      local reach = math.sqrt(x * x + y * y)
      expect(reach < 0.5 * (links - 1) * 1.05, "the chain is stretched to " .. reach .. " m")
    end
  end,
}
