// Plans, shards, ladders and what a sweep says about a problem whose answer is known.

#include <algorithm>

#include "feder/study.h"
#include "study/run.h"
#include "support/catch.h"

using namespace feder;

namespace {

SweepOptions quick() {
  SweepOptions o;
  o.timing.enabled = false;
  return o;
}

std::unique_ptr<StudyProblem> problem(const char* name, std::initializer_list<const char*> options = {}) {
  Params p;
  for (const char* o : options) set_option(p, o);
  return make_study_problem(name, p);
}

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

void check_same_errors(const StudyPoint& a, const StudyPoint& b) {
  CAPTURE(a.index, a.method);
  CHECK(a.index == b.index);
  CHECK(a.method == b.method);
  CHECK(a.status == b.status);
  CHECK(same(a.h_s, b.h_s));
  CHECK(same(a.err_end, b.err_end));
  CHECK(same(a.err_traj_rms, b.err_traj_rms));
  CHECK(same(a.err_energy_max, b.err_energy_max));
  CHECK(same(a.mescd, b.mescd));
  CHECK(a.count.force_evals == b.count.force_evals);
  CHECK(a.on_front_work == b.on_front_work);
}

}  // namespace

TEST_CASE("shards of a sweep merge to the whole, with equal bits", "[study]") {
  const auto p = problem("oscillator");
  SweepOptions o = quick();
  o.ladders = {parse_ladder("steps:10,100,1000")};
  const StudyResult whole = run_sweep(*p, o);
  REQUIRE(whole.points.size() == whole.planned);
  std::vector<StudyResult> parts;
  o.shards = 3;
  for (o.shard = 2; o.shard >= 0; --o.shard) parts.push_back(run_sweep(*p, o));
  std::vector<StudyResult> twice = parts;
  const StudyResult merged = merge_shards(std::move(parts));
  REQUIRE(merged.points.size() == whole.points.size());
  for (std::size_t i = 0; i < whole.points.size(); ++i) check_same_errors(whole.points[i], merged.points[i]);
  CHECK(merged.front_work == whole.front_work);
  CHECK(merged.fits.size() == whole.fits.size());

  twice.push_back(twice.front());
  CHECK_THROWS_AS(merge_shards(twice), SceneError);
  std::vector<StudyResult> strangers = {whole, run_sweep(*problem("oscillator", {"stiffness=4"}), o = quick())};
  CHECK_THROWS_AS(merge_shards(strangers), SceneError);
}

TEST_CASE("ladders are read, and refused with a reason", "[study]") {
  const Ladder h = parse_ladder("h:1e-1..1e-3:x10");
  CHECK(h.axis == "h");
  REQUIRE(h.values.size() == 3);
  CHECK(h.values[2] == Approx(1e-3));
  CHECK(parse_ladder("iters:1..256:x2").values.size() == 9);
  CHECK(parse_ladder("steps:60,600").values[1] == 600);
  for (const char* bad :
       {"", "h", "h:", "h:0", "h:1..2", "h:1..2:x1", "h:1..2:x", "k:1,2", "h:nan", "h:1e-300..1:x1.0001"}) {
    CAPTURE(bad);
    CHECK_THROWS_AS(parse_ladder(bad), SceneError);
  }
}

TEST_CASE("a front has no point that another beats, and leaves out none that nobody beats", "[study]") {
  StudyResult r;
  r.problem.reference.uncertainty = 1e-9;
  const auto add = [&](double work, double error, bool completed = true) {
    StudyPoint p;
    p.index = r.points.size();
    p.method = "m";
    p.work = work, p.err_end = error, p.completed = completed;
    r.points.push_back(p);
  };
  add(10, 1e-1), add(20, 1e-2), add(20, 2e-2), add(30, 5e-2), add(5, 1e-4, false), add(100, 1e-10), add(200, 1e-12);
  evaluate(r);
  CHECK(r.front_work == std::vector<std::size_t>{0, 1, 5});  // below the floor the cheaper one is as good
}

TEST_CASE("orders of synthetic points are found, floor and coarse rungs left out", "[study]") {
  StudyResult r;
  r.problem.reference.uncertainty = 1e-10;
  r.methods = {{"third", "", 3, 1, 0, false, false}};
  for (int k = 0; k < 12; ++k) {
    StudyPoint p;
    p.index = r.points.size();
    p.method = "third";
    p.h_s = std::pow(0.5, k);
    p.work = std::pow(2.0, k);
    p.completed = true;
    p.err_end = p.err_traj_rms = std::max(7 * std::pow(p.h_s, 3), 1e-10);
    p.below_floor = p.err_end < r.problem.reference.floor();
    r.points.push_back(p);
  }
  evaluate(r);
  REQUIRE(r.fits.size() == 1);
  CHECK(r.fits[0].slope == Approx(3).epsilon(1e-9));
  CHECK(r.fits[0].expected == 3);
  // cost at an error of 1e-3: h = (1e-3/7)^(1/3), work = 1/h
  const auto at = std::find_if(r.cost_to_accuracy.begin(), r.cost_to_accuracy.end(),
                               [](auto& c) { return std::fabs(c.target - 1e-3) < 1e-9; });
  REQUIRE(at != r.cost_to_accuracy.end());
  CHECK(at->h_s == Approx(std::cbrt(1e-3 / 7)));
  CHECK(at->work == Approx(1 / std::cbrt(1e-3 / 7)));
  for (const CostToAccuracy& c : r.cost_to_accuracy) CHECK(c.target > r.problem.reference.floor());
}

TEST_CASE("a winner is ranked along its run and holds at every finer step", "[study]") {
  StudyResult r;
  r.methods = {{"lucky", "", 2, 1, 0, false, false}, {"steady", "", 2, 1, 0, false, false}};
  const auto add = [&](const char* method, int k, double end, double along, PointStatus status = PointStatus::ok) {
    StudyPoint p;
    p.index = r.points.size();
    p.method = method, p.status = status;
    p.h_s = std::pow(0.5, k), p.work = std::pow(2.0, k);
    p.err_end = end, p.err_traj_rms = along, p.completed = status == PointStatus::ok;
    r.points.push_back(p);
  };
  // small at one instant, small along one run, and above the target again where the steps are finer
  add("lucky", 1, 1e-9, 3e-2), add("lucky", 2, 1e-3, 1e-3), add("lucky", 3, 2e-2, 2e-2), add("lucky", 4, 5e-3, 5e-3);
  add("steady", 1, 1, 5e-2), add("steady", 5, 1, 4e-3), add("steady", 6, 1, 4e-4), add("steady", 7, 1, 3e-4);
  const auto winner = [&](double target) -> std::string {
    evaluate(r);
    for (const CostToAccuracy& c : r.cost_to_accuracy)
      if (std::fabs(c.target / target - 1) < 1e-6 && c.cheapest_work) return c.method;
    return "";
  };
  CHECK(winner(0.1) == "lucky");
  CHECK(winner(1e-2) == "lucky");  // from its fourth point on
  CHECK(winner(1e-3) == "steady");
  for (const CostToAccuracy& c : r.cost_to_accuracy)
    if (c.method == "lucky" && std::fabs(c.target - 1e-2) < 1e-9) CHECK(c.work > 8);
  // a finer run that fails takes the claim away
  add("steady", 8, NAN, NAN, PointStatus::diverged);
  CHECK(winner(1e-3).empty());
}

TEST_CASE("rungs that rounding decides are left out of orders, and orders that miss theory are marked", "[study]") {
  const bool known = GENERATE(false, true);
  CAPTURE(known);
  StudyResult r;
  r.problem.reference.uncertainty = 1e-12;
  r.methods = {{"fourth", "", 4, 1, 0, false, false}};
  for (int k = 2; k < 14; ++k) {
    StudyPoint p;
    p.index = r.points.size();
    p.method = "fourth";
    p.h_s = std::pow(0.5, k), p.work = std::pow(2.0, k), p.completed = true;
    const double noise = 3e-9 * std::pow(2.0, k);  // grows as steps get finer
    p.err_end = p.err_traj_rms = std::pow(p.h_s, 4) + noise;
    if (known) p.noise = noise;
    p.below_floor = p.err_end < p.floor(r.problem.reference);
    r.points.push_back(p);
  }
  CHECK(r.points.back().below_floor == known);
  evaluate(r);
  REQUIRE(r.fits.size() == 1);
  CAPTURE(r.fits[0].slope);
  CHECK(r.fits[0].off() == !known);
}

TEST_CASE("what rounding does to a run is measured by a twin", "[study]") {
  const auto kepler = problem("kepler", {"e=0.6"});
  const auto noise = [&](int steps) {
    MethodInfo rk4;
    for (const MethodInfo& m : kepler->methods())
      if (m.name == "rk4") rk4 = m;
    RunSpec spec;
    spec.method = "rk4", spec.steps = steps;
    StudyPoint p;
    run_point(*kepler, rk4, spec, {}, {}, p, nullptr);
    CHECK(p.completed);
    return p;
  };
  const StudyPoint fine = noise(40000);
  CAPTURE(fine.noise, fine.err_end, fine.err_traj_max);
  CHECK(fine.noise > static_cast<double>(kEpsilon));
  // truncation is 1e-9 here: what is left in the float build is noise, and known as such
  if (sizeof(Real) == 4) {
    CHECK(fine.below_floor);
    CHECK(fine.err_traj_max < 10 * fine.noise);
  }
}

TEST_CASE("settings of a scene are problems of their own: fronts and orders for each, costs of the dearest",
          "[study]") {
  StudyResult r;
  r.methods = {{"m", "", 2, 1, 0, false, false}};
  for (const double scale : {1.0, 100.0})
    for (int k = 1; k < 11; ++k) {
      StudyPoint p;
      p.index = r.points.size();
      p.method = "m";
      p.settings = {{"scale", scale == 1 ? "1" : "100"}};
      p.h_s = std::pow(0.5, k), p.work = std::pow(2.0, k);
      p.err_end = scale * p.h_s * p.h_s, p.completed = true;
      r.points.push_back(p);
    }
  evaluate(r);
  CHECK(r.front_work.size() == 20);
  REQUIRE(r.fits.size() == 2);
  for (const OrderFit& f : r.fits) CHECK(f.slope == Approx(2).margin(1e-9));
  const auto cost = [&](double target) {
    for (const CostToAccuracy& c : r.cost_to_accuracy)
      if (std::fabs(c.target / target - 1) < 1e-6) return c.work;
    return 0.0;
  };
  CHECK(cost(0.1) == Approx(std::sqrt(100 / 0.1)));
  CHECK(cost(1e-5) == 0);  // the other setting does not get there
}

TEST_CASE("timing fills seconds and changes no error", "[study]") {
  const auto p = problem("oscillator");
  SweepOptions o = quick();
  o.methods = {"rk4"};
  o.ladders = {parse_ladder("steps:10,100")};
  const StudyResult without = run_sweep(*p, o);
  o.timing = {true, 1, 3, 3, 0, 1, 1.15};
  const StudyResult with = run_sweep(*p, o);
  for (std::size_t i = 0; i < 2; ++i) {
    check_same_errors(with.points[i], without.points[i]);
    CHECK(std::isnan(without.points[i].t_min_s));
    CHECK(with.points[i].n_rep == 3);
    CHECK(with.points[i].t_min_s > 0);
    CHECK(with.points[i].t_med_s >= with.points[i].t_min_s);
    CHECK(with.points[i].t_p90_s >= with.points[i].t_med_s);
  }
  CHECK(with.points[1].t_min_s > with.points[0].t_min_s);
}

TEST_CASE("unknown methods and options are refused with what is known", "[study]") {
  const auto p = problem("oscillator");
  SweepOptions o = quick();
  o.methods = {"rk5"};
  CHECK_THROWS_WITH(plan_sweep(*p, o), Catch::Contains("rk4"));
  CHECK_THROWS_WITH(problem("oscillator", {"stifness=3"}), Catch::Contains("stiffness"));
  CHECK_THROWS_AS(problem("oscillator", {"stiffness=-3"}), SceneError);
  CHECK_THROWS_AS(problem("oscilator"), SceneError);
  CHECK_THROWS_AS(problem("oscillator", {"stiffness"}), SceneError);
}
