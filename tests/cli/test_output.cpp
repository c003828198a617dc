// What cannot be written is a failure of every command, and what an interrupted command leaves is whole
// (scripts/check/interrupts.py: at any moment).
#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

TEST_CASE("what cannot be written is a failure with a line that names it", "[cli][output]") {
  const Program p;
  p.write("ball.lua", scene(kBall));
  p.write("file", "");
  p.shell("mkdir full");
  for (const char* name : {"points.jsonl", "report.json", "stability.json", "x.md", "x.csv", "x.xml", "x.lua"})
    p.shell(std::string("ln -s /dev/full full/") + name);
  const std::string study = "study oscillator --methods rk4 --repeat 0 -q ",
                    map = "stability oscillator --methods rk4 -q ";
  struct Case {
    std::string arguments, names;
    int status = 1;
  };
  for (const auto& [arguments, names, status] : std::initializer_list<Case>{
           {study + "--out file/out", "file/out/points.jsonl"},
           {study + "--out full", "full/points.jsonl"},
           {study + "--markdown full/x.md", "full/x.md"},
           {study + "--markdown no/x.md", "no/x.md"},
           {map + "--suite core --out file/out", "file/out"},
           {map + "--suite core --out full", "full/stability.json"},
           {"run ball.lua -q --csv full/x.csv", "full/x.csv"},
           {"run ball.lua -q --csv no/x.csv", "no/x.csv"},
           {"run ball.lua -q --csv file/x.csv", "file/x.csv"},
           {"test ball.lua -q --junit full/x.xml", "full/x.xml", 2},
           {"test ball.lua -q --junit no/x.xml", "no/x.xml", 2},
           {"new no/x", "no/x.lua"},
           {"new file/x", "file/x.lua"},
       }) {
    const Outcome o = p.run(arguments);
    CAPTURE(arguments, o.out, o.err);
    CHECK(o.status == status);
    CHECK(count_lines(o.err) == 1);
    CHECK(o.err.find(names + ": cannot be ") != std::string::npos);
  }
  CHECK(p.shell("ls full file").out.find(".part") == std::string::npos);
  if (p.shell("test -w / && exit 1; exit 0").status == 0) {  // root writes anything
    p.write("kept.csv", "old\n");
    p.shell("chmod a-w kept.csv");
    CHECK(p.run("run ball.lua -q --csv kept.csv").status == 1);
    CHECK(p.read("kept.csv") == "old\n");
  }
}

TEST_CASE("a study that was interrupted goes on to the same end", "[cli][output]") {
  const Program p;
  const std::string study =
      "study oscillator --repeat 0 -q --methods "
      "rk4,bdf2,tr_bdf2,ros2,rk45,exponential,implicit_midpoint,implicit_euler";
  REQUIRE(p.run(study + " --out whole").status == 0);
  const Outcome o = p.shell("{ '" FEDER_BINARY_DIR "/feder' " + study +
                            " --out part & pid=$!; for i in $(seq 500); do [ $(wc -l <part/points.jsonl) -gt 3 ] "
                            "2>/dev/null && break; sleep 0.002; done; kill -TERM $pid; wait $pid; }");
  CAPTURE(o.err);
  if (o.status == 0) {
    WARN("the study was over before the signal: nothing was checked");
    return;
  }
  CHECK(o.status == 143);
  CHECK(o.err.find("points are finished; --resume goes on") != std::string::npos);
  const auto report = nlohmann::json::parse(p.read("part/report.json"));
  CHECK(report["plan"]["interrupted"] == true);
  CHECK(report["points"].size() + 1 == static_cast<std::size_t>(count_lines(p.read("part/points.jsonl"))));
  CHECK(p.read("part/index.html").find("Interrupted: ") != std::string::npos);
  CHECK(p.run(study + " --out part --resume").status == 0);
  CHECK(p.read("part/points.csv") == p.read("whole/points.csv"));
}

TEST_CASE("an interrupted map has its cells, and an interrupted bench its runs", "[cli][output]") {
  const Program p;
  p.write("ball.lua", scene(kBall));
  // --foreground: without it timeout sends the signal twice, and the second ends what the first had already reached
  const auto interrupted = [&](const std::string& arguments, const std::string& seconds) {
    return p.shell("{ timeout --foreground --preserve-status -s INT " + seconds + " '" FEDER_BINARY_DIR "/feder' " +
                   arguments + "; }");
  };
  const Outcome map = interrupted("stability hanging_sheet --json", "1");
  CAPTURE(map.err);
  CHECK(map.status == 130);
  CHECK(map.json()["interrupted"] == true);
  CHECK(map.json()["rows"].size() > 0);
  const Outcome bench = interrupted("bench ball.lua --runs 10000 --json", "0.5");
  CAPTURE(bench.err);
  CHECK(bench.status == 130);
  CHECK(bench.json()["interrupted"] == true);
  CHECK(bench.json()["runs"].get<int>() > 0);
}
