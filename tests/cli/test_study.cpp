// feder study: what it writes, how it ends, and that shards put together are the whole.
#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

namespace {

// Small and quick: three rungs of two methods, nothing timed.
const std::string kSmall = "study oscillator --methods rk4,explicit_euler --ladder steps:50..200:x2 --repeat 0 ";

}  // namespace

TEST_CASE("study writes its files and a table", "[cli]") {
  const Program p;
  const Outcome o = p.run(
      "study oscillator --methods rk4,explicit_euler --ladder steps:50..200:x2 --repeat 1 --out d --markdown pick.md");
  CHECK(o.status == 0);
  CHECK(o.err == "");
  CHECK(o.out.find("error below") != std::string::npos);
  for (const char* file : {"report.json", "points.csv", "error_vs_time.svg", "error_vs_work.svg", "order.svg",
                           "invariants.svg", "index.html"}) {
    CAPTURE(file);
    CHECK(p.read(std::string("d/") + file).size() > 100);
  }
  CHECK(count_lines(p.read("d/points.csv")) == 7);
  const auto json = nlohmann::json::parse(p.read("d/report.json"));
  CHECK(json["schema"] == "accuracy/1");
  CHECK(json["points"].size() == 6);
  CHECK(p.read("pick.md").find("(d/error_vs_work.svg)") != std::string::npos);
}

TEST_CASE("study without --out prints the table only; --json prints the report", "[cli]") {
  const Program p;
  const Outcome text = p.run(kSmall);
  CHECK(text.status == 0);
  CHECK(text.out.find("rk4") != std::string::npos);
  CHECK(p.shell("ls d").status != 0);
  const Outcome json = p.run(kSmall + "--json");
  CHECK(json.json()["points"].size() == 6);
  CHECK(json.json()["points"][0]["t_min_s"].is_null());
}

TEST_CASE("study --list names problems, parameters and references", "[cli]") {
  const Program p;
  const Outcome text = p.run("study --list");
  CHECK(text.status == 0);
  for (const char* word : {"oscillator", "stiffness", "closed", "15"}) CHECK(text.out.find(word) != std::string::npos);
  for (const auto& row : p.run("study --list --json").json()) {
    CHECK(row["name"].get<std::string>() != "");
    CHECK(row["reference"].contains("digits"));
  }
}

TEST_CASE("wrong words of study end with status 2 and name what is known", "[cli]") {
  const Program p;
  const Outcome near = p.run("study oscilator");
  CHECK(near.status == 2);
  CHECK(near.err.find("did you mean 'oscillator'?") != std::string::npos);
  CHECK(count_lines(near.err) == 1);
  for (const char* wrong : {"",
                            "a b",
                            "oscillator --methods rk5",
                            "oscillator --set stifness=2",
                            "oscillator --set stiffness=-1",
                            "oscillator --ladder h:0",
                            "oscillator --ladder q:1..2:x2",
                            "oscillator --error nothing",
                            "oscillator --axis miles",
                            "oscillator --budget time=3",
                            "oscillator --budget force=0",
                            "oscillator --shard 3",
                            "oscillator --shard 4/3",
                            "oscillator --shard a/b",
                            "oscillator --gate cost",
                            "oscillator --baseline none.csv --gate speed",
                            "oscillator --repeat 0 --baseline none.csv",
                            "--merge",
                            "--merge none.json",
                            "--suite none",
                            "oscillator --no-such"}) {
    CAPTURE(wrong);
    const Outcome o = p.run(std::string("study ") + wrong);
    CHECK(o.status == 2);
    CHECK(count_lines(o.err) >= 1);
  }
}

TEST_CASE("shards put together are the whole", "[cli]") {
  const Program p;
  REQUIRE(p.run(kSmall + "--out whole").status == 0);
  for (const char* i : {"1", "2", "3"}) REQUIRE(p.run(kSmall + "--shard " + i + "/3 --out part" + i).status == 0);
  CHECK(count_lines(p.read("part1/points.csv")) == 3);
  REQUIRE(p.run("study --merge part3/report.json part1/report.json part2/report.json --out merged").status == 0);
  for (const char* file : {"points.csv", "error_vs_work.svg", "order.svg", "invariants.svg"}) {
    CAPTURE(file);
    CHECK(p.read(std::string("merged/") + file) == p.read(std::string("whole/") + file));
  }
  auto whole = nlohmann::json::parse(p.read("whole/report.json")),
       merged = nlohmann::json::parse(p.read("merged/report.json"));
  for (const char* key : {"problem", "methods", "points", "fits", "front", "cost_to_accuracy", "series"}) {
    CAPTURE(key);
    CHECK(merged[key] == whole[key]);
  }
  // a part that is missing is said, one that came twice is refused
  const Outcome some = p.run("study --merge part1/report.json part2/report.json");
  CHECK(some.status == 0);
  CHECK(some.err.find("4 of 6 points") != std::string::npos);
  CHECK(p.run("study --merge part1/report.json part1/report.json").status == 2);
  REQUIRE(p.run("study oscillator --methods rk4 --ladder steps:50..200:x2 --repeat 0 --set stiffness=2 --shard 2/3 "
                "--out other")
              .status == 0);
  CHECK(p.run("study --merge part1/report.json other/report.json").status == 2);
}

TEST_CASE("the gate ends with status 3 when counts or errors differ", "[cli]") {
  const Program p;
  REQUIRE(p.run(kSmall + "--out d").status == 0);
  CHECK(p.run(kSmall + "--baseline d/points.csv").status == 0);
  CHECK(p.run(kSmall + "--baseline d/report.json --gate cost,error,size").status == 0);
  std::string csv = p.read("d/points.csv");
  const std::size_t at = csv.find(",200,0,800,");
  REQUIRE(at != std::string::npos);
  p.write("changed.csv", csv.replace(at, 11, ",200,0,799,"));
  const Outcome o = p.run(kSmall + "--baseline changed.csv --json");
  CHECK(o.status == 3);
  CHECK(o.err.find("force_evals was 799, is 800") != std::string::npos);
  CHECK(o.json()["gate"]["violations"].size() == 1);
  CHECK(p.run(kSmall + "--baseline changed.csv --gate error").status == 0);
}
