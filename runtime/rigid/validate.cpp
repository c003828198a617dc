// Invariants of bodies and joints after each step, asserted where asserts are on (feder/error.h): bodies, colliders and
// objects refer to each other, sleeping islands are rings of sleeping members, joints follow their bodies' types,
// solver indices are consistent, and dynamic bodies are finite.
#include "base/hash.h"
#include "rigid/impl.h"

namespace feder {

// Between gather and commit: moving[p] has solver index p + 1; solver bodies appended by couplings lie behind.
void Rigid::Impl::check_gathered() const {
  FEDER_ASSERT(solver_bodies.state.size() == solver_bodies.mass.size() && solver_bodies.state.size() > moving.size());
  for (std::uint32_t p = 0; p < moving.size(); ++p) {
    FEDER_ASSERT(p == 0 || moving[p - 1] < moving[p]);
    FEDER_ASSERT(solver_bodies.index[bodies.solver_slot[moving[p]]] == p + 1);
    FEDER_ASSERT(is_unit(solver_bodies.state[p + 1].rotation));
  }
  for (const std::uint32_t index : solver_bodies.index) FEDER_ASSERT(index < solver_bodies.state.size());
  const SolverMass& world = solver_bodies.mass[0];
  FEDER_ASSERT(world.inv_mass == 0 && world.inv_inertia.isZero(0));
}

void Rigid::Impl::check_body(std::uint32_t i) const {
  FEDER_ASSERT(objects.alive(bodies.object[i]) && objects.kind(bodies.object[i]) == kBodyKind);
  FEDER_ASSERT(objects.index(bodies.object[i]) == i);
  FEDER_ASSERT(bodies.solver_slot[i] < solver_bodies.index.size());
  FEDER_ASSERT(is_unit(bodies.rotation[i]));
  const bool dynamic = bodies.type[i] == BodyType::dynamic;
  FEDER_ASSERT(dynamic == (bodies.inv_mass[i] > 0));
  FEDER_ASSERT(bodies.has_target[i] == 0 || bodies.type[i] == BodyType::kinematic);
  if (!dynamic) {
    FEDER_ASSERT(bodies.inv_inertia[i].isZero(0) && next_in_island[i] == kNone);
    return;
  }
  // non-finite ones have been quarantined
  FEDER_ASSERT(is_finite(bodies.position[i]));
  FEDER_ASSERT(is_finite(bodies.velocity[i]));
  FEDER_ASSERT(is_finite(bodies.angular_velocity[i]));
  if (bodies.awake[i]) {
    FEDER_ASSERT(bodies.island[i] == kNone && next_in_island[i] == kNone);
    return;
  }
  FEDER_ASSERT(bodies.velocity[i].isZero(0) && bodies.angular_velocity[i].isZero(0));
  const std::uint32_t root = bodies.island[i], next = next_in_island[i];
  FEDER_ASSERT(root < bodies.size() && bodies.island[root] == root);
  FEDER_ASSERT(next < bodies.size() && bodies.island[next] == root);
}

std::uint32_t Rigid::Impl::check_colliders(std::uint32_t i) const {
  const bool dynamic = bodies.type[i] == BodyType::dynamic, fixed = bodies.type[i] == BodyType::fixed;
  std::uint32_t count = 0;
  each_collider(i, [&](std::uint32_t k) {
    FEDER_ASSERT(k < colliders.size() && colliders.motion[k] == motion_of(bodies.type[i]));
    FEDER_ASSERT(colliders.owner[k] == ColliderOwner::body && colliders.owner_index[k] == i);
    FEDER_ASSERT(colliders.object[k] == bodies.object[i]);
    FEDER_ASSERT(colliders.solver_slot[k] == (fixed ? kNone : bodies.solver_slot[i]));
    FEDER_ASSERT(!dynamic || colliders.awake[k] == bodies.awake[i]);
    ++count;
    FEDER_ASSERT(count <= colliders.size());  // the list ends
  });
  return count;
}

// Sleeping bodies lie in the ring of their island, once: the rings of all roots have as many members as there are
// sleeping bodies.
void Rigid::Impl::check_islands() const {
  std::uint32_t members = 0;
  for (std::uint32_t i = 0; sleeping_count > 0 && i < bodies.size(); ++i) {
    if (bodies.type[i] != BodyType::dynamic || bodies.island[i] != i) continue;
    std::uint32_t at = i;
    do {
      ++members;
      FEDER_ASSERT(!bodies.awake[at] && members <= sleeping_count);
      at = next_in_island[at];
    } while (at != i);
  }
  FEDER_ASSERT(members == sleeping_count);
}

void Rigid::Impl::check_joint(std::uint32_t j) const {
  const JointRecord& r = records[j];
  const SolverJoint& s = joints[j];
  FEDER_ASSERT(objects.alive(r.object) && objects.index(r.object) == j);
  FEDER_ASSERT(s.kind == &joint_kinds()[r.kind] && s.rows <= kMaxJointRows);
  FEDER_ASSERT(r.body_a != r.body_b && !(r.break_force <= 0));
  const auto side = [&](ObjectId object, std::uint32_t body, std::uint32_t slot) {
    FEDER_ASSERT((body == kNone) == !object);
    if (body == kNone) {
      FEDER_ASSERT(slot == kNone);
      return;
    }
    FEDER_ASSERT(body < bodies.size() && bodies.object[body] == object);
    FEDER_ASSERT(slot == (bodies.type[body] == BodyType::fixed ? kNone : bodies.solver_slot[body]));
  };
  side(r.a, r.body_a, s.slot_a);
  side(r.b, r.body_b, s.slot_b);
}

void Rigid::Impl::check_active_joints() const {
  for (const std::uint32_t j : active_joints) {
    const SolverJoint& s = joints[j];
    FEDER_ASSERT(records[j].alive && s.kind && (s.slot_a != kNone || s.slot_b != kNone) && s.slot_a != s.slot_b);
    FEDER_ASSERT(s.slot_a == kNone || s.slot_a < solver_bodies.index.size());
    FEDER_ASSERT(s.slot_b == kNone || s.slot_b < solver_bodies.index.size());
  }
}

// Lists and counts that follow from bodies and joints.
void Rigid::Impl::check_lists() const {
  const std::size_t count = bodies.size();
  each_array(*this, [&](const auto& array) { FEDER_ASSERT(array.size() == count); });
  FEDER_ASSERT(islands.size() == count);
  std::uint32_t alive = 0, asleep = 0, awake = 0;
  for (std::uint32_t i = 0; i < bodies.size(); ++i) {
    alive += bodies.type[i] != BodyType::free;
    asleep += bodies.type[i] == BodyType::dynamic && !bodies.awake[i];
    awake += bodies.awake[i];
  }
  FEDER_ASSERT(alive == body_count);
  FEDER_ASSERT(asleep == sleeping_count);
  FEDER_ASSERT(list_stale || awake == moving.size());
  for (std::size_t p = 0; !list_stale && p < moving.size(); ++p)
    FEDER_ASSERT(bodies.awake[moving[p]] && (p == 0 || moving[p - 1] < moving[p]));
  const bool listed = lists_free(free_joints, records.size(), [&](std::uint32_t j) { return !records[j].alive; });
  FEDER_ASSERT(listed && records.size() - free_joints.size() == joint_count);
  std::size_t active = 0;
  for (std::uint32_t j = 0; j < records.size(); ++j) {
    const JointRecord& r = records[j];
    active += r.alive && (bodies.moves(r.body_a) || bodies.moves(r.body_b));
  }
  FEDER_ASSERT(joints_stale || list_stale || active == active_joints.size());
}

void Rigid::validate() const {
  const Impl& s = *impl_;
  s.bodies.validate();
  s.check_lists();
  std::uint32_t owned = 0;
  for (std::uint32_t i = 0; i < s.bodies.size(); ++i) {
    if (s.bodies.type[i] == BodyType::free) continue;
    s.check_body(i);
    owned += s.check_colliders(i);
  }
  s.check_islands();
  std::uint32_t colliders = 0;
  for (std::uint32_t k = 0; k < s.colliders.size(); ++k)
    colliders += s.colliders.motion[k] != ColliderMotion::none && s.colliders.owner[k] == ColliderOwner::body;
  FEDER_ASSERT(owned == colliders);
  FEDER_ASSERT(s.joints.size() == s.records.size());
  for (std::uint32_t j = 0; j < s.records.size(); ++j)
    if (s.records[j].alive) s.check_joint(j);
}

}  // namespace feder
