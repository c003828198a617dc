-- scenes/soft/jelly_tower.lua: cubes of jelly on top of each other, and a marble that falls on them. A column buckles
-- under its own weight at the height (7.8 E I/(rho g A))^(1/3): 0.73 m here, so a fourth cube brings it down.
local feder = require "feder"

local cubes = feder.param("cubes", 3, { min = 1, max = 8, help = "of jelly" })
local young = feder.param("young", 1.5e5, { min = 5e3, max = 1e6, help = "Pa" })

local side = 0.2

return feder.scene {
  title = "Jelly tower",
  seconds = 8,

  build = function(world, scene)
    world:body { type = "static", shape = feder.plane() }
    local colors = { "#c8553d", "#e9a23b", "#6a994e", "#4a7ba6" }
    scene.jellies = {}
    for i = 1, cubes do
      scene.jellies[i] = world:soft {
        name = "jelly" .. i, shape = feder.box(side, side, side), resolution = 4, young = young, poisson = 0.4,
        position = { 0, (i - 0.5) * side * 1.03 + 0.01, 0 }, rotation = { axis = { 0, 1, 0 }, angle = feder.deg(12 * i) },
        damping = 0.005, friction = 0.8, color = colors[(i - 1) % #colors + 1],
      }
    end
    world:after(3, function()
      scene.marble = world:body {
        name = "marble", shape = feder.sphere(0.04), position = { 0.01, cubes * side + 0.3, 0 }, density = 2500, friction = 0.8,
      }
    end)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    for i, jelly in ipairs(scene.jellies) do
      expect(jelly:inverted() == 0, "cube " .. i .. " has tetrahedra inside out")
      local change = jelly:volume() / jelly:rest_volume() - 1
      expect(math.abs(change) < 0.05, "cube " .. i .. " has changed its volume by " .. change)
      -- the middle of each stays above that of the one below
      local x, y, z, n = 0, 0, 0, jelly:count()
      for k = 1, n do
        local a, b, c = jelly:point(k)
        x, y, z = x + a / n, y + b / n, z + c / n
      end
      expect(x * x + z * z < 0.03 ^ 2, "cube " .. i .. " has slid")
      expect(math.abs(y - (i - 0.5) * side) < 0.1 * i * side, "cube " .. i .. " has its middle at " .. y)
    end
  end,
}
