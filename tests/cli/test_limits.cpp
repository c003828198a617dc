// Runs that would not end: limits of every command, exit statuses, signals.
#include <functional>
#include <new>
#include <regex>

#include "cli/app.h"
#include "cli/command.h"
#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

namespace {

const char* const kEndless = "while true do end";

// A scene whose update or study never ends.
std::string with(const std::string& key, const std::string& value) {
  return "local feder = require 'feder'\nreturn feder.scene {\n  title = 'Probe', seconds = 0.1,\n  build = "
         "function(world) "
         "world:body { shape = feder.sphere(0.5) } end,\n" +
         key + " = " + value + ",\n  check = function(world, scene, expect) expect(true) end }\n";
}

}  // namespace

TEST_CASE("a script that never ends ends with status 4 in every command", "[cli][limits]") {
  const Program p;
  p.write("load.lua", "-- line 1\nwhile true do end\n");
  p.write("build.lua", scene(kEndless));
  p.write("check.lua", scene(kBall, kEndless));
  p.write("update.lua", with("update", "function()\nwhile true do end end"));
  p.write("study.lua", with("study", "{ error = function()\nwhile true do end end, axes = { dt = { 1/60 } } }"));
  const std::string limit = " --limit 1e5";
  const auto ends = [&](const std::string& arguments, const std::string& place) {
    const Outcome o = p.run(arguments + limit);
    CAPTURE(arguments, o.out, o.err);
    CHECK(o.status == 4);
    CHECK(says(o.err + o.out, place + ": instruction limit of "));
  };
  for (const std::string command : {"run ", "test ", "bench --runs 1 --steps 2 ", "explain ", "study --repeat 0 "}) {
    ends(command + "load.lua", "load.lua:2");
    ends(command + "build.lua", "build.lua:5");
    ends(command + "update.lua", "update.lua:6");
  }
  ends("run --check check.lua", "check.lua:8");
  ends("test check.lua", "check.lua:8");
  ends("study --repeat 0 study.lua", "study.lua:6");
  const Outcome drawn = p.run("render -o out.png update.lua" + limit);
  if (says(p.run("--help").out, "render") && !says(drawn.err, "OpenGL"))
    ends("render -o out.png update.lua", "update.lua:6");
}

TEST_CASE("the limits need no option, and the summary is not lost", "[cli][limits]") {
  const Program p;
  p.write("update.lua", with("update", "function()\nwhile true do end end"));
  const Outcome o = p.run("run update.lua");
  CAPTURE(o.out, o.err);
  CHECK(o.status == 4);
  CHECK(says(o.err, "update.lua:6: instruction limit of 100000000 reached; --limit N allows more"));
  CHECK(says(o.out, "hash"));
  CHECK(says(o.out, "1 steps"));
  p.write("plain.lua", "local feder = require 'feder'\nlocal w = feder.world {}\nw:step(5)\nwhile true do end\n");
  const Outcome plain = p.run("run plain.lua --json --limit 1e5");
  CAPTURE(plain.err);
  CHECK(plain.status == 4);
  CHECK(plain.json()["steps"] == 5);
  CHECK(plain.json()["interrupted"] == true);
}

TEST_CASE("memory and processor time have limits", "[cli][limits]") {
  const Program p;
  p.write("memory.lua", "local t = {}\nwhile true do t[#t + 1] = ('x'):rep(1000) .. #t end\n");
  const Outcome memory = p.run("run memory.lua --memory 8e6");
  CAPTURE(memory.err);
  CHECK(memory.status == 4);
  CHECK(says(memory.err, "memory.lua:2: not enough memory"));
  CHECK(p.run("run memory.lua --memory 10").status == 4);
  p.write("endless.lua", kEndless);
  p.write("good_test.lua", "assert(true)");
  p.write("endless_test.lua", kEndless);
  const Outcome time = p.run("run endless.lua --limit 0 --timeout 0.3");
  CAPTURE(time.err);
  CHECK(time.status == 4);
  CHECK(says(time.err, "endless.lua:1: time limit of 0.3 s of processor time reached"));
  const Outcome test = p.run("test endless_test.lua good_test.lua --limit 0 --timeout 0.3");
  CAPTURE(test.out);
  CHECK(test.status == 4);
  CHECK(says(test.out, "endless_test.lua:1: time limit of 0.3 s"));
  CHECK(last_line(test.out) == "1 passed, 1 failed, 0 skipped");
  for (const char* wrong : {"--limit x", "--memory -1", "--timeout soon"})
    CHECK(p.run(std::string("run good_test.lua ") + wrong).status == 2);
}

TEST_CASE("one signal ends a run, its summary is kept", "[cli][limits]") {
  const Program p;
  p.write("update.lua", with("update", "function()\nprint 'ready' while true do end end"));
  p.write("plain.lua", "local w = require('feder').world {} w:step(2)\nprint 'ready' while true do end\n");
  for (const auto& [signal, status] : {std::pair{"INT", 130}, {"TERM", 143}}) {
    for (const std::string file : {"update.lua", "plain.lua"}) {
      const Outcome o =
          p.shell("{ '" FEDER_BINARY_DIR "/feder' run " + file +
                  " --limit 0 --json & pid=$!; for i in $(seq 200); do grep -q ready .err && break; sleep 0.1; "
                  "done; kill -" +
                  signal + " $pid; wait $pid; }");
      CAPTURE(signal, file, o.err, o.out);
      CHECK(o.status == status);
      CHECK(o.json()["interrupted"] == true);
      CHECK(says(o.err, ": interrupted"));
    }
  }
}

TEST_CASE("statuses and messages of wrong words and files", "[cli][limits]") {
  const Program p;
  p.write("scene.lua", "local n = require('feder').param('n', 3, { max = 5 })\n" + scene(kBall));
  p.write("plain.lua", "local w = require('feder').world {} w:step(2)\n");
  for (const std::string wrong :
       {"--set m=1", "--set n=9", "--set n=x", "--world bogus=1", "--world rigid.solver=bogus", "--world dt=-1",
        "--dt 7", "--seconds 1e30", "--seconds 1e300"}) {
    for (const std::string file : {"scene.lua", "plain.lua"}) {
      if (file == "plain.lua" && (wrong.find("n=") != std::string::npos || wrong.find("seconds") != std::string::npos))
        continue;
      const Outcome o = p.run("run " + file + " " + wrong);
      CAPTURE(wrong, file, o.err);
      CHECK(o.status == 2);
      CHECK(count_lines(o.err) == 1);
    }
  }
  for (const char* device : {"/dev/full", "/dev/zero", "/dev/null"}) {
    const Outcome o = p.run(std::string("run ") + device);
    CHECK(o.status == 3);
    CHECK(o.err == std::string(device) + ": expected a scene, got a device or a pipe\n");
  }
}

TEST_CASE("an error of the program itself ends with status 70", "[cli][limits]") {
  // what it is told apart by
  const auto status_of = [](const auto& thrown) {
    try {
      throw thrown;
    } catch (...) {
      return feder::cli::print_exception();
    }
  };
  CHECK(status_of(std::out_of_range("vector::at")) == 70);
  CHECK(status_of(std::bad_function_call()) == 70);
  CHECK(status_of(3) == 70);
  CHECK(status_of(std::runtime_error("file: cannot be written")) == 1);
  CHECK(status_of(std::bad_alloc()) == 1);
  CHECK(status_of(feder::cli::Failure(5, "nothing ran")) == 5);
  // a runner that cannot start its child: there is no descriptor left for the pipe, and one, for the loader, until then
  const Program p;
  p.write("a_test.lua", "assert(true)");
  const Outcome o = p.shell("(exec 3>&- 4>&- 5>&- 6>&- 7>&- 8>&- 9>&-; ulimit -n 4; '" FEDER_BINARY_DIR
                            "/feder' test --isolate a_test.lua)");
  CAPTURE(o.err);
  CHECK(o.status == 70);
  CHECK(says(o.err, "feder test: no pipe: "));
  CHECK(says(p.run("--help").out, "70 internal error"));
  CHECK(says(p.run("doc --man").out, "70 internal error"));
}

TEST_CASE("a state that was not finite on the way fails a run", "[cli][limits]") {
  const Program p;
  // the sum of two finite forces is not finite; the body is held and the state is finite again
  p.write("wild.lua", scene("local b = world:body { shape = feder.sphere(0.5), density = 1e-8 }\nfor i = 1, 100 do "
                            "b:apply_force(1e30, 0, 0) end"));
  const Outcome o = p.run("run wild.lua --json");
  CAPTURE(o.out, o.err);
  const auto json = o.json();
  bool warned = false;
  for (const auto& w : json["warnings"]) warned = warned || w["code"] == "non_finite";
  REQUIRE(warned);
  CHECK(json["finite"] == true);
  CHECK(o.status == 1);
  CHECK(says(o.err, "not finite"));
}

TEST_CASE("isolated tests give the results of tests in one process", "[cli][limits]") {
  const Program p;
  p.write("a_test.lua", "print('said') assert(true)");
  p.write("b_test.lua", "\nerror('wrong')");
  p.write("c.lua", scene(kBall));
  p.write("d.lua", "x = = 1");
  for (const std::string format : {"--json", "--tap", "--junit out.xml"}) {
    const auto plain = [&](const std::string& how) {
      const Outcome o = p.run("test a_test.lua b_test.lua c.lua d.lua " + format + " " + how);
      std::string text = std::to_string(o.status) + "\n" + (format == "--junit out.xml" ? p.read("out.xml") : o.out);
      text = std::regex_replace(text, std::regex(R"(((seconds": |time="))[0-9.e-]+)"), "$1");  // times differ
      return text;
    };
    CHECK(plain("--isolate") == plain("--no-isolate"));
    CHECK(plain("--isolate").find("wrong") != std::string::npos);
  }
}

TEST_CASE("a crash is one failed test by name, and the rest goes on", "[cli][limits]") {
  const Program p;
  p.write("a_test.lua", "assert(true)");
  p.write("b_test.lua", kEndless);
  p.write("c_test.lua", "assert(true)");
  // a sanitized program must die of a signal, too
  const std::string program = "ASAN_OPTIONS=$ASAN_OPTIONS:handle_segv=0 '" FEDER_BINARY_DIR "/feder'";
  // the child is killed as soon as the first result is there: it runs the endless test then
  const Outcome o =
      p.shell("{ " + program +
              " test --isolate --junit out.xml --limit 0 a_test.lua b_test.lua c_test.lua >text & pid=$!\n"
              "for i in $(seq 300); do grep -q a_test.lua text && break; sleep 0.1; done; sleep 0.2\n"
              "child=$(cat /proc/$pid/task/$pid/children); kill -SEGV $child; wait $pid; }");
  const std::string text = p.read("text");
  CAPTURE(text, o.err);
  CHECK(o.status == 1);
  CHECK(says(text, "b_test.lua: the process was killed by signal 11"));
  CHECK(says(text, "2 passed, 1 failed, 0 skipped"));
  CHECK(says(p.read("out.xml"), "killed by signal 11"));
  // CI isolates by itself; an interrupted run says what it has and leaves no child
  const Outcome stopped =
      p.shell("{ CI=1 " + program +
              " test --limit 0 a_test.lua b_test.lua c_test.lua >text & pid=$!\n"
              "for i in $(seq 300); do grep -q a_test.lua text && break; sleep 0.1; done; sleep 0.2\n"
              "kill -TERM $pid; wait $pid; s=$?; cat text; pgrep -f 'worke[r].*b_test' | while read c; do [ "
              "\"$(readlink /proc/$c/cwd)\" = \"$PWD\" ] && echo left $c; done; (exit $s); }");
  CAPTURE(stopped.out, stopped.err);
  CHECK(stopped.status == 143);
  CHECK(says(stopped.out, "1 passed"));
  CHECK(!says(stopped.out, "left"));
}
