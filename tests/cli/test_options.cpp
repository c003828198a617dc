// Options of commands: steps of a run, and what the help says of values.
#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

TEST_CASE("run takes a number of steps in place of seconds", "[cli][options]") {
  const Program p;
  p.write("ball.lua", scene(kBall));
  const Outcome steps = p.run("run ball.lua --steps 10 --json");
  REQUIRE(steps.status == 0);
  CHECK(steps.json()["steps"] == 10);
  CHECK(steps.json()["seconds"].get<double>() == Approx(10.0 / 60));
  CHECK(steps.json()["hash"] == p.run("run ball.lua --seconds 1/6 --json").json()["hash"]);
  CHECK(p.run("run ball.lua --steps 10 --dt 1/600 --json").json()["seconds"].get<double>() == Approx(10.0 / 600));
  CHECK(p.run("run ball.lua --steps 0 --json").json()["steps"] == 0);
  const Outcome both = p.run("run ball.lua --steps 10 --seconds 1");
  CHECK(both.status == 2);
  CHECK(both.err == "feder run: expected --seconds or --steps, got both\n");
  CHECK(p.run("run ball.lua --steps -1").status == 2);
  CHECK(p.run("run ball.lua --steps some").status == 2);
}

TEST_CASE("the help says what values are, and lists options of scenes where scenes run", "[cli][options]") {
  const Program p;
  const std::string run = p.run("run --help").out;
  for (const char* line : {"--seconds S", "--steps N", "--dt S", "--set NAME=VALUE", "--memory BYTES"}) {
    CAPTURE(run, line);
    CHECK(run.find(line) != std::string::npos);
  }
  for (const char* command : {"check", "new"}) {
    const std::string help = p.run(std::string(command) + " --help").out;
    CAPTURE(help);
    CHECK(help.find("--json") != std::string::npos);
    for (const char* option : {"--dt", "--threads", "--seed", "--world", "--limit"})
      CHECK(help.find(option) == std::string::npos);
  }
  // scripts that pass them to every command go on
  p.write("ball.lua", scene(kBall));
  CHECK(p.run("check ball.lua --seed 1 --dt 1/60").status == 0);
}
