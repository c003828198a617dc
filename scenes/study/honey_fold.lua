-- A sheet of what is far thicker than honey is pressed from a slot on a plate and folds to and fro, driven by its speed
-- alone: the plane sister of the coils of a rope (forced folding: Ribe, Phys. Rev. E 68, 2003). It passes its middle once
-- in 0.659 H / U, H the height of the slot above the folds and U the speed at which they take the sheet in: by the
-- equations of a thin sheet that resists bending by its viscosity, with weight and inertia (tests/fluid/test_sheet.cpp;
-- 0.625 without). Only sheets that are pressed hold together: one that hangs by its own weight tears.
local feder = require "feder"
local problem = require "feder.problem"

local p = problem.fluid(80, 2.8, { "dfsph", "pbf" })  -- wcsph takes minutes
local across = feder.param("across", 4, { min = 3, max = 20, step = 1, help = "particles across the sheet" })

local height, speed, viscosity, lead = 1, 1, 50, 0.3  -- m, m/s, kinematic viscosity in m^2/s, length of the slot in m
local thick, belt, share = across * p.spacing, 0.1, 0.659

local sheet, belts, passages, times, piles, last, first

-- Where the slot is: belts run down along it with the sheet, which keeps its direction there.
local function place_belts()
  for k, b in ipairs(belts) do b:set_position((2 * k - 3) * (thick + belt) / 2, height + lead / 2, 0) end
end

-- How high the folds lie: as far up as more than the sheet alone is at each height.
local function pile()
  local at, count, k = sheet:positions(), {}, 0
  for i = 2, #at, 3 do
    local row = at[i] // p.spacing
    count[row] = (count[row] or 0) + 1
  end
  while (count[k] or 0) > 1.5 * across do k = k + 1 end
  return k * p.spacing
end

-- Mean x at six tenths of the height.
local function middle()
  local at, sum, n = sheet:positions(), 0, 0
  for i = 1, #at, 3 do
    if math.abs(at[i + 1] - 0.6 * height) < 2 * p.spacing then sum, n = sum + at[i], n + 1 end
  end
  return n > 0 and sum / n or 0
end

-- Passages from the second on, when it folds, by as many as there should be while the pile grows evenly.
local function ratio()
  local n = #passages
  if n < 3 then return 2 end
  local from, to = passages[2], passages[n]
  local mt, mp, tt, tp = 0, 0, 0, 0
  for k = from, to do mt, mp = mt + times[k] / (to - from + 1), mp + piles[k] / (to - from + 1) end
  for k = from, to do tt, tp = tt + (times[k] - mt) ^ 2, tp + (times[k] - mt) * (piles[k] - mp) end
  local rise = math.max(1e-6, tp / tt)
  local function room(k) return height - mp - rise * (times[k] - mt) end
  local wanted = (speed + rise) / (share * rise) * math.log(room(from) / room(to))
  return (n - 2) / wanted
end

return feder.scene {
  title = "Folding sheet",
  seconds = p.seconds,
  world = p.world,

  study = problem.of_fluid(p, function() return sheet end, {
    observe = pile,
    reference = function() return first end,
    error = function() return math.abs(ratio() - 1) end,
    scale = { length = height, velocity = speed },
    certainty = { source = "passages of a thin viscous sheet, by the mean height of the folds",
      kind = "quad", uncertainty = 0.05,  -- a twentieth of the height thick, and the folds are not flat
      resolution = across * p.spacing },
  }),

  build = function(world)
    world:body { type = "static", shape = feder.plane() }
    sheet = problem.water(world, p, { name = "sheet", kinematic_viscosity = viscosity, color = "#d08a20" })
    belts = {}
    for k = 1, 2 do
      belts[k] = world:body { type = "kinematic", shape = feder.box(belt, lead, 1), velocity = { 0, -speed, 0 } }
    end
    place_belts()
    local points, rows = {}, math.floor((height + 0.7 * lead) / p.spacing)
    for j = 1, rows do
      local y = (j - 0.5) * p.spacing
      local x = y < height and 0.02 * height * math.sin(math.pi * y / height) or 0
      for i = 1, across do points[#points + 1] = { x + (i - 0.5) * p.spacing - thick / 2, y, 0 } end
    end
    sheet:fill { points = points }
    sheet:set_velocities(function() return 0, -speed, 0 end)
    sheet:emitter { position = { 0, (rows + 0.5) * p.spacing, 0 }, direction = { 0, -1, 0 }, speed = speed, radius = thick / 2 }
    passages, times, piles, last, first = {}, {}, {}, 1, pile()
  end,

  update = function(world)
    place_belts()
    local x = middle()
    times[#times + 1], piles[#piles + 1] = world:time(), pile()
    if x * last < 0 then passages[#passages + 1] = #times end
    if x ~= 0 then last = x end
  end,

  check = function(world, _, expect)
    expect(world:is_finite())
    expect(#passages >= 4, "the sheet does not fold")
    expect.error(math.abs(ratio() - 1), "<", 0.2, "passages, by as many as there should be")
  end,
}
