// The references of scenes/study and of the library feder.problem against printed digits; what `study = {}` takes and
// what it says of mistakes.
#include <cmath>

#include "support/script.h"

using namespace feder;
using namespace feder::test;

namespace {

lua::HostOptions with_libraries() {
  lua::HostOptions options;
  options.library_roots = {FEDER_SOURCE_DIR "/scripts"};
  options.print = [](std::string_view) {};
  return options;
}

lua::StudyState reference_of(const std::string& problem, const std::map<std::string, std::string>& set, double t) {
  lua::HostOptions options = with_libraries();
  options.set = set;
  lua::Script script(std::move(options));
  script.load_file(FEDER_SOURCE_DIR "/scenes/study/" + problem + ".lua");
  script.build();
  return script.study_state("reference", t);
}

// A scene without objects, with this study.
std::unique_ptr<lua::Script> scene_with(const std::string& study) {
  auto script = std::make_unique<lua::Script>(with_libraries());
  script->load_string(
      "local feder = require 'feder' return feder.scene { seconds = 1, build = function() end, study = {" + study +
          "} }",
      "s.lua");
  script->build();
  return script;
}

std::string mistake_in(const std::string& study) {
  try {
    scene_with(study);
  } catch (const lua::ScriptError& e) {
    return e.what();
  }
  return "";
}

// What a text with the library prints, as numbers.
std::vector<double> numbers_of(const std::string& text) {
  const std::string out = output_of("local problem = require 'feder.problem' " + text, with_libraries());
  std::vector<double> all;
  std::size_t at = 0;
  while (at < out.size()) {
    std::size_t used = 0;
    all.push_back(std::stod(out.substr(at), &used));
    at = out.find_first_not_of(" \t\n", at + used);
  }
  return all;
}

void check_numbers(const std::vector<double>& got, const std::vector<double>& want, double margin) {
  REQUIRE(got.size() == want.size());
  for (std::size_t i = 0; i < got.size(); ++i) CHECK(got[i] == Approx(want[i]).epsilon(0).margin(margin));
}

}  // namespace

TEST_CASE("closed forms of scenes have the printed digits", "[lua][study]") {
  struct Expected {
    const char* problem;
    std::map<std::string, std::string> set;
    double t;
    std::vector<double> x, v;  // leading components
    double tolerance;
  };
  const Expected rows[] = {
      {"bouncing_ball", {{"e", "0.8"}}, 1, {0, 0.1 + 0.468004452526036311}, {}, 1e-14},
      {"bouncing_ball", {{"e", "0.9"}}, 1, {0, 0.1 + 0.710949144333038328}, {}, 1e-14},
      {"bouncing_ball", {{"e", "1"}, {"t_end", "10"}}, 10, {0, 0.1 + 0.978321975404437986}, {}, 1e-13},
      {"bouncing_ball", {{"e", "0.5"}}, 1.36, {0, 0.1}, {0, 0}, 1e-9},
      {"slide_to_rest", {}, 1.2, {2.54841997961264016}, {0}, 3e-14},
      {"rolling", {}, 0.291247997670016019, {1.24820570430006865}, {25.0 / 7}, 1e-13},
      {"rolling", {}, 0.5, {1.24820570430006865 + 25.0 / 7 * (0.5 - 0.291247997670016019)}, {25.0 / 7}, 1e-13},
  };
  for (const Expected& e : rows) {
    CAPTURE(e.problem, e.t);
    const lua::StudyState at = reference_of(e.problem, e.set, e.t);
    for (std::size_t i = 0; i < e.x.size(); ++i) CHECK(at.x.at(i) == Approx(e.x[i]).epsilon(0).margin(e.tolerance));
    for (std::size_t i = 0; i < e.v.size(); ++i)
      CHECK(at.v.at(i) == Approx(e.v[i]).epsilon(0).margin(10 * e.tolerance));
  }
}

TEST_CASE("blocks on a slope have the printed accelerations", "[lua][study]") {
  const std::pair<const char*, double> rows[] = {
      {"0.3", 2.35628723666239706}, {"0.5", 0.657145394437328438}, {"0.6", 0}};
  for (const auto& [mu, a] : rows) {
    CAPTURE(mu);
    const lua::StudyState start = reference_of("incline", {{"mu", mu}}, 0),
                          end = reference_of("incline", {{"mu", mu}}, 1);
    CHECK(std::hypot(end.x[0] - start.x[0], end.x[1] - start.x[1]) == Approx(a / 2).epsilon(1e-14).margin(1e-15));
    CHECK(std::hypot(end.v[0], end.v[1]) == Approx(a).epsilon(1e-14).margin(1e-15));
  }
}

TEST_CASE("a free asymmetric top tumbles as printed", "[lua][study]") {
  // I = (1, 2, 3), w0 = (0.01, 1, 0.01); each passage along the middle axis takes the rounding about a hundredfold
  const std::string top =
      "local top = problem.top({1, 2, 3}, 0, {0.01, 1, 0.01, 0, 0, 0, 1}, 50) "
      "local function show(t, n) local _, _, s = top(t) for i = 1, n do print(('%.17g'):format(s[i])) end end ";
  check_numbers(numbers_of(top + "show(5, 3)"), {-0.064829616986886026, 0.99794645185066601, 0.038309612539006191},
                1e-12);
  check_numbers(numbers_of(top + "show(10, 7)"),
                {-0.87457343789109365, 0.48499618734104845, 0.50500122054791334, 0.11814412672545, -0.82272014674721,
                 -0.50026871144938, 0.24270299091957},
                1e-12);
  check_numbers(numbers_of(top + "show(50, 3)"), {-0.99996448859938037, 0.013077520414042320, 0.57738750086339195},
                1e-10);
}

TEST_CASE("a heavy symmetric top nods as printed", "[lua][study]") {
  // I1 = 1 about the pivot, I3 = 0.5, m g l = 1, let go at 60 degrees with w3 = 6
  const std::vector<double> angles = numbers_of(
      "local tilt = math.acos(0.5) "
      "local top = problem.top({1, 0.5, 1}, 1, {0, 6, 0, 0, 0, math.sin(tilt / 2), math.cos(tilt / 2)}, 5) "
      "for _, t in ipairs { 1, 5, 2.27830199768873831, 2.27830199768873831 / 2 } do "
      "  local q = top(t) local _, axis = problem.axes(q[1], q[2], q[3], q[4]) "
      "  print(('%.17g'):format(math.acos(axis[2]))) end");
  check_numbers(
      angles,
      {1.26086306304836038, 1.12137587646060608, std::acos(0.5), 72.696236879352552 * 3.14159265358979324 / 180},
      1e-12);
}

TEST_CASE("a study takes numbers, lists, places with velocities, and buffers", "[lua][study]") {
  const auto script = scene_with(
      "reference = function(t, world) return { x = { { t, 2 }, 3, 4 }, v = { 5 }, q = { 0, 0, 0, 1 } } end,"
      "observe = function() local b = feder.buffer(2) b[1], b[2] = 7, 8 return b end,"
      "energy = 2.5, measure = function() return { 1, { 2 } } end");
  const lua::StudyState at = script->study_state("reference", 0.5), now = script->study_state("observe");
  CHECK(at.x == std::vector<double>{0.5, 2, 3, 4, 0, 0});
  CHECK(at.v == std::vector<double>{5, 0, 0});
  CHECK(at.q == std::vector<double>{0, 0, 0, 1});
  CHECK(now.x == std::vector<double>{7, 8, 0});
  CHECK(script->study_numbers("energy", 1) == std::vector<double>{2.5});
  CHECK(script->study_numbers("measure") == std::vector<double>{1, 2});
}

TEST_CASE("errors get world and reference, or as build does world and scene first", "[lua][study]") {
  const auto error = [](const char* study) { return scene_with(study)->study_error(); };
  CHECK(error("reference = 3, error = function(world, reference) return world:time() + reference end") == 3);
  CHECK(error("reference = function(t, world) return { t + world:time() + 4 } end,"
              "error = function(world, reference) return reference[1] end") == 4);
  CHECK(error("reference = function(world, scene) return { scene.seconds } end,"
              "error = function(world, scene, reference) return reference[1] + scene.seconds end") == 2);
  const std::vector<double> refined = {6, 8};
  const auto script =
      scene_with("reference = 'self', error = function(world, refined) return refined[1] - refined[2] end");
  CHECK(script->study_error(refined) == 2);
}

TEST_CASE("mistakes of a study are named", "[lua][study]") {
  const std::pair<const char*, const char*> wrong[] = {
      {"reference = 'other'", "study.reference: expected numbers, \"self\""},
      {"observe = 3", "study.observe: expected a function"},
      {"energy = 'x'", "study.energy: expected a number or"},
      {"conserves = 'mass'", "study.conserves: expected \"momentum\""},
      {"scale = { length = 0 }", "study.scale.length: expected a number above 0"},
      {"scale = { size = 1 }", "unknown option 'size'"},
      {"certainty = { kind = 'sure' }", "study.certainty.kind: expected"},
      {"ladders = { 3 }", "study.ladders[1]: expected a table"},
      {"ladders = { { dt = 3 } }", "study.ladders[1].dt: expected a list"},
      {"refined_substep = 3", "did you mean 'refined_substeps'"},
  };
  for (const auto& [text, part] : wrong) {
    CAPTURE(text);
    CHECK_THAT(mistake_in(text), Catch::Contains(part));
  }
}

TEST_CASE("checks compare errors", "[lua][study]") {
  lua::Script script(with_libraries());
  script.load_string(
      "local feder = require 'feder' return feder.scene { build = function() end, check = function(world, scene, "
      "expect)\n"
      "expect.error(1e-4, '<', 1e-3) expect.error(2, '>=', 2) expect(true)\n"
      "expect.error(0 / 0, '<', 1)\n"
      "expect.error(0.5, '<', 1e-3, 'drift')\n"
      "expect(false, 'no')\n"
      "expect.error(1, '~', 2) end }",
      "s.lua");
  script.build();
  const lua::CheckResult result = script.check();
  CHECK(result.passed == 3);
  REQUIRE(result.failures.size() == 4);
  CHECK_THAT(result.failures[0].message, Catch::Contains("error: expected < 1"));
  CHECK(result.failures[1].message == "drift: expected < 0.001, got 0.5");
  CHECK_THAT(result.failures[1].where, Catch::Contains("s.lua:4"));
  CHECK(result.failures[2].message == "no");
  CHECK_THAT(result.failures[3].message, Catch::Contains("expect.error: expected \"<\""));
}

TEST_CASE("a script asks what an option takes", "[lua]") {
  CHECK_THAT(output_of("for _, name in ipairs(feder.choices 'net.integrator') do print(name) end"),
             Catch::Contains("velocity_verlet\n"));
  CHECK_THAT(error_of("feder.choices 'net.mass'"), Catch::Contains("option with choices"));
  CHECK_THAT(error_of("feder.choices 'view.size'"), Catch::Contains("this build leaves out the module 'view'"));
}
