#include "study/fluid_problem.h"

#include <algorithm>

#include "collide/collide.h"
#include "couple/fluid_rigid.h"
#include "fluid/solver.h"

namespace feder {
namespace {

constexpr int kSubsteps = 4;

bool iterates(const std::string& solver) {
  Arena unused("study");
  return find_variant(fluid_solvers(), solver, "fluid solver").make(unused, Params())->iterates();
}

}  // namespace

class FluidRun final : public StudyRun {
 public:
  FluidRun(const FluidProblem& problem, const RunSpec& spec)
      : problem_(problem), world_(describe(problem, spec), catalog()) {
    scene_.world = &world_;
    scene_.fluid = &world_.need<Fluid>();
    FluidDesc d;
    d.solver = spec.method;
    d.spacing = static_cast<Real>(problem.spacing_);
    d.stiffness = static_cast<Real>(problem.stiffness_);
    d.compression = static_cast<Real>(problem.compression_);
    if (spec.iterations > 0) d.iterations = spec.iterations;
    if (spec.tolerance > 0) d.compression = static_cast<Real>(spec.tolerance);
    if (iterates(spec.method)) sweeps_ = d.iterations;
    scene_.spacing = problem.spacing_;
    problem.build(scene_, d);
    read();
    scene_.start = problem.start_measure(scene_);
  }

  void step() override {
    world_.step();
    for (const Event& e : world_.events().list())
      if (e.kind == EventKind::warning) warning_ = world_.events().warning_message(e);
    read();
    problem_.after_step(scene_);
  }
  void observe(Observation& out) override {
    out.x.clear(), out.v.clear(), out.q.clear();
    problem_.observe(scene_, out);
  }
  Invariants invariants() override {
    Invariants i;
    double mean = 0;
    world_.query<Fluid>()->density_error(scene_.water, mean, i.constraint);
    return i;
  }
  StudyCounters counters() const override {
    StudyCounters c;
    c.steps = static_cast<std::int64_t>(world_.step_count());
    // density and pressure of all particles count as one evaluation
    c.force_evals = c.sweeps = static_cast<std::int64_t>(scene_.fluid->own_steps(scene_.water)) * sweeps_;
    return c;
  }
  std::size_t bytes() const override { return world_.bytes(); }
  bool gave_up() const override { return !scene_.fluid->finite(); }
  double own_error() const override { return problem_.error(scene_); }
  std::string warning() const override { return warning_; }

 private:
  void read() {
    scene_.fluid->positions(scene_.water, scene_.positions);
    scene_.fluid->velocities(scene_.water, scene_.velocities);
  }
  static Catalog catalog() {
    static const SystemDescriptor* const list[] = {&Collide::descriptor(), &Rigid::descriptor(), &Fluid::descriptor(),
                                                   &FluidRigid::descriptor()};
    return list;
  }
  static WorldDesc describe(const FluidProblem& problem, const RunSpec& spec) {
    WorldDesc d;
    d.dimension = 2;
    d.gravity = problem.gravity();
    d.dt = problem.info().t_end / spec.steps;
    d.substeps = spec.substeps > 0 ? spec.substeps : kSubsteps;
    d.sleeping = false;
    return d;
  }

  const FluidProblem& problem_;
  World world_;
  mutable FluidScene scene_;
  std::string warning_;
  int sweeps_ = 1;  // of a step of the solver
};

std::vector<MethodInfo> FluidProblem::methods() const {
  std::vector<MethodInfo> all;
  for (const Variant<FluidSolver>& row : fluid_solvers())
    all.push_back({row.name, row.summary, 0, 1, NAN, false, false});
  return all;
}

// Around a frame rate and four substeps: more substeps, shorter steps, and more of what the solver refines by.
std::vector<RunSpec> FluidProblem::ladder(const MethodInfo& method) const {
  std::vector<RunSpec> rungs;
  const auto steps = [&](double factor) { return static_cast<int>(std::ceil(factor * rate_ * info_.t_end)); };
  for (const int n : {1, 2, 4, 8}) rungs.push_back({method.name, steps(1), 0, 0, n, {}, "substeps"});
  for (const double factor : {0.25, 0.5, 1.0, 2.0})
    rungs.push_back({method.name, steps(factor), 0, 0, kSubsteps, {}, "steps"});
  if (iterates(method.name)) {
    for (const int n : {1, 2, 4, 8, 16}) rungs.push_back({method.name, steps(1), 0, n, kSubsteps, {}, "iters"});
  } else {
    for (const double c : {0.1, 0.03, 0.01, 0.003})
      rungs.push_back({method.name, steps(1), c, 0, kSubsteps, {}, "tol"});
  }
  return rungs;
}

std::unique_ptr<StudyRun> FluidProblem::start(const RunSpec& spec) const {
  return std::make_unique<FluidRun>(*this, spec);
}

void FluidProblem::common(ProblemOptions& o, int per_length, double t_end) {
  const int n = o.integer("particles", per_length, 5, 400, "across the length that the problem is about");
  spacing_ = 1.0 / n;
  stiffness_ = o.number("stiffness", 0, 0, 1e12, "bulk modulus for pbf, Pa; 0: as stiff as it can");
  compression_ = o.number("compression", 0.01, 1e-4, 0.2, "that wcsph aims at");
  rate_ = o.integer("rate", 60, 10, 10000, "steps a second");
  info_.t_end = o.number("t_end", t_end, 1e-3, 60, "s");
}

void FluidProblem::scales(double length, double speed, ReferenceKind kind, double uncertainty, double spacings,
                          const char* source) {
  info_.x_scale = length, info_.v_scale = speed;
  set_reference(kind, kind == ReferenceKind::published ? 2 : 6, uncertainty, source);
  info_.reference.resolution = spacings * spacing_ / length;
}

void FluidProblem::add_wall(World& w, const Vec3& normal, double distance) {
  BodyDesc b;
  b.type = BodyType::fixed;
  b.shape = make_plane(normal, static_cast<Real>(distance));
  w.need<Rigid>().add_body(b);
}

void FluidProblem::add_water(FluidScene& s, double width, double height, double x, double y) {
  const double d = static_cast<double>(s.fluid->desc(s.water).spacing);
  const int nx = static_cast<int>(std::lround(width / d)), ny = static_cast<int>(std::lround(height / d));
  std::vector<Vec3> points;
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i)
      points.push_back(
          Vec3(static_cast<Real>(x + (i + 0.5) * width / nx), static_cast<Real>(y + (j + 0.5) * height / ny), 0));
  s.fluid->fill(s.water, points, Vec3::Zero());
}

}  // namespace feder
