// The rigid system to the world: descriptor, passes, hash, snapshots, conserved quantities and residuals. The work is
// in bodies.cpp, rows.cpp, sleep.cpp and joints.cpp.
#include "feder/rigid.h"

#include "constrain/joint.h"
#include "forces/forces.h"
#include "rigid/impl.h"
#include "state/bodies.h"
#include "state/colliders.h"
#include "state/contacts.h"
#include "state/solver_bodies.h"
#include "step/watch.h"

namespace feder {

Rigid::Impl::Impl(SystemSetup& s)
    : store(s.store), arena(s.store.arena(kName)), watched(s.store.need<Watch>("watch")), objects(s.objects),
      events(s.events), commands(s.commands),
      collide(dynamic_cast<ContactService&>(*s.systems.find_system(ContactService::kSystem))),
      bodies(s.store.need<Bodies>(kName)), colliders(s.store.need<Colliders>(ContactService::kSystem)),
      contacts(s.store.need<Contacts>(ContactService::kSystem)), solver_bodies(s.store.need<SolverBodies>(kName)),
      dimension(s.dimension), structure_changed(s.structure_changed),
      solver(rigid_solver(s.options).make(arena, s.options)) {
  if (solver_bodies.index.empty()) solver_bodies.reset();
}

const SystemDescriptor& Rigid::descriptor() {
  static const char* const needs[] = {ContactService::kSystem};
  static constexpr ObjectKind kinds[] = {kBodyKind, kJointKind};
  static constexpr EventKind events[] = {kJointBreak, kCarved};
  static const SystemDescriptor d = {.name = kName,
                                     .units = "bodies",
                                     .unit = "body",
                                     .needs = needs,
                                     .kinds = kinds,
                                     .events = events,
                                     .make = &make_system<Rigid>};
  return d;
}

Rigid::Rigid(SystemSetup& setup) : impl_(std::make_unique<Impl>(setup)) {}
Rigid::~Rigid() = default;

// Couplings append their solver bodies between gather and prepare, and have passes before and after solve.
void Rigid::add_passes(StepPlan& plan) {
  Impl* s = impl_.get();
  if (s->body_count == 0) return;
  plan.add<&Impl::update_boxes>(Rank::body_bounds, "update boxes", kName, s);
  plan.add<&Impl::wake_touched>(Rank::wake_touched, "wake touched", kName, s);
  plan.add<&Impl::gather>(Rank::gather_bodies, "gather", kName, s);
  if (s->joint_count) plan.add<&Impl::activate_joints>(Rank::gather_bodies, "joints of awake bodies", kName, s);
  plan.add<&Impl::prepare>(Rank::joint_rows, "prepare rows", kName, s);
  const Forces* forces = s->store.find<Forces>();
  std::size_t count = 0;
  if (forces)
    for (const ForceEntry& f : forces->list) count += f.force != nullptr;
  if (count) plan.add<&Impl::add_forces>(Rank::body_forces, "forces", kName, s);
  if (count != s->force_count) wake_all(WakeCause::force);
  s->force_count = count;
  plan.add<&Impl::integrate_velocities>(Rank::body_velocities, "integrate velocities", kName, s);
  plan.add<&Impl::solve>(Rank::body_solve, "solve", kName, s);
  plan.add<&Impl::finish_solve>(Rank::restitution, "restitution and impulses", kName, s);
  plan.add<&Impl::stop_fast>(Rank::commit, "continuous collision", kName, s);
  plan.add<&Impl::commit>(Rank::commit, "commit", kName, s);
  plan.add<&Impl::refresh>(Rank::query_colliders, "place colliders", kName, s);
}

std::size_t Rigid::count() const { return impl_->body_count; }

void Rigid::hash(Hash& h) const {
  const Bodies& b = impl_->bodies;
  for (std::uint32_t i = 0; i < b.size(); ++i) {
    h.add(b.type[i]), h.add(b.awake[i]);
    if (b.type[i] == BodyType::free) continue;
    h.add(b.position[i]), h.add(b.velocity[i]), h.add(b.angular_velocity[i]);
    h.add(b.rotation[i].vec()), h.add(b.rotation[i].w), h.add(b.sleep_energy[i]);
    if (impl_->asymmetric[i]) h.add(impl_->kept_momentum[i]);
  }
  for (const SolverJoint& j : impl_->joints)
    for (int k = 0; k < j.rows; ++k) h.add(j.impulse[k]);
}

namespace {

// A joint without its pointer.
struct SavedJoint {
  JointRecord record;
  JointShape shape;
  Real impulse[kMaxJointRows];
  std::uint8_t rows;
};

}  // namespace

// Calls f(member) for what snapshots hold, but for the joints.
template <class S, class F>
void Rigid::Impl::each_saved(S& s, F&& f) {
  Bodies::each_saved(s.bodies, f);
  for_each_of(f, s.solver_bodies.index, s.solver_bodies.free_list);
  each_saved_array(s, f);
  f(s.free_joints);
}
template <class S, class F>
void Rigid::Impl::each_saved_number(S& s, F&& f) {
  for_each_of(f, s.body_count, s.sleeping_count, s.joint_count, s.last_h, s.force_count);
}

void Rigid::save(Writer& w) const {
  const Impl& s = *impl_;
  FEDER_ASSERT(s.records.size() == s.joints.size());
  Impl::each_saved(s, saved_to(w));
  std::vector<SavedJoint> saved(s.joints.size());
  for (std::size_t j = 0; j < saved.size(); ++j) {
    std::memset(static_cast<void*>(&saved[j]), 0, sizeof(SavedJoint));
    saved[j].record = s.records[j];
    saved[j].shape = s.joints[j].shape;
    std::copy_n(s.joints[j].impulse, kMaxJointRows, saved[j].impulse);
    saved[j].rows = s.joints[j].rows;
  }
  w.list(saved);
  Impl::each_saved_number(s, saved_to(w));
}

void Rigid::load(Reader& r) {
  Impl& s = *impl_;
  Impl::each_saved(s, loaded_from(r));
  std::vector<SavedJoint> saved;
  r.list(saved);
  s.joints.assign(saved.size(), SolverJoint{});
  s.records.resize(saved.size());
  for (std::size_t j = 0; j < saved.size(); ++j) {
    s.records[j] = saved[j].record;
    s.joints[j].shape = saved[j].shape;
    std::copy_n(saved[j].impulse, kMaxJointRows, s.joints[j].impulse);
    s.joints[j].rows = saved[j].rows;
    if (s.records[j].alive) s.joints[j].kind = &joint_kinds()[s.records[j].kind];
  }
  Impl::each_saved_number(s, loaded_from(r));
  // what follows from the state
  s.resize_arrays();
  for (std::uint32_t j = 0; j < s.joints.size(); ++j)
    if (s.records[j].alive) s.refresh_joint(j);
  s.solver_bodies.clear_indices();
  s.moved.clear(), s.carved_off.clear(), s.unsaid.clear();
  s.list_stale = s.poses_stale = s.joints_stale = true;
  s.active_joints.clear(), s.breakable_joints.clear(), s.joined_bodies.clear();
}

Energy Rigid::energy(const Vec3& gravity) const {
  const Bodies& b = impl_->bodies;
  Energy e;
  const auto d = [](Real x) { return static_cast<double>(x); };
  for (std::uint32_t i = 0; i < b.size(); ++i) {
    if (b.type[i] != BodyType::dynamic) continue;
    const Vec3 w = rotate_inverse(b.rotation[i], b.angular_velocity[i]);
    const Vec3 l = b.inertia[i] * w;
    e.kinetic += 0.5 * (d(b.mass[i]) * d(dot(b.velocity[i], b.velocity[i])) + d(dot(w, l)));
    e.potential -= d(b.mass[i]) * d(b.gravity_scale[i]) *
                   (d(gravity[0]) * d(b.position[i][0]) + d(gravity[1]) * d(b.position[i][1]) +
                    d(gravity[2]) * d(b.position[i][2]));
  }
  if (const Forces* forces = impl_->store.find<Forces>()) {
    for (const ForceEntry& f : forces->list) {
      for (std::uint32_t i = 0; f.force && i < b.size(); ++i) {
        if (b.type[i] != BodyType::dynamic || !acts_on(f, b.object[i], impl_->objects.tags(b.object[i]))) continue;
        const MassPoint point{b.position[i], b.velocity[i], b.mass[i], impl_->area[i], impl_->volume[i]};
        e.potential += f.force->potential(&point, 1);
      }
    }
  }
  Real error = 0;
  impl_->joint_totals(error, e.elastic);
  return e;
}

Momentum Rigid::momentum() const {
  const Bodies& b = impl_->bodies;
  Momentum m;
  for (std::uint32_t i = 0; i < b.size(); ++i) {
    if (b.type[i] != BodyType::dynamic) continue;
    const Vec3 own = rotate(b.rotation[i], Vec3(b.inertia[i] * rotate_inverse(b.rotation[i], b.angular_velocity[i])));
    double p[3], x[3];
    for (int k = 0; k < 3; ++k) {
      p[k] = static_cast<double>(b.mass[i]) * static_cast<double>(b.velocity[i][k]);
      x[k] = static_cast<double>(b.position[i][k]);
      m.linear[k] += p[k];
    }
    for (int k = 0; k < 3; ++k) {
      const int u = (k + 1) % 3, v = (k + 2) % 3;
      m.angular[k] += static_cast<double>(own[k]) + x[u] * p[v] - x[v] * p[u];
    }
  }
  return m;
}

void Rigid::residuals(std::vector<Residual>& out) const {
  Real error = 0;
  double elastic = 0;
  impl_->joint_totals(error, elastic);
  out.push_back({"rigid.joint_error_m", static_cast<double>(error)});
  out.push_back({"rigid.sleeping", static_cast<double>(impl_->sleeping_count)});
  out.push_back({"rigid.capped", static_cast<double>(impl_->solver->capped())});
}

bool Rigid::finite() const {
  const Bodies& b = impl_->bodies;
  for (std::uint32_t i = 0; i < b.size(); ++i) {
    if (b.type[i] == BodyType::free) continue;
    const Quat& q = b.rotation[i];
    if (!is_finite(b.position[i]) || !is_finite(b.velocity[i]) || !is_finite(b.angular_velocity[i]) ||
        !is_finite(q.vec()) || !is_finite(q.w))
      return false;
  }
  return true;
}

}  // namespace feder
