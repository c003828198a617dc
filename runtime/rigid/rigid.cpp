// The rigid system's face: descriptor, plan rows, questions, snapshot. The work is in bodies.cpp, rows.cpp, sleep.cpp
// and joints.cpp.
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
    : store(s.store), watched(s.store.need<Watch>("watch")), objects(s.objects), events(s.events),
      collide(dynamic_cast<ContactService&>(*s.systems.find_system(ContactService::kSystem))),
      bodies(s.store.need<Bodies>(kName)), colliders(s.store.need<Colliders>(ContactService::kSystem)),
      contacts(s.store.need<Contacts>(ContactService::kSystem)), solver_bodies(s.store.need<SolverBodies>(kName)),
      dimension(s.dimension), structure_changed(s.structure_changed),
      solver(rigid_solver(s.options).make(s.store.arena(kName), s.options)), volume(&s.store.arena(kName)),
      area(&s.store.arena(kName)), asymmetric(&s.store.arena(kName)), kept_momentum(&s.store.arena(kName)),
      kept_angular_velocity(&s.store.arena(kName)), sleep_candidate(&s.store.arena(kName)),
      next_in_island(&s.store.arena(kName)), parent(&s.store.arena(kName)), pace(&s.store.arena(kName)),
      edited_step(&s.store.arena(kName)), island_before(&s.store.arena(kName)), island_after(&s.store.arena(kName)),
      island_given(&s.store.arena(kName)), island_mass(&s.store.arena(kName)), island_drive(&s.store.arena(kName)),
      joints(&s.store.arena(kName)), records(&s.store.arena(kName)), free_joints(&s.store.arena(kName)),
      rows(&s.store.arena(kName)), blocks(&s.store.arena(kName)), moving(&s.store.arena(kName)),
      applied_force(&s.store.arena(kName)), applied_torque(&s.store.arena(kName)),
      angular_momentum(&s.store.arena(kName)), given_angular_velocity(&s.store.arena(kName)),
      jointed(&s.store.arena(kName)), bad(&s.store.arena(kName)), points(&s.store.arena(kName)),
      point_force(&s.store.arena(kName)), point_place(&s.store.arena(kName)) {
  if (solver_bodies.index.empty()) solver_bodies.reset();
}

const SystemDescriptor& Rigid::descriptor() {
  static const char* const needs[] = {ContactService::kSystem};
  static constexpr ObjectKind kinds[] = {kBodyKind, kJointKind};
  static constexpr EventKind events[] = {kJointBreak};
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

// Ranks leave room: couplings append their solver bodies between gather (10) and prepare (30), and work before and
// after solve (20).
void Rigid::add_passes(StepPlan& plan) {
  Impl* s = impl_.get();
  if (s->body_count == 0) return;
  plan.add<&Impl::update_boxes>(Rank::body_bounds, "update boxes", kName, s);
  plan.add<&Impl::wake_touched>(Rank::wake_touched, "wake touched", kName, s);
  plan.add<&Impl::gather>(Rank::gather_bodies, "gather", kName, s);
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

void Rigid::save(Writer& w) const {
  const Impl& s = *impl_;
  FEDER_ASSERT(s.records.size() == s.joints.size());
  s.bodies.save(w);
  w.list(s.solver_bodies.index), w.list(s.solver_bodies.free_list);
  w.list(s.volume), w.list(s.area), w.list(s.asymmetric), w.list(s.kept_momentum), w.list(s.kept_angular_velocity),
      w.list(s.sleep_candidate), w.list(s.next_in_island);
  w.list(s.free_joints);
  std::vector<SavedJoint> saved(s.joints.size());
  for (std::size_t j = 0; j < saved.size(); ++j) {
    std::memset(static_cast<void*>(&saved[j]), 0, sizeof(SavedJoint));
    saved[j].record = s.records[j];
    saved[j].shape = s.joints[j].shape;
    std::memcpy(saved[j].impulse, s.joints[j].impulse, sizeof saved[j].impulse);
    saved[j].rows = s.joints[j].rows;
  }
  w.list(saved);
  w.add(s.body_count), w.add(s.sleeping_count), w.add(s.joint_count), w.add(s.last_h);
  w.add(static_cast<std::uint64_t>(s.force_count));
}

void Rigid::load(Reader& r) {
  Impl& s = *impl_;
  s.bodies.load(r);
  r.list(s.solver_bodies.index), r.list(s.solver_bodies.free_list);
  r.list(s.volume), r.list(s.area), r.list(s.asymmetric), r.list(s.kept_momentum), r.list(s.kept_angular_velocity),
      r.list(s.sleep_candidate), r.list(s.next_in_island);
  r.list(s.free_joints);
  std::vector<SavedJoint> saved;
  r.list(saved);
  s.joints.assign(saved.size(), SolverJoint{});
  s.records.resize(saved.size());
  for (std::size_t j = 0; j < saved.size(); ++j) {
    s.records[j] = saved[j].record;
    s.joints[j].shape = saved[j].shape;
    std::memcpy(s.joints[j].impulse, saved[j].impulse, sizeof saved[j].impulse);
    s.joints[j].rows = saved[j].rows;
    if (!s.records[j].alive) continue;
    s.joints[j].kind = &joint_kinds()[s.records[j].kind];
  }
  r.get(s.body_count), r.get(s.sleeping_count), r.get(s.joint_count), r.get(s.last_h);
  std::uint64_t forces = 0;
  r.get(forces);
  s.force_count = forces;
  s.parent.resize(s.bodies.size());
  s.resize_watch();
  for (std::uint32_t j = 0; j < s.joints.size(); ++j)
    if (s.records[j].alive) s.refresh_joint(j);
  s.list_stale = s.poses_stale = true;
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
