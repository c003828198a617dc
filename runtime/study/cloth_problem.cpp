#include "study/cloth_problem.h"

#include <algorithm>

#include "cloth/solver.h"
#include "contact/surface_contact.h"
#include "couple/cloth_rigid.h"
#include "couple/surface_rigid.h"

namespace feder {
namespace {

std::unique_ptr<ClothSolver> make_solver(const std::string& name, const Params& options) {
  Arena unused("study");
  return find_variant(cloth_solvers(), name, "cloth solver").make(unused, options);
}

bool takes_iterations(const std::string& name) {
  Params options;
  options.set("iterations", 2.0);
  try {
    make_solver(name, options);
    options.check_all_read(name);
  } catch (const SceneError&) {
    return false;
  }
  return true;
}

class ClothRun final : public StudyRun {
 public:
  ClothRun(const ClothProblem& problem, const RunSpec& spec)
      : problem_(problem), world_(describe(problem, spec), catalog()), cloth_(world_.need<Cloth>()) {
    ClothDesc d = problem.desc();
    d.solver = spec.method;
    // an explicit method takes the small steps its stability needs
    d.substeps = make_solver(spec.method, Params())->sheds_strain() ? 1 : 0;
    if (spec.iterations > 0) {
      d.solver_options.set("iterations", static_cast<double>(spec.iterations));
      sweeps_ = spec.iterations;
    }
    problem.add_bodies(world_);
    id_ = cloth_.add_cloth(d);
    for (std::size_t i = 0; i < cloth_.vertex_count(id_) && !problem.rest().empty(); ++i) {
      const double* x = &problem.rest()[3 * i];
      cloth_.set_point(id_, i, Vec3(static_cast<Real>(x[0]), static_cast<Real>(x[1]), static_cast<Real>(x[2])));
      if (!problem.pull().empty()) cloth_.set_script_force(id_, i, Vec3(0, static_cast<Real>(-problem.pull()[i]), 0));
    }
  }

  void step() override {
    world_.step();
    small_steps_ += world_.desc().substeps * std::max(1, cloth_.substeps(id_));
    for (const Event& e : world_.events().list())
      if (e.kind == EventKind::warning) warning_ = world_.events().warning_message(e);
    if (!problem_.rest().empty()) return;
    problem_.observe(cloth_, id_, seen_);
    heights_.push_back(seen_.x[1]);
  }

  void observe(Observation& out) override {
    out.x.clear(), out.v.clear(), out.q.clear();
    problem_.observe(cloth_, id_, out);
  }

  Invariants invariants() override {
    Invariants i;
    const Energy e = world_.energy();
    if (!problem_.rest().empty()) i.energy = e.kinetic + e.potential + e.elastic;
    i.constraint = std::max(0.0, static_cast<double>(cloth_.max_strain(id_)));
    return i;
  }

  StudyCounters counters() const override {
    StudyCounters c;
    c.steps = static_cast<std::int64_t>(world_.step_count());
    c.sweeps = c.force_evals = small_steps_ * sweeps_;
    return c;
  }
  std::size_t bytes() const override { return world_.bytes(); }
  bool gave_up() const override { return cloth_.quarantined(id_); }
  std::string warning() const override { return warning_; }
  double own_error() const override { return problem_.own_error(heights_); }

 private:
  static Catalog catalog() {
    static const SystemDescriptor* const list[] = {&Collide::descriptor(),        &Rigid::descriptor(),
                                                   &SurfaceContact::descriptor(), &SurfaceRigid::descriptor(),
                                                   &Cloth::descriptor(),          &ClothRigid::descriptor()};
    return list;
  }
  static WorldDesc describe(const ClothProblem& problem, const RunSpec& spec) {
    WorldDesc d;
    d.gravity = Vec3(0, static_cast<Real>(-ClothProblem::kGravity), 0);
    d.dt = problem.info().t_end / spec.steps;
    d.substeps = std::max(1, spec.substeps);
    d.sleeping = false;
    return d;
  }

  const ClothProblem& problem_;
  World world_;
  Cloth& cloth_;
  ObjectId id_;
  std::string warning_;
  std::int64_t small_steps_ = 0;
  int sweeps_ = 1;  // of a small step
  Observation seen_;
  std::vector<double> heights_;
};

}  // namespace

std::vector<MethodInfo> ClothProblem::methods() const {
  std::vector<MethodInfo> all;
  for (const Variant<ClothSolver>& row : cloth_solvers())
    all.push_back({row.name, row.summary, 0, 1, NAN, false, false});
  return all;
}

// Around a frame rate: more substeps, shorter steps, and more iterations of few substeps. A solver that chooses its own
// small steps needs no more of them: it gets a part of the ladder.
std::vector<RunSpec> ClothProblem::ladder(const MethodInfo& method) const {
  std::vector<RunSpec> rungs;
  const auto steps = [&](double factor) {
    return std::max(1, static_cast<int>(std::ceil(kRate * factor * info_.t_end)));
  };
  const bool sheds = make_solver(method.name, Params())->sheds_strain();
  const int few = substeps_[1], middle = substeps_[substeps_.size() / 2];
  for (const int substeps : substeps_)
    if (sheds || substeps <= middle) rungs.push_back({method.name, steps(1), 0, 0, substeps, {}, "substeps"});
  for (const double factor : {0.25, 0.5, 1.0, 2.0, 4.0})
    if (sheds || factor <= 1) rungs.push_back({method.name, steps(factor), 0, 0, middle, {}, "steps"});
  if (takes_iterations(method.name))
    for (const int n : {1, 2, 4, 8, 16, 32}) rungs.push_back({method.name, steps(1), 0, n, few, {}, "iters"});
  return rungs;
}

std::unique_ptr<StudyRun> ClothProblem::start(const RunSpec& spec) const {
  return std::make_unique<ClothRun>(*this, spec);
}

void ClothProblem::observe(const Cloth& cloth, ObjectId id, Observation& out) const {
  out.x.clear(), out.v.clear(), out.q.clear();
  for (std::size_t i = 0; i < cloth.vertex_count(id); ++i) {
    const Vec3 x = cloth.point(id, i), v = cloth.velocity(id, i);
    for (int k = 0; k < 3; ++k) out.x.push_back(x[k]), out.v.push_back(v[k]);
  }
}

void ClothProblem::reference(double, Observation& out) const {
  out.x = rest_;
  out.v.assign(rest_.size(), 0);
  out.q.clear();
}

void ClothProblem::measure(double length, const char* source) {
  info_.dof = static_cast<int>(rest_.size());
  info_.dense = false;
  info_.x_scale = length, info_.v_scale = std::sqrt(kGravity * length);
  double mass =
      static_cast<double>(desc_.area_density) * static_cast<double>(desc_.size[0]) * static_cast<double>(desc_.size[1]);
  for (const double f : pull_) mass += f / kGravity;
  info_.energy_scale = mass * kGravity * length;
  set_reference(ReferenceKind::closed, 12, 1e-9, source);
  // positions of a metre are rounded, and stiffness makes forces of it
  info_.reference.rounding *= 10;
  const Invariants start_energy = start({methods().front().name, 60, 0, 0, 1, {}})->invariants();
  info_.energy_start = start_energy.energy;
}

}  // namespace feder
