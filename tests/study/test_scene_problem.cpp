// Any world as a problem: the reference is found by refinement, its uncertainty told.
#include "feder/net.h"
#include "feder/study.h"
#include "study/scene_problem.h"
#include "support/catch.h"

using namespace feder;

namespace {

// A mass on a spring; "stiffness" is a setting, the method is the integrator.
class SpringWorld : public SceneWorld {
 public:
  explicit SpringWorld(const RunSpec& spec) {
    WorldDesc d;
    d.gravity = Vec3::Zero();
    d.dt = 1.0 / spec.steps;
    d.substeps = std::max(1, spec.substeps);
    static const SystemDescriptor* const catalog[] = {&Springs::descriptor()};
    world_ = std::make_unique<World>(d, catalog);
    NetDesc net;
    net.points = {Vec3(0, 0, 0), Vec3(Real(1.5), 0, 0)};
    net.masses = {1, 1};
    double stiffness = 30;
    for (const auto& [name, value] : spec.settings)
      if (name == "stiffness") stiffness = std::stod(value);
    net.springs = {{0, 1, static_cast<Real>(stiffness), 0, 1, kInfinity}};
    net.integrator = spec.method;
    net_ = world_->need<Springs>().add_net(net);
    world_->need<Springs>().pin(net_, 0);
    exact_ = 1 + 0.5 * std::cos(std::sqrt(stiffness));
  }
  World& world() override { return *world_; }
  void step() override { world_->step(); }
  double own_error(std::span<const double>) override {
    return std::fabs(static_cast<double>(world_->need<Springs>().point(net_, 1)[0]) - exact_);
  }

 private:
  std::unique_ptr<World> world_;
  ObjectId net_;
  double exact_;
};

SceneDescription description() {
  SceneDescription d;
  d.info.name = "spring";
  d.info.t_end = 1;
  d.dt = 0.01;
  d.methods = {{"velocity_verlet", "", 2, 1, 2, false, false}, {"rk4", "", 4, 4, 2.8, false, false}};
  d.make = [](const RunSpec& spec) { return std::make_unique<SpringWorld>(spec); };
  return d;
}

StudyResult sweep(SceneDescription d) {
  const SceneProblem problem(std::move(d));
  SweepOptions o;
  o.timing.enabled = false;
  return run_sweep(problem, o);
}

}  // namespace

TEST_CASE("a refined reference is close, says how close, and finds the orders", "[study]") {
  const StudyResult r = sweep(description());
  CHECK(r.problem.reference.kind == ReferenceKind::self);
  // Verlet with 1/51200 s: (w h)^2/24 w t of the amplitude, plus rounding
  CHECK(r.problem.reference.uncertainty > 0);
  CHECK(r.problem.reference.uncertainty < (sizeof(Real) == 8 ? 1e-8 : 1e-3));
  CHECK(r.problem.reference.source.find("1/64") != std::string::npos);
  CHECK(r.points.size() == 10);
  for (const StudyPoint& p : r.points) CHECK(p.status == PointStatus::ok);
  if (sizeof(Real) == 8) {
    REQUIRE(r.fits.size() == 2);
    CHECK(r.fits[0].slope == Approx(2).margin(0.1));
    CHECK(r.fits[1].slope == Approx(4).margin(0.2));
  }
}

TEST_CASE("settings have references of their own", "[study]") {
  SceneDescription d = description();
  d.methods.resize(1);
  d.ladders.resize(1);
  d.ladders[0].steps = {100, 400};
  d.ladders[0].settings = {{"stiffness", {"30", "300"}}};
  const StudyResult r = sweep(std::move(d));
  REQUIRE(r.points.size() == 4);
  CHECK(r.problem.reference.source.find("twice") != std::string::npos);
  for (const StudyPoint& p : r.points) {
    CAPTURE(p.settings.at(0).second, p.h_s);
    CHECK(p.err_end < 0.2);
    CHECK(p.err_end > 0);
  }
  // sixteen times less with a quarter of the step, for both
  if (sizeof(Real) == 8)
    for (const std::size_t k : {0u, 1u}) {
      const auto of = [&](const char* stiffness, double h) {
        for (const StudyPoint& p : r.points)
          if (p.settings.at(0).second == stiffness && std::fabs(p.h_s - h) < 1e-9) return p.err_traj_rms;
        return 0.0;
      };
      const char* const stiffness = k == 0 ? "30" : "300";
      CHECK(of(stiffness, 0.01) / of(stiffness, 0.0025) == Approx(16).epsilon(0.1));
    }
}

TEST_CASE("a scene's own error stands for the error at the end", "[study]") {
  SceneDescription d = description();
  d.has_error = true;
  d.reference = SceneDescription::Reference::none;
  d.ladders.resize(1);
  d.ladders[0].steps = {100, 1000};
  const StudyResult r = sweep(std::move(d));
  REQUIRE(r.points.size() == 4);
  for (const StudyPoint& p : r.points) {
    CHECK(p.completed);
    CHECK(p.err_end < 1e-2);
    CHECK(std::isnan(p.err_traj_rms));
  }
  CHECK(r.points[1].err_end < r.points[0].err_end);
}

TEST_CASE("a scene knows its course at any time", "[study]") {
  class Exact final : public SpringWorld {
   public:
    using SpringWorld::SpringWorld;
    void reference(double t, Observation& out) override {
      out.x = {1 + 0.5 * std::cos(std::sqrt(30.0) * t), 0, 0};
      out.v = {-0.5 * std::sqrt(30.0) * std::sin(std::sqrt(30.0) * t), 0, 0};
    }
    double reference_energy(double) override { return 0.5 * 30 * 0.25; }
    double event_error() override { return 0.125; }
    double constraint() override { return 0.25; }
  };
  SceneDescription d = description();
  d.reference = SceneDescription::Reference::course;
  d.info.energy_scale = 1;
  d.ladders.resize(2);
  d.ladders[0].steps = {100, 400}, d.ladders[0].refinement_axis = "steps";
  d.ladders[1].substeps = {2, 4}, d.ladders[1].refinement_axis = "substeps", d.ladders[1].methods = {"rk4"};
  d.make = [](const RunSpec& spec) { return std::make_unique<Exact>(spec); };
  const StudyResult r = sweep(std::move(d));
  REQUIRE(r.points.size() == 6);
  for (const StudyPoint& p : r.points) {
    CAPTURE(p.method, p.h_s, p.substeps);
    CHECK(p.err_end < 1e-2);
    CHECK(p.err_traj_rms < 1e-2);
    CHECK(p.err_energy_max < 0.2);
    CHECK(p.err_event_s == 0.125);
    CHECK(p.err_constraint == 0.25);
  }
  CHECK(r.points[1].err_traj_rms < r.points[0].err_traj_rms / 10);
  CHECK(r.points[4].refinement_axis == "substeps");
  CHECK(r.points[4].h_s == 0.01);
}

TEST_CASE("a run refined by substeps is compared by what both left at the end", "[study]") {
  SceneDescription d = description();
  d.refined_substeps = 64;
  d.has_error = true;
  d.ladders.resize(1);
  d.ladders[0].steps = {50, 100};
  class Measured final : public SpringWorld {
   public:
    using SpringWorld::SpringWorld;
    double own_error(std::span<const double> refined) override {
      return refined.empty() ? NAN : std::fabs(measure()[0] - refined[0]);
    }
  };
  d.make = [](const RunSpec& spec) { return std::make_unique<Measured>(spec); };
  const StudyResult r = sweep(std::move(d));
  CHECK(r.problem.reference.source.find("64 substeps") != std::string::npos);
  REQUIRE(r.points.size() == 4);
  for (const StudyPoint& p : r.points) {
    CHECK(p.err_end < 1e-2);
    CHECK(p.err_traj_rms < 1e-2);
  }
}

TEST_CASE("values stated for the end are the reference there", "[study]") {
  SceneDescription d = description();
  d.methods.resize(1);
  d.ladders.resize(1);
  d.ladders[0].steps = {2000};
  d.reference = SceneDescription::Reference::stated;
  d.stated = {1 + 0.5 * std::cos(std::sqrt(30.0)) + 0.25, 0, 0};
  const StudyResult r = sweep(std::move(d));
  REQUIRE(r.points.size() == 1);
  CHECK(r.points[0].err_end == Approx(0.25).margin(1e-4));
}
