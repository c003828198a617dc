-- A row of dominoes: the first is tipped, all fall, one after the other.
local feder = require "feder"

local count = feder.param("count", 30, { min = 2, max = 300, step = 1 })
local gap = feder.param("gap", 0.5, { min = 0.2, max = 0.9, help = "distance between centres in m; they are 1 m high" })

return feder.scene {
  title = "Dominoes",
  camera = { yaw = feder.deg(58), pitch = feder.deg(24) },
  seconds = 8,
  world = { dt = 1 / 60, substeps = 4 },

  build = function(world, scene)
    world:body { type = "static", shape = feder.plane(), friction = 0.8 }
    scene.dominoes = {}
    scene.order = {}
    for i = 1, count do
      scene.dominoes[i] = world:body {
        name = "domino" .. i, tags = { "domino" }, shape = feder.box(0.125, 1, 0.5),
        position = { (i - 1) * gap, 0.5, 0 }, density = 600, friction = 0.4,
      }
    end
    -- a push at the top edge; tipping the first takes 6 N s: m g (diagonal - height)/2 of rotational energy about its
    -- foot
    world:after(0.5, function() scene.dominoes[1]:apply_impulse(12, 0, 0, 0, 1, 0) end)
    world:on("contact_begin", { tag = "domino" }, function(e)
      local a, b = e.a:name():match("^domino(%d+)$"), e.b:name():match("^domino(%d+)$")
      if a and b then scene.order[#scene.order + 1] = math.max(tonumber(a), tonumber(b)) end
    end)
  end,

  check = function(world, scene, expect)
    expect(world:is_finite())
    for i, domino in ipairs(scene.dominoes) do
      local _, y = domino:position()
      expect(y < 0.45, domino:name() .. " is still standing at " .. y)
    end
    -- first touches run along the row
    local first, seen = {}, 1
    for _, i in ipairs(scene.order) do
      if not first[i] then
        first[i] = true
        expect(i >= seen, "domino" .. i .. " was hit before its neighbour")
        seen = math.max(seen, i)
      end
    end
    expect(seen == count, "the wave ended at domino" .. seen)
  end,
}
