// Limits of a script: nothing it does hangs or floods the host, and nothing that it catches outlives a limit.
#include <ctime>
#include <thread>

#include "support/script.h"

using namespace feder;
using namespace feder::test;

namespace {

lua::HostOptions limited(std::uint64_t instructions) {
  lua::HostOptions o;
  o.instruction_limit = instructions;
  return o;
}

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

TEST_CASE("scripts have limits when the host says nothing", "[lua][limits]") {
  const lua::HostOptions options;
  CHECK(options.instruction_limit == 100000000);
  CHECK(options.memory_limit == std::size_t(1) << 30);
  const Ran ran = run("while true do end");
  CHECK(ran.error == "test.lua:1: instruction limit of 100000000 reached");
}

TEST_CASE("build may take four times as many instructions", "[lua][limits]") {
  lua::Script script(limited(100000));
  script.load_string(
      "return require('feder').scene{ build = function() for i = 1, 100000 do end end,\n"
      "update = function()\nwhile true do end end }",
      "scene.lua");
  script.build();
  script.step();
  REQUIRE(script.handler_errors().size() == 1);
  CHECK(script.handler_errors()[0].where == "scene.lua:3");
  CHECK(script.handler_errors()[0].limit == lua::Limit::instructions);
  lua::Script endless(limited(100000));
  endless.load_string("return require('feder').scene{ build = function() while true do end end }", "scene.lua");
  CHECK_THROWS_AS(endless.build(), lua::LimitError);
}

TEST_CASE("C functions that loop are charged", "[lua][limits]") {
  const char* const attacks[] = {
      "('('):rep(200000):match('%b()')",
      "local s = ('('):rep(5000) while true do s:find('%b()') end",
      "local s = ('a'):rep(100000) while true do s:find('%f[%d]') end",
      "('a'):rep(40):find(('a-'):rep(10) .. 'b')",
      "('a'):rep(3000):find('.-.-.-b')",
      "local s = ('a'):rep(30000) s:find(s .. 'b') while true do s:find(('a'):rep(10000) .. 'b', 1, true) end",
      "local s = ('a'):rep(100000) while true do for w in s:gmatch('a*b') do end end",
      "local s = ('a'):rep(100000) while true do s:gsub('a*b', '') end",
      "local function f() return xpcall(f, f) end while true do f() end",
      "local function f() return pcall(error) end while true do f() end",
      "local t = {} for i = 1, 1e4 do t[i] = 'x' end while true do table.concat(t) end",
      "local t = {} for i = 1, 1e4 do t[i] = i end while true do table.unpack(t) end",
      "local t = {} for i = 1, 1e4 do t[i] = i end while true do table.insert(t, 1, 0) table.remove(t, 1) end",
      "local t = {} for i = 1, 1e4 do t[i] = 1e4 - i end while true do table.sort(t) end",
      "table.concat(setmetatable({}, { __index = type }), '', 1, 4e7)",
      "local s = ('x'):rep(1e6) while true do local y = s .. 'a' end",
      "local s = ('x'):rep(1e6) while true do local y = ('%s'):format(s) end",
      "local s = ('x'):rep(1e6) while true do utf8.len(s) end",
      "local s = (' '):rep(1e6) while true do tonumber(s) end",
      "local s = (' '):rep(1e6) while true do string.packsize(s) end",
      "local t = {} for i = 1, 1e5 do t[i] = {} end while true do collectgarbage() end",
      "while true do world:step(1000000) end",
      "('x'):rep(1e8, ('y'):rep(1e8))",
      "(''):rep(1e15)",
  };
  for (const char* attack : attacks) {
    const double before = processor_seconds();
    const Ran ran = run(attack, limited(1000000));
    CAPTURE(attack, ran.error);
    const bool stopped = ran.error.find("instruction limit of 1000000 reached") != std::string::npos ||
                         ran.error.find("larger than 1 GB") != std::string::npos;
    CHECK(stopped);
    CHECK(ran.error.rfind("test.lua:1: ", 0) == 0);
    CHECK(processor_seconds() - before < 3);
  }
}

TEST_CASE("few instructions that take long end by their time", "[lua][limits]") {
  const Ran ran = run("local a = ('x'):rep(1e6) local b = a:sub(1, -2) .. 'x' while true do local c = a == b end",
                      limited(5000000));
  CHECK(ran.error == "test.lua:1: time limit reached: few instructions that take long");
}

TEST_CASE("no limit can be caught", "[lua][limits]") {
  const char* const attacks[] = {
      "while true do pcall(function() while true do end end) end",
      "local function g() local x <close> = setmetatable({}, { __close = function() error('other') end }) while true "
      "do end end "
      "while true do pcall(g) end",
      "local function g() local x <close> = setmetatable({}, { __close = function() error('other') end }) while true "
      "do end end "
      "local n = 0 while n < 1e9 do n = n + 1 pcall(pcall, g) xpcall(g, print) end",
      "while true do pcall(coroutine.wrap(function() while true do end end)) end",
      "while true do local co = coroutine.create(function() while true do end end) print(coroutine.resume(co)) end",
      "while true do local co = coroutine.wrap(function() local x <close> = setmetatable({}, { __close = function() "
      "error('z') end }) while true do end end) print(pcall(co)) end",
      "local f f = function() return xpcall(function() while true do end end, f) end while true do f() end",
  };
  for (const char* attack : attacks) {
    const Ran ran = run(std::string(attack) + " print('survived')", limited(100000));
    CAPTURE(attack, ran.output);
    CHECK(ran.error == "test.lua:1: instruction limit of 100000 reached");
    CHECK(ran.output == "");
  }
  lua::HostOptions small;
  small.memory_limit = 4 << 20;
  for (const char* attack : {"print(pcall(string.rep, 'x', 1e8))",
                             "print(coroutine.resume(coroutine.create(function() local t = {} while "
                             "true do t[#t + 1] = #t end end)))",
                             "print(xpcall(function() local s = 'x' while true do s = s .. s end end, print))"}) {
    const Ran ran = run(attack, small);
    CAPTURE(attack);
    CHECK(ran.error == "test.lua:1: not enough memory: the limit is 4194304 bytes");
    CHECK(ran.output == "");
  }
}

TEST_CASE("a script that ended at a limit can be called again", "[lua][limits]") {
  lua::Script script(limited(100000));
  script.load_string("function endless() while true do end end", "test.lua");
  CHECK_THROWS_AS(script.run_string("endless()"), lua::LimitError);
  CHECK(script.run_string("1 + 1") == "2");
}

TEST_CASE("print writes a bounded number of bytes", "[lua][limits]") {
  lua::HostOptions small;
  small.output_limit = 10000;
  const Ran ran = run("\nfor i = 1, 1000 do pcall(print, ('x'):rep(99)) end", small);
  CHECK(ran.error == "test.lua:2: output limit reached: print wrote more than 10000 bytes");
  CHECK(ran.output.size() == 10000);
}

TEST_CASE("a host stops a script from another thread", "[lua][limits]") {
  lua::Script script(limited(std::uint64_t(1) << 62));
  std::thread other([&script] {
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    script.interrupt();
  });
  try {
    script.load_string("while true do pcall(function() while true do end end) end", "test.lua");
    FAIL("it ended by itself");
  } catch (const lua::LimitError& e) {
    CHECK(e.limit() == lua::Limit::interrupted);
    CHECK(std::string(e.what()) == "test.lua:1: interrupted");
  }
  other.join();
  CHECK_THROWS_AS(script.run_string("1"), lua::LimitError);

  std::atomic<bool> stop = true;
  lua::HostOptions options;
  options.stop = &stop;
  lua::Script stopped(options);
  CHECK_THROWS_AS(stopped.load_string("x = 1", "test.lua"), lua::LimitError);
}

TEST_CASE("error objects say what their __tostring says", "[lua][limits]") {
  CHECK(error_of("error(setmetatable({}, { __tostring = function() return 'my text' end }))") == "test.lua:1: my text");
  CHECK(error_of("error({})") == "test.lua:1: error object is a table");
}
