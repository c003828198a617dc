-- Extreme inputs (scenes/extreme/*_test.lua): what is refused, with its culprit named and the world as it was, and what
-- runs and ends as said. Each case prints one line, apart by tabs: ok or FAIL, the input, what is expected, a verdict,
-- details. Verdicts: nan diverged growing stuck damped inaccurate slow refused stable. A case that needs what this build
-- lacks prints "left out" and why.
--   local extreme = require "feder.extreme"
--   extreme.needs "body"
--   extreme.refused("rigid: mass -1", "mass", world, function() world:body { shape = feder.sphere(1), mass = -1 } end)
--   extreme.case("rigid: needle 1000 : 1", "lies still", function() return speed < 0.05, "stable", "speed, m/s 0" end)
--   extreme.finish()
local feder = require "feder"
local extreme = {}

local count, failed = 0, {}

local function report(as_expected, input, expected, verdict, detail)
  count = count + 1
  if not as_expected then failed[#failed + 1] = input end
  print(as_expected and "ok" or "FAIL", input, expected, verdict, (detail:gsub("%s+", " ")))
end

-- `act` must raise an error that begins with file:line and contains `word`, and leave `world` as it was.
function extreme.refused(input, word, world, act)
  local before = world:hash()
  local accepted, message = pcall(act)
  local faults = {}
  if accepted then
    message, faults[1] = "", "was accepted"
  else
    local words = message:match("^[^\n]-%.lua:%d+: (.*)$")
    if not words then faults[1] = "does not begin with file:line" end
    if not (words or message):find(word, 1, true) then faults[#faults + 1] = "does not name " .. word end
  end
  if world:hash() ~= before then faults[#faults + 1] = "the world changed" end
  local detail = table.concat({ message, table.unpack(faults) }, "; ", message == "" and 2 or 1)
  report(#faults == 0, input, "refused, " .. word .. " named", accepted and "stable" or "refused", detail)
end

-- `run` returns whether it ended as the sentence `expected` says, its verdict, and numbers as text. An error in it
-- fails this case, and those after it run.
function extreme.case(input, expected, run)
  local done, as_expected, verdict, detail = pcall(run)
  if done then
    report(as_expected, input, expected, verdict, detail)
  elseif tostring(as_expected):find("this build leaves out", 1, true) then
    print("left out", input, (as_expected:match("this build leaves out.*")))
  else
    report(false, input, expected, "refused", tostring(as_expected))
  end
end

-- An error that leaves a file or a case out, in builds whose worlds do not make such things.
function extreme.needs(maker)
  local world = feder.world {}
  if not pcall(function() return world[maker] end) then error("this build leaves out world:" .. maker, 2) end
end

-- The end of the script: an error when a case was not as expected.
function extreme.finish()
  if #failed > 0 then
    error(("%d of %d cases not as expected: %s"):format(#failed, count, table.concat(failed, "; ")), 2)
  end
end

-- What the world warns of from now on: `named` when a warning was about the object; `text`, the last one for details.
function extreme.warnings(world, object)
  local warnings = { named = false, text = "" }
  world:on("warning", function(e)
    warnings.named = warnings.named or e.object == object
    warnings.text = "; warned: " .. e.message
  end)
  return warnings
end

return extreme
