// feder test: discovery, results, exit statuses and the formats.
#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

namespace {

void write_suite(const Program& p) {
  p.write("suite/good.lua", scene(kBall));
  p.write("suite/deep/also.lua", scene(kBall, "expect(true)\nexpect(1 < 2, 'numbers')"));
  p.write("suite/plain_test.lua",
          "local feder = require 'feder'\nlocal w = feder.world {}\nw:step(3)\nassert(w:step_count() == 3)\n");
  p.write("suite/module.lua", "error('a module is not run')\n");
  p.write("suite/materials/ice.yaml", "ice: { friction: 0.02 }\n");
}

}  // namespace

TEST_CASE("test runs scenes with a check and plain tests", "[cli][test]") {
  const Program p;
  write_suite(p);
  const Outcome o = p.run("test suite");
  CAPTURE(o.out, o.err);
  CHECK(o.status == 0);
  CHECK(last_line(o.out) == "3 passed, 0 failed, 0 skipped");
  CHECK(last_line(p.run("test suite --filter deep").out) == "1 passed, 0 failed, 0 skipped");
  CHECK(last_line(p.run("test suite/good.lua --quiet").out) == "1 passed, 0 failed, 0 skipped");
}

TEST_CASE("test counts failures, load errors and scenes without a check", "[cli][test]") {
  const Program p;
  write_suite(p);
  p.write("suite/no_check.lua",
          "local feder = require 'feder'\nreturn feder.scene { seconds = 0.1, build = function() end }\n");
  CHECK(last_line(p.run("test suite").out) == "3 passed, 0 failed, 1 skipped");
  CHECK(p.run("test suite").status == 0);

  p.write("suite/false_test.lua", "assert(false, 'not true')\n");
  p.write("suite/handler.lua", scene("world:after(0.1, function() error('late') end)"));
  p.write("suite/wrong.lua", scene(kBall, "expect(false, 'wrong <&> \"quoted\"')"));
  const Outcome o = p.run("test suite");
  CAPTURE(o.out);
  CHECK(o.status == 1);
  CHECK(last_line(o.out) == "3 passed, 3 failed, 1 skipped");
  CHECK(o.out.find("suite/wrong.lua:8: wrong <&>") != std::string::npos);
  CHECK(o.out.find("suite/handler.lua:5: late") != std::string::npos);

  p.write("suite/syntax_test.lua", "local = 3\n");
  CHECK(p.run("test suite").status == 3);
  CHECK(last_line(p.run("test suite").out) == "3 passed, 4 failed, 1 skipped");
}

TEST_CASE("what needs a module that the build leaves out is skipped, and says why", "[cli][test]") {
  const Program p;
  p.write("lacks_test.lua", "require 'feder.view'\nerror('never')\n");
  const Outcome o = p.run("test lacks_test.lua");
  CHECK(o.status == 5);
  CHECK(o.out.find("lacks_test.lua (this build leaves out the module 'feder.view')\n0 passed, 0 failed, 1 skipped") !=
        std::string::npos);
}

TEST_CASE("scenes in YAML have checks too", "[cli][test]") {
  const Program p;
  p.write("scene.yaml",
          "bodies:\n  - { name: a, shape: { sphere: 1 } }\nseconds: 0.1\ncheck: |\n  expect(world:find('a'))\n  "
          "expect(world:find('b'), 'no b')\n");
  const Outcome o = p.run("test scene.yaml");
  CAPTURE(o.out);
  CHECK(o.status == 1);
  CHECK(o.out.find("scene.yaml:6: no b\n") != std::string::npos);
  p.write("line.yaml", "seconds: 0.1\nbodies: [{ shape: { sphere: 1 } }]\ncheck: expect(false, 'one line')\n");
  CHECK(p.run("test line.yaml").out.find("line.yaml:3: one line\n") != std::string::npos);
  p.write("data.yaml", "seconds: 0.1\nbodies: [{ shape: { sphere: 1 } }]\n");
  CHECK(last_line(p.run("test data.yaml").out) == "0 passed, 0 failed, 1 skipped");
}

TEST_CASE("test says when nothing ran", "[cli][test]") {
  const Program p;
  p.write("empty/readme.txt", "nothing\n");
  const Outcome o = p.run("test empty");
  CHECK(o.status == 5);
  CHECK(last_line(o.out) == "0 passed, 0 failed, 0 skipped");
  CHECK(p.run("test nowhere").status == 2);
}

TEST_CASE("test writes JUnit, TAP and JSON", "[cli][test]") {
  const Program p;
  write_suite(p);
  p.write("suite/wrong.lua",
          scene("print('\\1 <tag>') " + std::string(kBall), "expect(false, 'wrong <&> \"quoted\"')"));
  CHECK(p.run("test suite --junit out.xml").status == 1);
  p.write("parse.py",
          "import xml.etree.ElementTree as x\ns = x.parse('out.xml').getroot().find('testsuite')\n"
          "f = [c for c in s.iter('testcase') if c.find('failure') is not None]\n"
          "print(s.get('tests'), s.get('failures'), f[0].find('failure').get('message'), f[0].get('line'))\n");
  const Outcome parsed = p.shell("python3 parse.py");
  CHECK(parsed.status == 0);
  CHECK(parsed.out == "4 1 wrong <&> \"quoted\" 8\n");

  const Outcome tap = p.run("test suite --tap");
  CHECK(tap.out.find("TAP version 13\n1..4\n") == 0);
  CHECK(tap.out.find("not ok 4 - suite/wrong.lua\n") != std::string::npos);
  CHECK(last_line(tap.out) == "# 3 passed, 1 failed, 0 skipped");

  const auto j = p.run("test suite --json").json();
  CHECK(j["passed"] == 3);
  CHECK(j["failed"] == 1);
  CHECK(j["tests"].size() == 4);
}
