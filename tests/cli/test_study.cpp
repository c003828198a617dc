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
  // one that came twice is refused
  CHECK(p.run("study --merge part1/report.json part1/report.json").status == 2);
}

TEST_CASE("holes, foreign shards and altered reports end a merge with status 1 and are named", "[cli]") {
  const Program p;
  for (const char* i : {"1", "2", "3"}) REQUIRE(p.run(kSmall + "--shard " + i + "/3 --out part" + i).status == 0);
  const auto refused = [&](const std::string& files, const std::string& named) {
    CAPTURE(files, named);
    const Outcome o = p.run("study --merge " + files + " --out merged");
    CHECK(o.status == 1);
    CHECK(count_lines(o.err) == 1);
    CHECK_THAT(o.err, Catch::Contains(named));
    CHECK(p.shell("ls merged").status != 0);
  };
  const std::string two = "part1/report.json part3/report.json ";
  refused(two, "missing: shard 2 of 3");
  const std::string base = "study oscillator --repeat 0 --shard 2/3 ", ladder = "--ladder steps:50..200:x2 ";
  struct Foreign {
    const char* name;
    std::string command, named;
  };
  for (const Foreign& f :
       {Foreign{"methods", base + ladder + "--methods rk4,leapfrog ", "plan_hash"},
        Foreign{"ladder", base + "--methods rk4,explicit_euler --ladder steps:60..240:x2 ", "plan_hash"},
        Foreign{"set", base + ladder + "--methods rk4,explicit_euler --set stiffness=2 ", "overrides"},
        Foreign{"shards", kSmall + "--shard 2/4 ", "shards are 4, expected 3"}}) {
    REQUIRE(p.run(f.command + "--out " + f.name).status == 0);
    refused(two + f.name + "/report.json", f.named);
  }
  // altered by hand: another commit, tool, precision, number of points
  const auto alter = [&](const std::string& from, const std::string& to) {
    std::string text = p.read("part2/report.json");
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    p.write("changed.json", text.replace(at, from.size(), to));
    refused(two + "changed.json", "does not fit");
  };
  alter("\"real\": \"float\"", "\"real\": \"double\"");
  alter("\"tool\": \"feder ", "\"tool\": \"other ");
  alter("\"plan_hash\": \"", "\"plan_hash\": \"0");
}

TEST_CASE("a study that was stopped goes on where it was", "[cli]") {
  const Program p;
  REQUIRE(p.run(kSmall + "--out whole").status == 0);
  // the file as a killed process leaves it: some points, and one cut off in the middle
  const std::string all = p.read("whole/points.jsonl");
  CHECK(count_lines(all) == 7);
  std::size_t end = 0;
  for (int k = 0; k < 4; ++k) end = all.find('\n', end) + 1;
  p.write("again/points.jsonl", all.substr(0, end + 100));
  const Outcome o = p.run(kSmall + "--out again --resume");
  CHECK(o.status == 0);
  CHECK_THAT(o.err, Catch::Contains("3 points are there"));
  CHECK(p.read("again/points.csv") == p.read("whole/points.csv"));
  CHECK(p.read("again/points.jsonl") == all);
  // all there: nothing is run, and the report is the same
  CHECK(p.run(kSmall + "--out again --resume").status == 0);
  CHECK(p.read("again/points.csv") == p.read("whole/points.csv"));
  CHECK(p.read("again/points.jsonl") == all);
  // another study in the same folder is refused and named
  const Outcome other = p.run("study oscillator --methods rk4 --ladder steps:50 --repeat 0 --out again --resume");
  CHECK(other.status == 1);
  CHECK_THAT(other.err, Catch::Contains("plan_hash"));
  CHECK(p.run("study oscillator --resume").status == 2);
}

TEST_CASE("each row says with what settings, threads and precision it was made", "[cli]") {
  const Program p;
  p.write("ball.lua",
          "local feder = require 'feder'\nlocal drop = feder.param('drop', 1, { min = 1, max = 3 })\n"
          "return feder.scene { title = 'Ball', seconds = 0.2, study = { axes = { drop = { 1, 2 }, dt = { 1 / 60, 1 / "
          "120 } },\n"
          "  error = function(world) local _, y = world:find('ball'):position() return math.abs(y) end },\n"
          "  build = function(world) world:body { name = 'ball', shape = feder.sphere(0.1), position = { 0, drop, 0 } "
          "} end }\n");
  const std::string study = "study ball.lua --repeat 0 --threads 2 --world gravity=0,-5,0 ";
  REQUIRE(p.run(study + "--out d").status == 0);
  const std::string csv = p.read("d/points.csv");
  CHECK_THAT(csv, Catch::Contains(",drop=1,\"gravity=0,-5,0\",2,float,") && Catch::Contains(",drop=2,"));
  const auto report = nlohmann::json::parse(p.read("d/report.json"));
  CHECK_THAT(report["command"].get<std::string>(), Catch::Contains("--threads 2"));
  CHECK(report["study"]["scene_hash"].get<std::string>().size() == 16);
  // against itself the gate is silent: rows of different settings are different points
  const Outcome again = p.run(study + "--baseline d/points.csv --json");
  CHECK(again.status == 0);
  CHECK(again.json()["gate"]["compared"] == count_lines(csv) - 1);
}

TEST_CASE("a scene whose own error is no number has no point that is ok", "[cli]") {
  const Program p;
  p.write("nan.lua",
          "local feder = require 'feder'\nreturn feder.scene { title = 'x', seconds = 0.1,\n"
          "  study = { axes = { dt = { 1 / 60, 1 / 120 } }, error = function() return 0 / 0 end },\n"
          "  build = function(world) world:body { shape = feder.sphere(0.1) } end }\n");
  const Outcome o = p.run("study nan.lua --repeat 0 --json");
  const auto points = o.json()["points"];
  CHECK_FALSE(points.empty());
  for (const auto& point : points) CHECK(point["status"] == "nan");
}

TEST_CASE("the gate ends with status 1 when counts or errors differ", "[cli]") {
  const Program p;
  REQUIRE(p.run(kSmall + "--out d").status == 0);
  CHECK(p.run(kSmall + "--baseline d/points.csv").status == 0);
  CHECK(p.run(kSmall + "--baseline d/report.json --gate cost,error,size").status == 0);
  std::string csv = p.read("d/points.csv");
  const std::size_t at = csv.find(",200,0,800,");
  REQUIRE(at != std::string::npos);
  p.write("changed.csv", csv.replace(at, 11, ",200,0,799,"));
  const Outcome o = p.run(kSmall + "--baseline changed.csv --json");
  CHECK(o.status == 1);
  CHECK(o.err.find("force_evals was 799, is 800") != std::string::npos);
  CHECK(o.json()["gate"]["violations"].size() == 1);
  CHECK(p.run(kSmall + "--baseline changed.csv --gate error").status == 0);
}
