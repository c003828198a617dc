// What scripts cannot do: leave the sandbox, run for ever, fill the memory, see addresses or the clock.
#include "support/script.h"

using namespace feder;
using namespace feder::test;

TEST_CASE("only what is allowed is there", "[lua][sandbox]") {
  CHECK(output_of(R"(
    local names = {}
    for name in pairs(_G) do names[#names + 1] = name end
    print(table.concat(names, " "))
    print(string.dump, io, os, debug, package, dofile, loadfile, getmetatable(""))
  )") == "_G _VERSION assert collectgarbage coroutine error getmetatable ipairs load math next pairs pcall print "
         "rawequal rawget rawlen rawset "
         "require select setmetatable string table tonumber tostring type utf8 xpcall\n"
         "nil\tnil\tnil\tnil\tnil\tnil\tnil\tfalse\n");
}

TEST_CASE("code comes from text only", "[lua][sandbox]") {
  CHECK(output_of(R"(
    print(load("return 1 + 1")(), load("syntax error here"))
    print((load("\27Lua\x54\0\25\x93\r\n\26\n")))
    local env = { x = 5 }
    print(load("return x", "c", "t", env)(), load("return x", "c", "b", env), load("return feder", "c", "t", {})())
    local parts, i = { "return ", "7" }, 0
    print(load(function() i = i + 1 return parts[i] end)())
  )") == "2\tnil\t[string \"syntax error here\"]:1: syntax error near 'error'\nnil\n5\tnil\tnil\n7\n");
}

TEST_CASE("finalizers, strings and protected tables", "[lua][sandbox]") {
  CHECK_THAT(error_of("setmetatable({}, { __gc = function() end })"),
             Catch::Contains("test.lua:1: setmetatable: __gc is not available"));
  CHECK_THAT(error_of("setmetatable(setmetatable({}, { __metatable = 1 }), {})"), Catch::Contains("protected"));
  CHECK(output_of("print(math.type(collectgarbage('count')), collectgarbage('count') > 0)") == "integer\ttrue\n");
}

TEST_CASE("no address is shown", "[lua][sandbox]") {
  CHECK(output_of(R"(
    local t, f = {}, function() end
    print(tostring(t), tostring(f), tostring(t), ("%s %s"):format(t, f), tostring(print) ~= tostring(pcall))
    print(tostring(coroutine.create(f)), feder.sphere(1), feder.buffer(2), setmetatable({}, { __tostring = function() return "mine" end }))
  )") == "table: #1\tfunction: #2\ttable: #1\ttable: #1 function: #2\ttrue\nthread: #5\tshape sphere\tbuffer of 2 "
         "numbers\tmine\n");
  CHECK_THAT(error_of("print(('%p'):format({}))"), Catch::Contains("'%p' is not available"));
}

TEST_CASE("pairs and next have one order", "[lua][sandbox]") {
  CHECK(output_of(R"(
    local b2, b1 = world:body{ name = "1", shape = feder.sphere(1) }, world:body{ name = "2", shape = feder.sphere(1), position = {5, 0, 0} }
    local t = { z = 1, a = 1, [3] = 1, [1] = 1, [2.5] = 1, [-1] = 1, [true] = 1, [false] = 1, [b1] = 1, [b2] = 1, aa = 1, [""] = 1 }
    local one, two = {}, {}
    for k in pairs(t) do one[#one + 1] = tostring(k) end
    local k
    repeat k = next(t, k) two[#two + 1] = k ~= nil and tostring(k) or nil until k == nil
    print(table.concat(one, " "))
    print(table.concat(one, " ") == table.concat(two, " "), next({}))
    for k in pairs(t) do t[k] = nil end
    print(next(t))
    for k, v in pairs(setmetatable({}, { __pairs = function() return function(_, i) i = (i or 0) + 1 if i < 3 then return i, i * i end end end })) do print(k, v) end
  )") == "-1 1 2.5 3  a aa z false true body \"1\" body \"2\"\ntrue\tnil\nnil\n1\t1\n2\t4\n");
}

TEST_CASE("sort is stable and random numbers repeat", "[lua][sandbox]") {
  CHECK(output_of(R"(
    local t = {}
    for i = 1, 1000 do t[i] = { key = i * 7919 % 10, place = i } end
    table.sort(t, function(x, y) return x.key < y.key end)
    local ok = true
    for i = 2, 1000 do ok = ok and (t[i-1].key < t[i].key or t[i-1].key == t[i].key and t[i-1].place < t[i].place) end
    print(ok)
    local u = { 3, 1, 2 } table.sort(u) print(table.concat(u, " "))
    print(pcall(table.sort, { 1, "a", 2 }))
  )") == "true\n1 2 3\nfalse\tattempt to compare string with number\n");
  const std::string roll =
      "print(math.random(), math.random(6), math.random(-5, 5), math.random(math.mininteger, math.maxinteger))";
  const std::string first = output_of(roll);
  CHECK(first == output_of(roll));
  lua::HostOptions other;
  other.has_seed = true, other.seed = 7;
  CHECK(first != output_of(roll, other));
  CHECK(output_of("math.randomseed(3) local a = math.random() math.randomseed(3) print(a == math.random())") ==
        "true\n");
  CHECK_THAT(error_of("math.random(2, 1)"), Catch::Contains("expected lo at most hi"));
}

TEST_CASE("random numbers have all the bits of a double", "[lua][sandbox]") {
  // or-ed together, enough draws show every bit below 1 that they can have
  CHECK(output_of("local bits = 0 for i = 1, 400 do local x = math.random() assert(x >= 0 and x < 1) "
                  "bits = bits | math.tointeger(x * 2^53) end print(string.format('%x', bits))") == "1fffffffffffff\n");
}

TEST_CASE("nothing outlives its instruction budget", "[lua][sandbox]") {
  const char* const attacks[] = {
      "while true do end",
      "while true do pcall(function() while true do end end) end",
      "while true do xpcall(function() while true do end end, function() while true do end end) end",
      "local co = coroutine.wrap(function() while true do pcall(function() while true do end end) end end) co()",
      "local co = coroutine.create(function() while true do end end) while true do coroutine.resume(co) end",
      "local co = coroutine.create(function() local x <close> = setmetatable({}, {__close = function() while true do "
      "end end}) coroutine.yield() end) "
      "coroutine.resume(co) while true do coroutine.close(co) end",
      "local t <close> = setmetatable({}, {__close = function() while true do end end}) while true do end",
      "local t = setmetatable({}, {}) getmetatable(t).__index = function(_, k) return t[k + 1] end while true do "
      "pcall(function() return t[1] end) end",
      "table.sort({3, 2, 1}, function() while true do end end)",
      "('x'):rep(100):gsub('.', function() while true do end end)",
      "for i = 1, 1e9 do table.move({}, 1, 4e7, 2) end",
      "local s = ('a'):rep(1e6) while true do s:upper() end",
      "while true do ('x'):rep(1e8) end",
      "('a'):rep(40):find(('a-'):rep(10) .. 'b')",
      "('a'):rep(3000):find('.-.-.-b')",
      "local t = {} for i = 1, 1e5 do t[i] = i end while true do for k in pairs(t) do break end end",
      "local t = {} for i = 1, 1e4 do t[i] = i end while true do next(t, 5000) end",
      "while true do load('return 1') end",
      "while true do print(('x'):rep(1000)) end",
      "local function f() return f() end f()",
      "world:task(function() while true do pcall(function() while true do end end) end end) world:step()",
      "world:on('step', function() while true do end end) while true do world:step() end",
      "world:every(0.01, function() while true do pcall(error) end end) while true do world:step() end",
      "world:body{ shape = feder.sphere(1) } world:force{ each = function() while true do end end } while true do "
      "world:step() end",
  };
  for (const char* attack : attacks) {
    lua::HostOptions limited;
    limited.instruction_limit = 1000000;
    const Ran ran = run(attack, limited);
    CAPTURE(attack, ran.error, ran.errors.size());
    const bool stopped = ran.error.find("instruction limit of 1000000 reached") != std::string::npos ||
                         ran.error.find("could take too long") != std::string::npos ||
                         ran.error.find("too long") != std::string::npos ||
                         (!ran.errors.empty() && ran.errors[0].message.find("instruction limit") != std::string::npos);
    CHECK(stopped);
    CHECK(ran.error.find('\n') == std::string::npos);
  }
}

TEST_CASE("each handler of a scene has its own budget, and the run goes on", "[lua][sandbox]") {
  lua::HostOptions limited;
  limited.instruction_limit = 100000;
  lua::Script script(limited);
  script.load_string(
      "local feder = require 'feder' return feder.scene{ build = function(w, s) s.n = 0 w:on('step', function() while "
      "true do end end)"
      " w:on('step', function() s.n = s.n + 1 end) end, check = function(w, s, expect) expect(s.n == 5, 'n is ' .. "
      "s.n) end }",
      "scene.lua");
  script.build();
  for (int i = 0; i < 5; ++i) script.step();
  REQUIRE(script.handler_errors().size() == 1);
  CHECK(script.handler_errors()[0].count == 5);
  CHECK(script.check().failures.empty());
}

TEST_CASE("memory is capped", "[lua][sandbox]") {
  lua::HostOptions small;
  small.memory_limit = 8 << 20;
  for (const char* attack : {"local t = {} while true do t[#t + 1] = ('x'):rep(1000) .. #t end",
                             "local s = 'x' while true do s = s .. s end", "feder.buffer(1e8)", "('x'):rep(1e8)",
                             "local t = {} for i = 1, 1e9 do t[i] = function() return i end end"}) {
    const Ran ran = run(attack, small);
    CAPTURE(attack);
    CHECK_THAT(ran.error, Catch::Contains("not enough memory"));
  }
}

TEST_CASE("deep recursion ends in an error", "[lua][sandbox]") {
  for (const char* attack :
       {"local function f() return 1 + f() end f()",
        "local t = setmetatable({}, {}) getmetatable(t).__index = t print(t.x)",
        "local s = ('('):rep(1e5) assert(load(s))", "local function f(x) return (x:gsub('.', f)) end f('x')",
        "local co = coroutine.wrap(function(f) return coroutine.wrap(f)(f) end) local function g() return "
        "coroutine.wrap(g)() end g()",
        "local e = setmetatable({}, { __tostring = function(s) return tostring(s) end }) print(e)"}) {
    const Ran ran = run(attack);
    CAPTURE(attack);
    CHECK(!ran.error.empty());
  }
}

TEST_CASE("terminal escapes do not reach the terminal", "[lua][sandbox]") {
  CHECK(output_of("print('\\27[31mred\\7', 1, nil, true)") == "?[31mred?\t1\tnil\ttrue\n");
}
