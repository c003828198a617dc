#include "study/cloth_problem.h"

#include <algorithm>

#include "cloth/solver.h"

namespace feder {
namespace {

class ClothRun final : public StudyRun {
 public:
  ClothRun(const ClothProblem& problem, const RunSpec& spec)
      : world_(describe(problem, spec), catalog()), cloth_(world_.need<Cloth>()) {
    ClothDesc d = problem.desc();
    d.solver = spec.method;
    // an explicit method takes the small steps its stability needs
    Arena unused("study");
    const bool sheds =
        find_variant(cloth_solvers(), spec.method, "cloth solver").make(unused, Params())->sheds_strain();
    d.substeps = sheds ? 1 : 0;
    if (spec.iterations > 0 && sheds) d.solver_options.set("iterations", static_cast<double>(spec.iterations));
    id_ = cloth_.add_cloth(d);
    for (std::size_t i = 0; i < cloth_.vertex_count(id_); ++i) {
      const double* x = &problem.rest()[3 * i];
      cloth_.set_point(id_, i, Vec3(static_cast<Real>(x[0]), static_cast<Real>(x[1]), static_cast<Real>(x[2])));
      if (!problem.pull().empty()) cloth_.set_script_force(id_, i, Vec3(0, static_cast<Real>(-problem.pull()[i]), 0));
    }
    elements_ = static_cast<std::int64_t>(cloth_.edge_count(id_));
  }

  void step() override { world_.step(); }

  void observe(Observation& out) override {
    out.x.clear(), out.v.clear(), out.q.clear();
    for (std::size_t i = 0; i < cloth_.vertex_count(id_); ++i) {
      const Vec3 x = cloth_.point(id_, i), v = cloth_.velocity(id_, i);
      for (int k = 0; k < 3; ++k) out.x.push_back(x[k]), out.v.push_back(v[k]);
    }
  }

  Invariants invariants() override {
    Invariants i;
    const Energy e = world_.energy();
    i.energy = e.kinetic + e.potential + e.elastic;
    i.constraint = std::max(0.0, static_cast<double>(cloth_.max_strain(id_)));
    return i;
  }

  StudyCounters counters() const override {
    StudyCounters c;
    c.steps = static_cast<std::int64_t>(world_.step_count());
    c.sweeps = c.steps * world_.desc().substeps * std::max(1, cloth_.substeps(id_));
    c.force_evals = c.sweeps;
    return c;
  }
  std::size_t bytes() const override { return world_.bytes(); }
  bool gave_up() const override { return cloth_.quarantined(id_); }

 private:
  static Catalog catalog() {
    static const SystemDescriptor* const only[] = {&Cloth::descriptor()};
    return only;
  }
  static WorldDesc describe(const ClothProblem& problem, const RunSpec& spec) {
    WorldDesc d;
    d.gravity = Vec3(0, static_cast<Real>(-ClothProblem::kGravity), 0);
    d.dt = problem.info().t_end / spec.steps;
    d.substeps = std::max(1, spec.substeps);
    d.sleeping = false;
    return d;
  }

  World world_;
  Cloth& cloth_;
  ObjectId id_;
  std::int64_t elements_ = 0;
};

}  // namespace

std::vector<MethodInfo> ClothProblem::methods() const {
  std::vector<MethodInfo> all;
  for (const Variant<ClothSolver>& row : cloth_solvers())
    all.push_back({row.name, row.summary, 0, 1, NAN, false, false});
  return all;
}

std::vector<RunSpec> ClothProblem::ladder(const MethodInfo& method) const {
  std::vector<RunSpec> rungs;
  const int steps = std::max(1, static_cast<int>(std::ceil(60 * info_.t_end)));
  for (const int substeps : substeps_) rungs.push_back({method.name, steps, 0, 0, substeps, {}});
  return rungs;
}

std::unique_ptr<StudyRun> ClothProblem::start(const RunSpec& spec) const {
  return std::make_unique<ClothRun>(*this, spec);
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
