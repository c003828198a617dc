#include "study/rigid_problem.h"

#include <algorithm>

#include "collide/collide.h"
#include "rigid/solver.h"

namespace feder {
namespace {

Catalog rigid_catalog() {
  static const SystemDescriptor* const catalog[] = {&Collide::descriptor(), &Rigid::descriptor()};
  return catalog;
}

WorldDesc describe(const RigidProblem& problem, const RunSpec& spec, int substeps) {
  WorldDesc d;
  d.gravity = Vec3(0, static_cast<Real>(-problem.gravity()), 0);
  d.dt = problem.info().t_end / spec.steps;
  d.substeps = spec.substeps > 0 ? spec.substeps : substeps;
  d.sleeping = false;
  d.systems["rigid"].set("solver", spec.method);
  if (spec.iterations > 0) d.systems["rigid"].set("iterations", static_cast<double>(spec.iterations));
  return d;
}

std::array<double, 3> wide(const Vec3& a) { return {double(a[0]), double(a[1]), double(a[2])}; }

class RigidRun final : public StudyRun {
 public:
  RigidRun(const RigidProblem& problem, const RunSpec& spec, int substeps)
      : problem_(problem), world_(describe(problem, spec, substeps), rigid_catalog()), rigid_(world_.need<Rigid>()) {
    problem.build(world_, observed_);
    now_ = read();
  }

  void step() override {
    world_.step();
    if (!problem_.has_event()) return;
    before_ = now_;
    now_ = read();
    problem_.event(before_, now_, events_, event_error_);
  }

  void observe(Observation& out) override { problem_.observe(rigid_, observed_, out); }

  Invariants invariants() override {
    Invariants i;
    const Energy e = world_.energy();
    i.energy = e.kinetic + e.potential + e.elastic;
    const Momentum p = world_.momentum();
    for (int k = 0; k < 3; ++k) i.momentum[k] = p.linear[k], i.angular[k] = p.angular[k];
    double linear = 0, angular = 0;
    for (int k = 0; k < 3; ++k) linear += p.linear[k] * p.linear[k], angular += p.angular[k] * p.angular[k];
    i.momentum_scale = std::sqrt(linear), i.angular_scale = std::sqrt(angular);
    i.constraint = problem_.constraint(world_);
    if (std::isnan(i.constraint))
      i.constraint = std::max(0.0, static_cast<double>(world_.need<Collide>().max_penetration())) / problem_.size();
    return i;
  }

  StudyCounters counters() const override {
    StudyCounters c;
    c.steps = static_cast<std::int64_t>(world_.step_count());
    c.force_evals = c.sweeps = c.steps * world_.desc().substeps;
    return c;
  }
  std::size_t bytes() const override { return world_.bytes(); }
  bool gave_up() const override { return !rigid_.finite(); }
  double event_error() const override { return event_error_; }

 private:
  BodyNow read() const {
    const std::uint32_t i = rigid_.index(observed_.front());
    const Bodies& b = rigid_.bodies();
    return {world_.time(), wide(b.position[i]), wide(b.velocity[i]), wide(b.angular_velocity[i])};
  }

  const RigidProblem& problem_;
  World world_;
  Rigid& rigid_;
  std::vector<ObjectId> observed_;
  BodyNow before_, now_;
  int events_ = 0;
  double event_error_ = NAN;
};

}  // namespace

std::vector<MethodInfo> RigidProblem::methods() const {
  std::vector<MethodInfo> all;
  for (const Variant<RigidSolver>& row : rigid_solvers())
    all.push_back({row.name, row.summary, 0, 1, NAN, false, false});
  return all;
}

std::vector<RunSpec> RigidProblem::ladder(const MethodInfo& method) const {
  std::vector<RunSpec> rungs;
  for (const int steps : steps_) rungs.push_back({method.name, steps, 0, 0, substeps_, {}});
  return rungs;
}

std::unique_ptr<StudyRun> RigidProblem::start(const RunSpec& spec) const {
  return std::make_unique<RigidRun>(*this, spec, substeps_);
}

void RigidProblem::observe(const Rigid& rigid, std::span<const ObjectId> observed, Observation& out) const {
  out.x.clear(), out.v.clear(), out.q.clear();
  const Bodies& b = rigid.bodies();
  for (const ObjectId id : observed) {
    const std::uint32_t i = rigid.index(id);
    for (int k = 0; k < 3; ++k) out.x.push_back(b.position[i][k]), out.v.push_back(b.velocity[i][k]);
    if (!orientations_) continue;
    const Quat& q = b.rotation[i];
    out.q.insert(out.q.end(), {double(q.x), double(q.y), double(q.z), double(q.w)});
  }
}

double RigidProblem::reference_energy(double t) const {
  return point_mass_ > 0 ? energy_of_point(t, point_mass_) : info_.energy_start;
}

double RigidProblem::energy_of_point(double t, double mass) const {
  Observation o;
  reference(t, o);
  return mass * (0.5 * (o.v[0] * o.v[0] + o.v[1] * o.v[1] + o.v[2] * o.v[2]) + gravity_ * o.x[1]);
}

BodyDesc RigidProblem::body(ShapePtr shape, const Vec3& position, double mass, double friction) {
  BodyDesc d;
  d.shape = std::move(shape);
  d.position = position;
  d.mass = static_cast<Real>(mass);
  d.friction_static = d.friction_dynamic = static_cast<Real>(friction);
  return d;
}

BodyDesc RigidProblem::ground(double friction, const Vec3& normal) {
  BodyDesc d;
  d.type = BodyType::fixed;
  d.shape = make_plane(normal, 0);
  d.friction_static = d.friction_dynamic = static_cast<Real>(friction);
  return d;
}

}  // namespace feder
