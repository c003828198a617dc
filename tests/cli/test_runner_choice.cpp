// feder test: which tests run, in which order, how often, and what is printed of them.
#include <regex>
#include <set>
#include <sstream>

#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

// Ten tests that pass; the even ones are tagged.
void write_ten(const Program& p) {
  for (int i = 0; i < 10; ++i)
    p.write("t/n" + std::to_string(i) + "_test.lua",
            (i % 2 == 0 ? "-- even\n-- tags: even, quick\n" : "-- odd\n") + std::string("assert(true)\n"));
}

const std::string kHigh =
    "local feder = require 'feder'\nlocal n = feder.param('n', 2, { min = 1, max = 50 })\nlocal kind = "
    "feder.param('kind', 'box', { choices = { 'box', 'ball' } })\nreturn feder.scene { seconds = 0.1, random = 12,\n"
    "build = function(world) for i = 1, n do world:body { shape = feder.box(1, 1, 1), position = { 2 * i, 0, 0 } } "
    "end end,\ncheck = function(world, scene, expect)\nexpect(n < 17 or kind == 'ball', 'too many')\nend }\n";

}  // namespace

TEST_CASE("test lists what would run, by filter, tag and share", "[cli][runner]") {
  const Program p;
  write_ten(p);
  CHECK(lines_of(p.run("test t --list").out).size() == 10);
  CHECK(lines_of(p.run("test t --list").out)[0] == "t/n0_test.lua  even quick");
  CHECK(lines_of(p.run("test t --list --tag even").out).size() == 5);
  CHECK(lines_of(p.run("test t --list --tag even --tag ~quick").out).empty());
  CHECK(lines_of(p.run("test t --list --tag ~even").out).size() == 5);
  CHECK(p.run("test t --list --filter n3 --json").json()[0]["file"] == "t/n3_test.lua");
  CHECK(last_line(p.run("test t --tag even").out) == "5 passed, 0 failed, 0 skipped");
  // the shares are all of it, each once
  std::multiset<std::string> seen;
  for (int i = 1; i <= 3; ++i)
    for (const std::string& line : lines_of(p.run("test t --list --shard " + std::to_string(i) + "/3").out))
      seen.insert(line);
  CHECK(seen.size() == 10);
  CHECK(std::set<std::string>(seen.begin(), seen.end()).size() == 10);
  for (const char* wrong : {"0/3", "4/3", "x", "1.5/3", "3"})
    CHECK(p.run(std::string("test t --shard ") + wrong).status == 2);
}

TEST_CASE("nothing ran is a failure, unless it may be empty", "[cli][runner]") {
  const Program p;
  write_ten(p);
  CHECK(p.run("test t --tag none").status == 5);
  CHECK(p.run("test t --tag none --list").status == 5);
  CHECK(p.run("test t --tag none --allow-empty").status == 0);
}

TEST_CASE("a shuffled order is printed, and comes again", "[cli][runner]") {
  const Program p;
  write_ten(p);
  const auto sorted = lines_of(p.run("test t --list").out);
  const Outcome o = p.run("test t --list --shuffle");
  std::smatch seed;
  REQUIRE(std::regex_search(o.out, seed, std::regex("order: (--order [0-9]+)")));
  CHECK(p.run("test t --list " + seed[1].str()).out == o.out);
  CHECK(says(p.run("test t --tap --shuffle --seed 7").err, "order: --order 7\n"));
  const auto seven = lines_of(p.run("test t --list --shuffle --seed 7").out);
  CHECK(seven == lines_of(p.run("test t --list --shuffle --seed 7").out));
  CHECK(seven != lines_of(p.run("test t --list --shuffle --seed 8").out));
  CHECK(std::multiset<std::string>(seven.begin() + 1, seven.end()) ==
        std::multiset<std::string>(sorted.begin(), sorted.end()));
}

TEST_CASE("repeated runs must end in the same state", "[cli][runner]") {
  const Program p;
  p.write("seeded.lua", scene("world:body { shape = feder.sphere(0.1 + math.random()) }"));
  CHECK(p.run("test seeded.lua --repeat 3").status == 0);
  p.write("ends_test.lua", "error('always')");
  CHECK(last_line(p.run("test ends_test.lua --repeat 3").out) == "0 passed, 1 failed, 0 skipped");
  // scripts cannot know which run they are in; but a file that they read changes meanwhile
  p.write("part.lua", "return 1\n");
  p.write("part2.lua", "return 2\n");
  p.write("other.lua", scene("world:body { shape = feder.sphere(1), position = { require('part'), 0, 0 } }"));
  const Outcome o =
      p.shell("{ '" FEDER_BINARY_DIR
              "/feder' test other.lua --repeat 100000 >text & sleep 1; mv part2.lua part.lua; wait $!; }");
  CHECK(o.status == 1);
  const std::string text = p.read("text");
  CAPTURE(text);
  CHECK(std::regex_search(text, std::regex("run [0-9]+ of 100000 ended in another state: [0-9a-f]{16} instead of ")));
  CHECK(says(text, "again: feder test other.lua --repeat 100000\n"));
}

TEST_CASE("a sweep runs each value by name, and writes a table", "[cli][runner]") {
  const Program p;
  p.write("high.lua", kHigh);
  p.write("other_test.lua", "assert(true)");
  const Outcome o = p.run("test high.lua other_test.lua --sweep n=10:20:5 --format text --format csv=out.csv");
  CAPTURE(o.out, o.err);
  CHECK(o.status == 1);
  CHECK(says(o.out, "high.lua[n=10]"));
  CHECK(says(o.out, "FAIL"));
  CHECK(says(o.out, "again: feder test 'high.lua[n=20]'"));
  CHECK(last_line(o.out) == "2 passed, 1 failed, 3 skipped");
  const auto rows = lines_of(p.read("out.csv"));
  REQUIRE(rows.size() == 7);
  CHECK(rows[0] == "file,n,status,checks,failures,time,seconds,hash");
  CHECK(rows[3].starts_with("high.lua,20,failed,0,1,0.1,"));
  CHECK(rows[4].starts_with("other_test.lua,10,skipped,"));
  CHECK(last_line(p.run("test high.lua --sweep n=1,2 --sweep kind=box,ball --random 0").out) ==
        "4 passed, 0 failed, 0 skipped");
  CHECK(p.run("test 'high.lua[n=20]'").status == 1);
  CHECK(p.run("test 'high.lua[n=20,kind=ball]'").status == 0);
  CHECK(p.run("test 'high.lua[n=99]'").status != 0);
  CHECK(p.run("test 'none.lua[n=9]'").status == 2);
  for (const char* wrong : {"n", "n=", "n=1:2", "n=2:1:1", "n=1:2:0", "=1"})
    CHECK(p.run(std::string("test high.lua --sweep ") + wrong).status == 2);
}

TEST_CASE("random values find a counter-example and shrink it", "[cli][runner]") {
  const Program p;
  p.write("high.lua", kHigh);
  for (const std::string how : {"", " --isolate"}) {
    p.shell("rm -f high.counterexamples.json");
    const Outcome o = p.run("test high.lua" + how);
    CAPTURE(o.out);
    CHECK(o.status == 1);
    // 17 is the smallest count that fails, and the kind is the default again
    CHECK(says(o.out, "high.lua:7: too many (with --set n=17, from draw "));
    CHECK(says(o.out, "again: feder test high.lua --set n=17\n"));
  }
  CHECK(p.run("test high.lua --set n=17").status == 1);
  CHECK(p.run("test high.lua --set n=16").status == 0);
  CHECK(p.run("test high.lua --random 0").status == 0);
  CHECK(p.run("test high.lua --random 40 --set kind=ball").status == 0);
  CHECK(p.run("test high.lua --json").json()["tests"][0]["counter_example"][0] == "n=17");
  // the draws are those of the seed
  p.write("rare.lua", std::regex_replace(kHigh, std::regex("n < 17 or kind == 'ball'"), "n ~= 33"));
  const auto seeded = [&] {
    const Outcome o = p.shell("CI=1 '" FEDER_BINARY_DIR "/feder' test rare.lua --random 300 --seed 5");
    return std::regex_replace(o.out, std::regex("[0-9.]+ s "), "");
  };
  const std::string first = seeded();
  CAPTURE(first);
  CHECK(std::regex_search(first, std::regex("with --set n=33, from draw [0-9]+ of --random 300 --seed 5\\)")));
  CHECK(says(first, "again: feder test rare.lua --set n=33 --seed 5\n"));
  CHECK(first == seeded());
}

TEST_CASE("a counter-example is kept, tried first, and dropped when it passes", "[cli][runner]") {
  const Program p;
  const auto test = [&](const std::string& arguments) {
    return p.shell("unset CI; '" FEDER_BINARY_DIR "/feder' test " + arguments);
  };
  const std::string file = "high.counterexamples.json";
  p.write("high.lua", kHigh);
  CHECK(says(test("high.lua").out, "(kept in " + file + ")"));
  CHECK(nlohmann::json::parse(p.read(file))["examples"][0]["set"] == nlohmann::json({"n=17"}));
  // no draws are asked for: it is the kept one that fails
  p.write("high.lua", std::regex_replace(kHigh, std::regex("random = 12"), "random = 0"));
  for (const std::string how : {"", " --isolate", " --random 5"}) {
    const Outcome o = test("high.lua" + how);
    CAPTURE(how, o.out);
    CHECK(o.status == 1);
    CHECK(says(o.out, "high.lua:7: too many (with --set n=17, found by an earlier run)\n"));
    CHECK(says(o.out, "again: feder test high.lua --set n=17\n"));
  }
  // other options are another run, and --random 0 asks for none
  CHECK(test("high.lua --random 0").status == 0);
  CHECK(test("high.lua --set kind=ball").status == 0);
  CHECK(test("high.lua --dt 1/120").status == 0);
  // where CI is set it is tried and left alone
  const std::string kept = p.read(file);
  const std::string mended = std::regex_replace(kHigh, std::regex("n < 17"), "n < 18");
  const std::string in_ci = "CI=1 '" FEDER_BINARY_DIR "/feder' test high.lua ";
  CHECK(p.shell(in_ci).status == 1);
  p.write("high.lua", std::regex_replace(mended, std::regex("random = 12"), "random = 0"));
  CHECK(p.shell(in_ci).status == 0);
  CHECK(p.read(file) == kept);
  CHECK(says(test("high.lua").out, "n=17 passes now"));
  CHECK(p.read(file).empty());
  CHECK(p.shell("ls").out.find(file) == std::string::npos);
  // the next one takes its place; a range that has become smaller leaves it out
  p.write("high.lua", mended);
  CHECK(says(test("high.lua").out, "--set n=18, from draw"));
  p.write("high.lua", std::regex_replace(mended, std::regex("max = 50"), "max = 17"));
  CHECK(says(test("high.lua").out, "n=18 passes now; 12 random draws"));
  // with the seed that it was found by
  p.write("high.lua", kHigh);
  CHECK(test("high.lua --seed 3").status == 1);
  CHECK(says(test("high.lua").out, "again: feder test high.lua --set n=17 --seed 3\n"));
  CHECK(says(test("high.lua --seed 4").out, "from draw"));
  p.write(file, "{}");
  CHECK(says(test("high.lua").out, file + ": no counter-examples of a test"));
}

TEST_CASE("scenes in YAML have random values and golden runs too", "[cli][runner]") {
  const Program p;
  const std::string yaml =
      "seconds: 0.1\nrandom: 10\nparams: { n: { value: 1, min: 1, max: 9 } }\nbodies:\n  - { name: a, shape: { "
      "sphere: 1 "
      "}, position: [$n, 0, 0] }\ncheck: |\n  local x = world:find('a'):position()\n  expect(x < 6, 'far')\n";
  p.write("scene.yaml", yaml);
  const Outcome o = p.run("test scene.yaml");
  CAPTURE(o.out, o.err);
  CHECK(says(o.out, "again: feder test scene.yaml --set n=6\n"));
  p.write("scene.yaml", yaml + "golden: { position: 0.1 }\n");
  CHECK(says(p.run("test scene.yaml --random 0").out, "no golden run scene.golden.json"));
}

TEST_CASE("a test under watch runs again when a file it reads is saved", "[cli][runner]") {
  const Program p;
  p.write("part.lua", "return 1\n");
  p.write("a_test.lua", "assert(require('part') == 1, 'changed')\n");
  p.write("b_test.lua", "assert(true)\n");
  const Outcome o = p.shell("{ '" FEDER_BINARY_DIR
                            "/feder' test --watch --no-isolate a_test.lua b_test.lua >text & pid=$!\n"
                            "for i in $(seq 200); do grep -q '2 passed' text && break; sleep 0.05; done; sleep 0.3\n"
                            "echo 'return 22' >part.lua\n"
                            "for i in $(seq 200); do grep -q '1 failed' text && break; sleep 0.05; done\n"
                            "kill -INT $pid; wait $pid; }");
  const std::string text = p.read("text");
  CAPTURE(text, o.err);
  CHECK(o.status == 130);
  CHECK(says(text, "2 passed, 0 failed, 0 skipped\n"));
  CHECK(says(text, "1 passed, 1 failed, 0 skipped\n"));
  CHECK(says(text, "a_test.lua:1: changed"));
  // the other one was left alone
  CHECK(std::regex_search(text, std::regex("b_test")));
  CHECK(!std::regex_search(text, std::regex("b_test[^]*b_test")));
}
