// The contract of feder/study.h for scenes/study: runs start where the reference does, come close to it, and closer
// with work; equal commands give equal points. A new scene is enrolled by its row here.
#include <map>
#include <set>

#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

namespace {

// Two rungs of each, coarse and fine, as cheap as they may be.
const std::map<std::string, std::string> kRungs = {
    {"free_top", "steps:400,1600"},
    {"heavy_top", "steps:60,480"},
    {"bouncing_ball", "steps:120,960"},
    {"stack", "steps:120,480"},
    {"bullet", "steps:10,40"},
    {"incline", "steps:60,240"},
    {"slide_to_rest", "steps:77,616"},
    {"rolling", "steps:60,480"},
    {"hanging_sheet", "substeps:4,32"},
    {"catenary", "substeps:4,32"},
    {"cantilever", "substeps:8,64"},
    {"drum", "substeps:2,8"},
    {"balloon", "substeps:2,8"},
    {"soft_bar", "substeps:1,8"},
    {"soft_cantilever", "substeps:2,16"},
    {"drape", "substeps:2,8"},
    {"capstan", "substeps:2,8"},
    {"hydrostatic", "substeps:2,8"},
    {"dam_break", "substeps:2,8"},
    {"draught", "substeps:2,4"},
    {"poiseuille", "substeps:2,4"},
    {"droplet", "substeps:2,4"},
    {"slosh", "substeps:2,4 --set t_end=1.8"},
    {"u_tube", "substeps:2,4 --set t_end=2.1"},
    {"vessels", "substeps:1,2"},
    {"torricelli", "substeps:2,4"},
    {"couette", "substeps:2,4"},
    {"taylor_green", "substeps:2,4"},
    {"two_layer", "substeps:2,4 --set t_end=2.5"},
    {"added_mass", "substeps:2,4"},
    {"siphon", "substeps:2,4 --set t_end=2.6"},
    {"droplet_3d", "substeps:2,4"},
    {"contact_angle", "substeps:2,4"},
    {"honey_fold", "substeps:1,2 --set t_end=2.3"},
};

// Where the default is not the method that comes close.
const std::map<std::string, std::string> kUsual = {{"dam_break", "wcsph"}};

// Run with all others, late: half a minute together.
const std::set<std::string> kLate = {"siphon", "honey_fold"};

nlohmann::json scene_problems(const Program& p) {
  const Outcome o = p.run("study --list --json");
  REQUIRE(o.status == 0);
  nlohmann::json out = nlohmann::json::array();
  for (const auto& problem : o.json())
    if (problem["family"] == "scene") out.push_back(problem);
  return out;
}

// With the default method of each problem, or with all.
void check_runs(bool all) {
  const Program p;
  for (const auto& problem : scene_problems(p)) {
    const std::string name = problem["name"];
    if (!kRungs.count(name) || (!all && kLate.count(name))) continue;
    CAPTURE(name);
    std::string methods = all ? "all" : problem["methods"].at(0).get<std::string>();
    if (!all && kUsual.count(name)) methods = kUsual.at(name);
    const Outcome o =
        p.run("study " + name + " --repeat 0 --quiet --json --methods " + methods + " --ladder " + kRungs.at(name));
    CAPTURE(o.err);
    REQUIRE(o.status == 0);
    const nlohmann::json report = o.json();
    const auto& reference = report["problem"]["reference"];
    const double floor = std::max(reference["floor"].get<double>(), reference.value("resolution", 0.0));
    for (const auto& series : report["series"]) CHECK(series["err"].at(0).get<double>() < 1e-5);
    double coarse = 1e300, fine = 1e300;
    const double finest = report["points"].back()["steps"].get<double>();
    for (const auto& point : report["points"]) {
      CAPTURE(point["method"], point["h_s"], point["substeps"]);
      CHECK(point["status"] == "ok");
      const bool late = point["steps"] == finest && point["substeps"] == report["points"].back()["substeps"];
      double& best = late ? fine : coarse;
      best = std::min(best, point["err_end"].get<double>());
    }
    CAPTURE(coarse, fine, floor);
    CHECK(fine < std::max(0.02, floor));
    CHECK(fine <= std::max({coarse, floor, 1e-6}));
  }
}

}  // namespace

TEST_CASE("every problem that is a scene has its rungs here", "[cli][contract]") {
  const Program p;
  const auto problems = scene_problems(p);
  CHECK(problems.size() >= 8);  // of bodies: those of systems that this build lacks are not listed
  for (const auto& problem : problems) {
    CAPTURE(problem["name"]);
    CHECK(kRungs.count(problem["name"]));
    CHECK_FALSE(problem["reference"]["source"].get<std::string>().empty());
    CHECK(problem["params"].size() > 0);
    for (const auto& param : problem["params"]) CHECK((param["help"] != "" || param["name"] == "solver"));
  }
}

TEST_CASE("runs of scenes start at the reference, come close to it, and closer with work", "[cli][problems]") {
  check_runs(false);
}

TEST_CASE("runs of scenes come close to the reference with every solver", "[cli][late]") { check_runs(true); }

TEST_CASE("equal studies of scenes have equal points, whatever the shard and after a stop", "[cli][contract]") {
  const Program p;
  for (const std::string name : {"bouncing_ball", "hanging_sheet", "poiseuille"}) {
    if (p.run("study " + name + " --repeat 0 --ladder steps:40 --quiet --out whole").status != 0) continue;
    CAPTURE(name);
    const auto points = [&](const std::string& folder) {
      return nlohmann::json::parse(p.read(folder + "/report.json"))["points"];
    };
    REQUIRE(p.run("study " + name + " --repeat 0 --ladder steps:40 --quiet --shard 1/2 --out one").status == 0);
    REQUIRE(p.run("study " + name + " --repeat 0 --ladder steps:40 --quiet --shard 2/2 --out two").status == 0);
    REQUIRE(p.run("study --merge one/report.json two/report.json --quiet --out merged").status == 0);
    CHECK(points("merged") == points("whole"));
    const std::string before = p.read("whole/points.csv");
    REQUIRE(p.run("study " + name + " --repeat 0 --ladder steps:40 --quiet --out whole --resume").status == 0);
    CHECK(p.read("whole/points.csv") == before);
    CHECK(nlohmann::json::parse(p.read("whole/report.json"))["study"]["scene_hash"] != "");
  }
}

TEST_CASE("parameters of problems that are scenes refuse what is outside their range", "[cli][contract]") {
  const Program p;
  for (const std::string wrong :
       {"stack --set boxes=41", "stack --set boxs=3", "incline --set mu=-1", "bullet --set bullet=2"}) {
    CAPTURE(wrong);
    const Outcome o = p.run("study " + wrong);
    CHECK(o.status == 2);
    CHECK(count_lines(o.err) == 1);
  }
}
