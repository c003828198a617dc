// Lua scenes as study problems: refined references, errors and axes of their own, and what is said about mistakes.
#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

namespace {

// A mass on a spring; `study` is put into the scene.
std::string spring_scene(const std::string& study) {
  return R"(local feder = require "feder"
local integrator = feder.param("integrator", "velocity_verlet", { choices = { "velocity_verlet", "rk4" } })
local k = feder.param("stiffness", 30, { min = 1, max = 1000 })
return feder.scene { title = "Spring", seconds = 1, world = { gravity = { 0, 0, 0 }, dt = 1 / 50, substeps = 1 },
  )" + study +
         R"(
  build = function(world, scene)
    scene.net = world:net { points = { { 0, 0, 0 }, { 1.5, 0, 0 } }, masses = 1, integrator = integrator,
      springs = { { 1, 2, stiffness = k, rest_length = 1 } } }
    scene.net:pin(1)
  end,
}
)";
}

nlohmann::json study(const Program& p, const std::string& text, const std::string& options = "") {
  p.write("s.lua", text);
  const Outcome o = p.run("study s.lua --repeat 0 --json " + options);
  CAPTURE(o.err);
  REQUIRE(o.status == 0);
  return o.json();
}

}  // namespace

TEST_CASE("a scene without a word about studies is refined", "[cli]") {
  const Program p;
  const auto r = study(p, spring_scene(""));
  CHECK(r["problem"]["reference"]["kind"] == "self");
  CHECK(r["problem"]["reference"]["uncertainty"].get<double>() < 1e-2);
  REQUIRE(r["points"].size() == 10);
  CHECK(r["points"][0]["method"] == "velocity_verlet");
  for (const auto& point : r["points"]) CHECK(point["status"] == "ok");
  CHECK(r["points"][3]["err_traj_rms"].get<double>() < r["points"][0]["err_traj_rms"].get<double>());
}

TEST_CASE("a scene states its error, its reference and its axes", "[cli]") {
  const Program p;
  const auto r = study(p, spring_scene(R"(study = {
    axes = { dt = { 1 / 50, 1 / 200 }, stiffness = { from = 30, to = 120, factor = 2 }, integrator = { "rk4" } },
    reference = function(world, scene) return { 1 + 0.5 * math.cos(math.sqrt(k) * world:time()) } end,
    error = function(world, scene, at) local x = scene.net:point(2) return math.abs(x - at[1]) end,
  },)"));
  REQUIRE(r["points"].size() == 6);
  for (const auto& point : r["points"]) {
    CHECK(point["method"] == "rk4");
    CHECK(point["err_end"].get<double>() < 1e-3);
  }
}

TEST_CASE("stated places at the end are the reference", "[cli]") {
  const Program p;
  const auto r =
      study(p, spring_scene("study = { reference = { { 2, 0, 0 } }, axes = { dt = { 0.01 } } },"), "--methods rk4");
  REQUIRE(r["points"].size() == 1);
  const double exact = 2 - (1 + 0.5 * std::cos(std::sqrt(30.0)));
  CHECK(r["points"][0]["err_end"].get<double>() == Approx(exact).margin(1e-4));
}

TEST_CASE("mistakes in a scene's study name place and key", "[cli]") {
  const Program p;
  const std::pair<const char*, const char*> wrong[] = {
      {"study = { eror = 1 },", "error"},
      {"study = { error = 1 },", "study.error"},
      {"study = { axes = { stifness = { 1, 2 } } },", "stiffness"},
      {"study = { axes = { dt = { from = 1, to = 2 } } },", "factor"},
      {"study = { axes = { dt = 3 } },", "study.axes.dt"},
      {"study = { method = \"stiffness\" },", "study.method"},
      {"study = { error = function() return \"x\" end },", "study.error"},
      {"study = { reference = { \"x\" } },", "study.reference"},
  };
  for (const auto& [text, part] : wrong) {
    CAPTURE(text);
    p.write("s.lua", spring_scene(text));
    const Outcome o = p.run("study s.lua --repeat 0");
    CHECK(o.status != 0);
    CHECK(o.err.find("s.lua") != std::string::npos);
    CHECK(o.err.find(part) != std::string::npos);
    CHECK(count_lines(o.err) == 1);
  }
}

TEST_CASE("broad phases are studied on the boxes of a scene", "[cli]") {
  const Program p;
  p.write("heap.lua", R"(local feder = require "feder"
return feder.scene { seconds = 1, build = function(world)
  world:body { shape = feder.plane(), type = "static" }
  for i = 1, 12 do world:body { shape = feder.box(1, 1, 1), position = { i % 3, i, 0 }, density = 500 } end
end })");
  const auto r = p.run("study broad_phase --boxes heap.lua --json --repeat 0").json();
  CHECK(r["problem"]["summary"].get<std::string>().find("heap.lua") != std::string::npos);
  CHECK(r["problem"]["dof"] == 39);
  REQUIRE(r["points"].size() >= 4 * 8);
  for (const auto& point : r["points"]) {
    CAPTURE(point["method"]);
    CHECK(point["status"] == "ok");
    CHECK(point["err_end"] == 0);
    CHECK(point["err_constraint"] == 0);
  }
  p.write("empty.lua", "local feder = require 'feder' return feder.scene { seconds = 1, build = function() end }");
  const Outcome none = p.run("study broad_phase --boxes empty.lua");
  CHECK(none.status == 2);
  CHECK(none.err.find("empty.lua has 0 colliders") != std::string::npos);
  CHECK(p.run("study --suite core --boxes heap.lua").err.find("expected the problem broad_phase") != std::string::npos);
  CHECK(p.run("study kepler --boxes heap.lua").err.find("expected the problem broad_phase") != std::string::npos);
}
