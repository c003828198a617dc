// feder test: what a failure says and leaves: numbers, lines, formats, colour, pictures, coverage, golden runs.
#include <regex>

#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

namespace {

const std::string kWrong =
    scene(kBall, "expect(true)\nexpect.near(scene.ball, { 0, 3, 0 }, 0.5)\nexpect(1 > 2, '50% <&>: a, b')");

// A falling box; `height` is where it starts.
std::string golden_scene(const std::string& height, const std::string& golden) {
  return "local feder = require 'feder'\nlocal push = feder.param('push', 0)\nreturn feder.scene { seconds = 1, golden "
         "= " +
         golden +
         ",\nbuild = function(world) world:body { name = 'box', shape = feder.box(1, 1, 1), position = { push, " +
         height + ", 0 } } end }\n";
}

}  // namespace

TEST_CASE("a failure says time, step, object, expected, actual, tolerance and the line", "[cli][runner]") {
  const Program p;
  p.write("wrong.lua", kWrong);
  const Outcome o = p.run("test wrong.lua");
  CAPTURE(o.out);
  CHECK(o.status == 1);
  CHECK(says(o.out, "wrong.lua:9: body \"ball\": expected at (0, 3, 0), got (0, 1.7"));
  CHECK(says(o.out, "\n  > expect.near(scene.ball, { 0, 3, 0 }, 0.5)\n    ^" + std::string(40, '~') + "\n"));
  CHECK(says(o.out, "\n  at 0.5 s, step 30, tolerance 0.5 m\n"));
  const auto failure = p.run("test wrong.lua --json").json()["tests"][0]["failures"][0];
  CHECK(failure["step"] == 30);
  CHECK(failure["object"] == "body \"ball\"");
  CHECK(failure["expected"] == "at (0, 3, 0)");
  CHECK(failure["tolerance"] == "0.5 m");
  CHECK(says(failure["actual"], "(0, 1.7"));
  CHECK(std::string(failure["delta"]).starts_with("1.2"));
  CHECK(failure["source"] == "expect.near(scene.ball, { 0, 3, 0 }, 0.5)");
}

TEST_CASE("the call that failed has a caret below it", "[cli][runner]") {
  // each line of a check, and what is below it
  const std::pair<std::string, std::string> rows[] = {
      {"if true then expect(1 > 2) end", "             ^~~~~~~~~~~~~"},
      {"local n, e = 'expect(1)', expect; e(n == '')", "                                  ^~~~~~~~~~"},
      {"expect.error(1, '<', (0))  -- expect.error()", "^~~~~~~~~~~~~~~~~~~~~~~~~"},
      {"expect.near(1,", "^~~~~~~~~~~~~~"},
      {"  2, 0)", ""},
      // Lua says no column: it may be either
      {"expect(1 > 2) expect(1)", "^~~~~~~~~~~~~ ^~~~~~~~~"},
      {"expect.events('hit', -1)", "^~~~~~~~~~~~~~~~~~~~~~~~"},
  };
  std::string check;
  for (const auto& [line, marks] : rows) check += line + "\n";
  const Program p;
  p.write("wrong.lua", scene(kBall, check));
  const Outcome o = p.run("test wrong.lua");
  CAPTURE(o.out);
  for (const auto& [line, marks] : rows) {
    CAPTURE(line);
    const std::string source = line.substr(line.find_first_not_of(' '));
    CHECK(says(o.out, "  > " + source + "\n    " + marks + "\n") == !marks.empty());
  }
}

TEST_CASE("a suite with an endless and a crashing script reports both and runs the rest", "[cli][runner]") {
  const Program p;
  p.write("s/a_test.lua", "assert(true)");
  p.write("s/b_crash_test.lua", "while true do end");
  p.write("s/c_endless_test.lua", "while true do end");
  p.write("s/d.lua", scene(kBall));
  // the child that runs b is killed as soon as a has its result; c ends by its own time
  const Outcome o = p.shell("{ ASAN_OPTIONS=$ASAN_OPTIONS:handle_segv=0 '" FEDER_BINARY_DIR
                            "/feder' test s --isolate --limit 0 --timeout 2 --tap --format junit=out.xml --format "
                            "json=out.json >text & pid=$!\n"
                            "for i in $(seq 300); do grep -q 'ok 1' text && break; sleep 0.05; done; sleep 0.1\n"
                            "kill -SEGV $(cat /proc/$pid/task/$pid/children); wait $pid; }");
  const std::string text = p.read("text");
  CAPTURE(text, o.err);
  CHECK(o.status == 4);
  CHECK(says(text, "not ok 2 - s/b_crash_test.lua\n# the process was killed by signal 11"));
  CHECK(says(text, "not ok 3 - s/c_endless_test.lua\n# s/c_endless_test.lua:1: time limit of 2 s"));
  CHECK(says(text, "ok 4 - s/d.lua\n"));
  CHECK(last_line(text) == "# 2 passed, 2 failed, 0 skipped");
  CHECK(says(p.read("out.xml"), "tests=\"4\" failures=\"2\""));
  CHECK(nlohmann::json::parse(p.read("out.json"))["failed"] == 2);
  // in one process nothing is left of a crash; the endless one ends by its own limit there too
  p.shell("rm s/b_crash_test.lua");
  const Outcome one = p.run("test s --no-isolate --limit 1e6");
  CAPTURE(one.out);
  CHECK(one.status == 4);
  CHECK(says(one.out, "s/c_endless_test.lua:1: instruction limit of 1000000 reached"));
  CHECK(last_line(one.out) == "2 passed, 1 failed, 0 skipped");
}

TEST_CASE("tests share nothing, and each has the memory that is allowed", "[cli][runner]") {
  const Program p;
  p.write("a_test.lua", "left, math.left = 1, 2 require('part').n = 3 require('feder').world {} string.format = nil");
  p.write("b_test.lua", "assert(not left and not math.left and string.format and require('part').n == 1)");
  p.write("part.lua", "return { n = 1 }");
  p.write("c_test.lua", "local t = {} for i = 1, 1e5 do t[i] = { i } end");
  p.write("d_test.lua", "assert(true)");
  for (const std::string how : {" --no-isolate", " --isolate"}) {
    CHECK(p.run("test a_test.lua c_test.lua d_test.lua" + how).status == 0);
    const Outcome o = p.run("test a_test.lua b_test.lua c_test.lua d_test.lua --memory 3e6" + how);
    CAPTURE(o.out);
    CHECK(o.status == 4);
    CHECK(says(o.out, "c_test.lua:1: not enough memory"));
    CHECK(last_line(o.out) == "3 passed, 1 failed, 0 skipped");
  }
}

TEST_CASE("plain tests expect too, and a run fails by them", "[cli][runner]") {
  const Program p;
  p.write(
      "plain_test.lua",
      "local feder = require 'feder'\nlocal w = feder.world {}\nlocal b = w:body { name = 'b', shape = feder.sphere(1) "
      "}\nfeder.expect.near(b, { 0, 5, 0 }, 0.5)\nfeder.expect(w:time() == 0)\nprint('went on')\n");
  const Outcome o = p.run("test plain_test.lua");
  CAPTURE(o.out);
  CHECK(o.status == 1);
  CHECK(says(o.out, "plain_test.lua:4: body \"b\": expected at (0, 5, 0), got (0, 0, 0), 5 m away\n"));
  CHECK(says(o.out, "went on"));
  CHECK(p.run("test plain_test.lua --json").json()["tests"][0]["checks"] == 1);
  const Outcome run = p.run("run plain_test.lua");
  CHECK(run.status == 1);
  CHECK(says(run.err, "plain_test.lua:4: body \"b\": expected at"));
}

TEST_CASE("several formats at once, and annotations of GitHub", "[cli][runner]") {
  const Program p;
  p.write("wrong.lua", kWrong);
  p.write("good.lua", scene(kBall, "expect(true)\nexpect.budget { ms = 1e-9 }"));
  const Outcome o = p.run("test good.lua wrong.lua --format github --format tap=out.tap --junit out.xml");
  CAPTURE(o.out, o.err);
  CHECK(says(o.out, "::error file=wrong.lua,line=10,title=wrong.lua::50%25 <&>: a, b%0A> expect(1 > 2"));
  CHECK(says(o.out, "::warning file=good.lua,line=9,title=good.lua::step: expected at most 1e-09 ms, got "));
  CHECK(last_line(o.out) == "1 passed, 1 failed, 0 skipped");
  CHECK(p.read("out.tap").starts_with("TAP version 13\n1..2\nok 1 - good.lua\nnot ok 2 - wrong.lua\n"));
  CHECK(says(p.read("out.xml"), "step 30, tolerance 0.5 m"));
  CHECK(p.run("test good.lua --format json --output out.json").status == 0);
  CHECK(nlohmann::json::parse(p.read("out.json"))["passed"] == 1);
  CHECK(p.run("test good.lua --tap --json").status == 2);
  CHECK(p.run("test good.lua --format junti").status == 2);
  CHECK(p.run("test good.lua --output x").status == 2);
  CHECK(p.run("test good.lua --format tap=/nowhere/x").status == 2);
}

TEST_CASE("TAP comes test by test", "[cli][runner]") {
  const Program p;
  p.write("a_test.lua", "assert(true)");
  p.write("b_test.lua", "while true do end");
  const Outcome o = p.shell("{ '" FEDER_BINARY_DIR
                            "/feder' test --no-isolate --tap --limit 0 a_test.lua b_test.lua >text & pid=$!\n"
                            "for i in $(seq 200); do grep -q 'ok 1' text && break; sleep 0.05; done; cp text early\n"
                            "kill -TERM $pid; wait $pid; }");
  CHECK(p.read("early").starts_with("TAP version 13\n1..2\nok 1 - a_test.lua\n"));
  CHECK(o.status == 143);
}

TEST_CASE("colour on a terminal, none elsewhere and none with NO_COLOR", "[cli][runner]") {
  const Program p;
  p.write("good.lua", scene(kBall));
  p.write("wrong.lua", kWrong);
  p.write(
      "terminal.py",
      "import os, pty, sys\nout = b''\npid, fd = pty.fork()\n"
      "if pid == 0: os.execv(sys.argv[1], ['feder', 'test', 'good.lua', 'wrong.lua'])\n"
      "while True:\n    try: more = os.read(fd, 65536)\n    except OSError: break\n    if not more: break\n    out += "
      "more\nos.write(1, out)\n");
  const std::string run = "python3 terminal.py '" FEDER_BINARY_DIR "/feder'";
  const std::string colored = p.shell("unset NO_COLOR; TERM=xterm " + run).out;
  CAPTURE(colored);
  CHECK(says(colored, "\033[32mok  \033[0m"));
  CHECK(says(colored, "\033[31mFAIL\033[0m"));
  CHECK(!says(p.shell("NO_COLOR=1 TERM=xterm " + run).out, "\033["));
  CHECK(says(p.shell("NO_COLOR=1 TERM=xterm " + run).out, "FAIL"));
  CHECK(!says(p.shell("TERM=dumb " + run).out, "\033["));
  CHECK(!says(p.run("test wrong.lua").out, "\033["));
}

TEST_CASE("a failed test leaves its messages, events and a picture of the last frame", "[cli][runner]") {
  const Program p;
  p.write("good.lua", scene(kBall));
  p.write("d/wrong.lua", scene("world:body { type = 'static', shape = feder.plane() } " + std::string(kBall),
                               "print('said') expect.near(scene.ball, { 0, 0, 0 }, 0.1, 1)"));
  for (const std::string how : {" --no-isolate", " --isolate"}) {
    p.shell("rm -rf left");
    const Outcome o = p.run("test good.lua d/wrong.lua --artifacts left" + how);
    CAPTURE(o.out, o.err);
    CHECK(says(o.out, "d/wrong.lua (left left/d_wrong.lua.txt"));
    const std::string text = p.read("left/d_wrong.lua.txt");
    CAPTURE(text);
    CHECK(says(text, "d/wrong.lua:8: body \"ball\": expected at (0, 0, 0) within 1 s, got (0, 0.49"));
    CHECK(says(text, "again: feder test d/wrong.lua\n--- printed\nsaid\n--- last events\n"));
    CHECK(std::regex_search(text, std::regex("\nstep [0-9]+  0\\.[0-9]+ s  contact_begin  body .*  body \"ball\"\n")));
    CHECK(std::regex_search(text, std::regex("  hit  body .*  body \"ball\"  [0-9.]+ m/s  [0-9.e+]+ N s\n")));
    CHECK(p.read("left/good.lua.txt").empty());
    if (says(p.run("--help").out, "render") && !says(o.err, "OpenGL"))
      CHECK(p.read("left/d_wrong.lua.png").starts_with("\x89PNG"));
  }
}

TEST_CASE("line coverage is written as LCOV", "[cli][runner]") {
  const Program p;
  p.write("part.lua",
          "local m = {}\nfunction m.used() return 1 end\nfunction m.unused(x)\n  if x then\n    return 2\n  "
          "end\nend\nreturn m\n");
  p.write("a_test.lua", "local m = require 'part'\nassert(m.used() == 1)\n");
  p.write("b_test.lua", "local m = require 'part'\nassert(m.used() == 1)\n");
  for (const std::string how : {" --no-isolate", " --isolate"}) {
    CHECK(p.run("test a_test.lua b_test.lua --coverage cov.info" + how).status == 0);
    const std::string text = p.read("cov.info");
    CAPTURE(text);
    CHECK(says(text, "part.lua\nDA:1,2\nDA:2,"));
    CHECK(says(text, "DA:4,0\nDA:5,0\nDA:7,2\nDA:8,2\nLF:7\nLH:5\nend_of_record\n"));
    CHECK(says(text, "SF:a_test.lua\nDA:1,1\nDA:2,1\n"));
  }
}

TEST_CASE("golden runs are written when asked, and compared by tolerances", "[cli][runner]") {
  const Program p;
  const std::string by_hand = "unset CI; '" FEDER_BINARY_DIR "/feder' test box.lua ";
  p.write("box.lua", golden_scene("2", "true"));
  CHECK(says(p.run("test box.lua").out, "box.lua: no golden run box.golden.json; --update-golden writes it\n"));
  CHECK(p.shell("CI=true '" FEDER_BINARY_DIR "/feder' test box.lua --update-golden").status == 2);
  CHECK(p.read("box.golden.json").empty());
  CHECK(says(p.shell(by_hand + "--update-golden").out, "box.golden.json written"));
  const std::string golden = p.read("box.golden.json");
  CHECK(p.run("test box.lua").status == 0);
  // nothing to write anew
  CHECK(!says(p.shell(by_hand + "--update-golden").out, "written"));

  p.write("box.lua", golden_scene("2.01", "true"));
  const Outcome o = p.run("test box.lua");
  CAPTURE(o.out);
  CHECK(o.status == 1);
  CHECK(says(o.out,
             "not as in the golden run: position of body \"box\" is 0.01 m off from 0 s on; the states part at "
             "step 0\n"));
  CHECK(says(o.out, "expected (0, 2, 0), got (0, 2.01, 0), tolerance 0.001 m"));
  CHECK(std::regex_search(o.out, std::regex("position +0\\.01 +0\\.001 ")));
  // a tolerance per quantity
  p.write("box.lua", golden_scene("2.01", "{ position = 0.02, energy = 0.5 }"));
  CHECK(p.run("test box.lua").status == 0);
  p.write("box.lua", golden_scene("2.01", "{ position = 0.02, energy = 1e-6 }"));
  CHECK(says(p.run("test box.lua").out, "potential energy is"));
  // falling, it is 2.6 m away by 0.75 s
  const std::string pushed = "world:after(0.3, function() world:find('box'):set_velocity(0, -3, 0) end) ";
  const auto with_push = [&](const std::string& golden_table) {
    std::string text = golden_scene("2", golden_table);
    text.insert(text.rfind("end }"), pushed);
    p.write("box.lua", text);
    return p.run("test box.lua").out;
  };
  CHECK(says(with_push("{ position = 0.001, energy = 1 }"), " m off from 0.5 s on; the states part at step 18\n"));
  CHECK(says(with_push("{ position = 0.001, energy = 1, relative = 0.001 }"), "tolerance 0.002"));
  CHECK(says(with_push("{ position = 0.001, energy = 1, relative = 0.5 }"), "ok "));
  p.write("box.lua", golden_scene("2.01", "{ position = 0.02, energy = 1e-6 }"));
  // other values are another run
  CHECK(p.run("test box.lua --set push=1").status == 5);
  CHECK(says(p.shell(by_hand + "--update-golden").out, "potential energy"));
  CHECK(p.read("box.golden.json") != golden);
  CHECK(p.run("test box.lua").status == 0);
  p.write("box.golden.json", golden.substr(0, golden.size() / 2));
  CHECK(says(p.run("test box.lua").out, "box.golden.json: no golden run"));
}
