// Structure of the coupling: which points have a collider and a solver body, the passes, residuals and validation. The
// passes themselves are in springs_rigid_step.cpp. All of it follows from the nets: colliders and solver bodies live in
// their own arrays, their indices in Particles, so a snapshot needs nothing from this system.
#include "couple/springs_rigid.h"

#include <algorithm>

#include "couple/coupling.h"
#include "state/bodies.h"

namespace feder {

const SystemDescriptor& SpringsRigid::descriptor() {
  return coupling_descriptor<SpringsRigid, Springs, Rigid>("points that meet bodies");
}

SpringsRigid::SpringsRigid(SystemSetup& s)
    : arena_(s.store.arena(kName)), springs_(system_of<Springs>(s)), rigid_(system_of<Rigid>(s)),
      collide_(system_of<Collide>(s)), colliders_(collide_.colliders()),
      solver_bodies_(s.store.need<SolverBodies>(Rigid::kName)), particles_(s.store.need<Particles>(Springs::kName)),
      objects_(s.objects), structure_changed_(s.structure_changed) {}

std::size_t SpringsRigid::count() const { return coupled_.size(); }

void SpringsRigid::add_passes(StepPlan& plan) {
  sync();
  if (coupled_.empty() || rigid_.count() == 0) return;
  using S = SpringsRigid;
  plan.add<&S::update_boxes>(Rank::point_bounds, "point boxes", kName, this);
  plan.add<&S::append>(Rank::append_points, "append points", kName, this);
  plan.add<&S::before_integrate>(Rank::net_prepare, "before integrate", kName, this);
  plan.add<&S::after_integrate>(Rank::net_release, "after integrate", kName, this);
  plan.add<&S::hand_over>(Rank::net_hand_over, "hand over", kName, this);
  plan.add<&S::read_back>(Rank::net_read_back, "read back", kName, this);
  plan.add<&S::read_back_velocities>(Rank::net_read_bounces, "read back bounces", kName, this);
  plan.add<&S::keep_awake>(Rank::keep_awake, "keep awake", kName, this);
}

std::uint32_t SpringsRigid::find_coupled(std::uint32_t particle) const {
  const auto at = std::lower_bound(coupled_.begin(), coupled_.end(), particle,
                                   [](const Coupled& k, std::uint32_t p) { return k.particle < p; });
  return at != coupled_.end() && at->particle == particle ? static_cast<std::uint32_t>(at - coupled_.begin()) : kNone;
}

void SpringsRigid::sync() {
  release_removed();
  // attachments to bodies that are gone end
  std::vector<Springs::Attachment> dead;
  for (const Springs::Attachment& a : springs_.attachments())
    if (!objects_.alive(a.body)) dead.push_back(a);
  for (const Springs::Attachment& a : dead) {
    FEDER_ASSERT(particles_.net[a.point] == a.net);
    springs_.detach(a.net, a.point - springs_.net_info(objects_.index(a.net)).first);
  }

  // coupled points, in ascending order
  std::vector<std::uint8_t> attached(particles_.size(), 0);
  for (const Springs::Attachment& a : springs_.attachments()) attached[a.point] = 1;
  coupled_.clear();
  attachments_.clear();  // they are indices of that list
  for (std::size_t n = 0; n < springs_.net_count(); ++n) {
    const Springs::NetInfo net = springs_.net_info(n);
    for (std::uint32_t i = net.first; i < net.first + net.count; ++i) {
      sync_collider(i, net, attached[i] != 0);
      if (particles_.solver_slot[i] == kNone) continue;
      FEDER_ASSERT(coupled_.empty() || coupled_.back().particle < i);  // for the binary search of find_coupled
      Coupled k;
      k.particle = i;
      k.implicit = net.implicit;
      k.attached = attached[i] != 0;
      coupled_.push_back(k);
    }
  }
}

// Collider and solver slot of a point. An attached point collides with nothing: its body does.
void SpringsRigid::sync_collider(std::uint32_t i, const Springs::NetInfo& net, bool attached) {
  const bool collides = particles_.radius[i] > 0;
  std::uint32_t& slot = particles_.solver_slot[i];
  if ((collides || attached) && slot == kNone) slot = solver_bodies_.add();
  if (!collides && !attached && slot != kNone) {
    solver_bodies_.remove(slot);
    slot = kNone;
  }
  if (!collides) return;
  std::uint32_t& k = particles_.collider[i];
  if (k == kNone) {
    // the points of a net share one shape
    const std::uint32_t first = particles_.collider[net.first];
    const bool share = first != kNone && particles_.radius[net.first] == particles_.radius[i];
    const ShapePtr ball = share ? colliders_.shapes[first] : make_point(particles_.radius[i]);
    collide_.check_shape(*ball);
    k = colliders_.add();
    FEDER_ASSERT(slot != kNone && particles_.net[i] == net.object);
    colliders_.shapes[k] = ball;
    colliders_.shape[k] = colliders_.shapes[k].get();
    colliders_.motion[k] = ColliderMotion::dynamic;
    colliders_.owner[k] = ColliderOwner::point;
    colliders_.object[k] = net.object;
    colliders_.sub[k] = i - net.first;
    colliders_.friction_static[k] = colliders_.friction_dynamic[k] = net.friction;
    colliders_.restitution[k] = net.restitution;
  }
  FEDER_ASSERT(colliders_.owner[k] == ColliderOwner::point && colliders_.object[k] == net.object);
  colliders_.touched.push_back(k);
  colliders_.owner_index[k] = i;
  colliders_.solver_slot[k] = slot;
  colliders_.group[k] = attached ? 0 : net.group;
  colliders_.mask[k] = attached ? 0 : net.mask;
}

void SpringsRigid::release_removed() {
  for (const Springs::Removed& r : springs_.removed()) {
    if (r.collider != kNone) {
      FEDER_ASSERT(colliders_.owner[r.collider] == ColliderOwner::point &&
                   !objects_.alive(colliders_.object[r.collider]));
      collide_.forget(r.collider);
      colliders_.remove(r.collider);
    }
    if (r.solver_slot != kNone) solver_bodies_.remove(r.solver_slot);
  }
  springs_.removed().clear();
}

void SpringsRigid::residuals(std::vector<Residual>& out) const {
  const Bodies& b = rigid_.bodies();
  double worst = 0;
  for (const Springs::Attachment& a : springs_.attachments()) {
    if (!objects_.alive(a.body)) continue;
    const Vec3 anchor = to_world(b.origin_pose(rigid_.index(a.body)), a.local);
    worst = std::max(worst, static_cast<double>(length(particles_.position[a.point] - anchor)));
  }
  if (!springs_.attachments().empty()) out.push_back({"springs_rigid.attachment_error_m", worst});
}

void SpringsRigid::validate() const {
  std::uint32_t last = 0;
  for (std::size_t n = 0; n < coupled_.size(); ++n) {
    const Coupled& k = coupled_[n];
    const std::uint32_t i = k.particle, collider = particles_.collider[i];
    FEDER_ASSERT(i < particles_.size() && (n == 0 || coupled_[n - 1].particle < i));
    FEDER_ASSERT(particles_.solver_slot[i] < solver_bodies_.index.size());
    FEDER_ASSERT(particles_.inertia[i] == particles_.mass[i]);  // carried inertia has been taken off
    FEDER_ASSERT(k.attached || collider != kNone);
    if (collider != kNone) {
      FEDER_ASSERT(colliders_.owner[collider] == ColliderOwner::point && colliders_.owner_index[collider] == i);
      FEDER_ASSERT(colliders_.object[collider] == particles_.net[i] &&
                   colliders_.solver_slot[collider] == particles_.solver_slot[i]);
    }
    if (k.solver_index == 0) continue;
    FEDER_ASSERT(k.solver_index > last &&
                 solver_bodies_.index[particles_.solver_slot[i]] == k.solver_index);  // no two share a solver body
    last = k.solver_index;
  }
  for (const Springs::Attachment& a : springs_.attachments()) {
    const std::uint32_t index = find_coupled(a.point);
    FEDER_ASSERT(index != kNone && coupled_[index].attached && particles_.net[a.point] == a.net);
  }
  for (const Attachment& k : attachments_) FEDER_ASSERT(k.coupled < coupled_.size() && k.body < rigid_.bodies().size());
}

}  // namespace feder
