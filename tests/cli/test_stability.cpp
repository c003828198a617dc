// feder stability: what it writes and how it ends.
#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

TEST_CASE("stability writes maps, limits and a table", "[cli]") {
  const Program p;
  const Outcome o =
      p.run("stability oscillator --methods velocity_verlet,implicit_euler --x 0.01,1,100 --y 0,1 --bisect --out d");
  CHECK(o.status == 0);
  CHECK(o.err == "");
  CHECK(o.out.find("velocity_verlet") != std::string::npos);
  for (const char* file :
       {"stability.json", "cells.csv", "limits.csv", "sheet.svg", "map_oscillator_velocity_verlet.svg", "index.html"}) {
    CAPTURE(file);
    CHECK(p.read(std::string("d/") + file).size() > 100);
  }
  CHECK(count_lines(p.read("d/cells.csv")) == 13);
  const auto json = nlohmann::json::parse(p.read("d/stability.json"));
  CHECK(json["rows"].size() == 12);
  CHECK(json["limits"][0]["z_predicted"] == 2.0);
}

TEST_CASE("wrong words of stability end with status 2", "[cli]") {
  const Program p;
  const Outcome near = p.run("stability oscilator");
  CHECK(near.status == 2);
  CHECK(near.err.find("did you mean 'oscillator'?") != std::string::npos);
  for (const char* wrong :
       {"oscillator --methods none", "oscillator --axes h,h", "oscillator --x soon", "--suite none", "a b"}) {
    CAPTURE(wrong);
    CHECK(p.run(std::string("stability ") + wrong).status == 2);
  }
  CHECK(p.run("stability --list").status == 0);
  const Outcome scenes = p.run("stability oscillator --x 1 --y 0 --dt 1/240 --threads 2");
  CHECK(scenes.status == 0);
  CHECK(scenes.err.find("--dt, --threads are for scenes: no effect") != std::string::npos);
}
