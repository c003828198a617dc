// The passes of the coupling. Per substep: the net's integrator has moved its points; their velocities are handed to
// the rigid solver as solver bodies of their own, contacts push both sides, and changes are read back. A point without
// a contact keeps its integrator's result. Attachments are ball joints between body and point: three rows solved
// together, with the position error taken out as bias velocity before the rigid solve (Baumgarte 1972) and the velocity
// projected again after it. An integrator that knew only the light point would give a hanging body too little: an
// implicit one answers with the impulse that stops the point, not the body. So while it runs, the point has the inertia
// of what it carries; the impulse it found is then given to the point alone and the constraint passes it on, which
// keeps momentum. Contacts cannot be treated likewise (they may separate, and a light point with a heavy body's impulse
// is a bullet), so an implicit net yields to a body about 1 + (h w)^2 times too far: the warning "implicit_contact"
// says so. Kept between calls: nothing. Weak spot: that, and a long chain of bodies joined by attachments converges
// slowly.
#include <algorithm>

#include "contact/body_point.h"
#include "couple/springs_rigid.h"
#include "state/bodies.h"
#include "state/contacts.h"

namespace feder {
namespace {

constexpr Real kBoxMargin = Real(0.02);  // m, as of bodies
constexpr int kAttachmentRounds = 10;
constexpr Real kAttachmentShare = Real(0.5);  // of the position error taken out in a substep

constexpr Real kPullSpeed = 3;  // m/s, at which an attachment is closed at most

// Bias velocity that closes an attachment error, limited: a point attached far away, or two that contradict each other,
// must not throw the body.
Vec3 closing_velocity(const Vec3& error, Real rate) {
  const Real fast = rate * length(error);
  return fast > kPullSpeed ? Vec3((rate * kPullSpeed / fast) * error) : Vec3(rate * error);
}

}  // namespace

void SpringsRigid::update_boxes(StepContext& c) {
  for (const Coupled& k : coupled_) {
    const std::uint32_t i = k.particle, collider = particles_.collider[i];
    if (collider == kNone) continue;
    const bool pinned = particles_.inv_mass[i] == 0;
    const Vec3 x = particles_.position[i], v = particles_.velocity[i];
    const Vec3 travel = pinned ? Vec3(0, 0, 0) : Vec3(v * c.dt + c.gravity * (c.dt * c.dt));
    const Vec3 size = Vec3::Constant(particles_.radius[i] + kBoxMargin);
    if (pinned) colliders_.touched.push_back(collider);  // it may have been moved
    colliders_.motion[collider] = pinned ? ColliderMotion::fixed : ColliderMotion::dynamic;
    colliders_.set_awake(collider, !pinned);
    FEDER_ASSERT(colliders_.owner_index[collider] == i);
    colliders_.pose[collider] = {x, Quat::identity()};
    colliders_.center[collider] = x;
    colliders_.velocity[collider] = v;
    colliders_.box[collider].lo = x + travel.cwiseMin(Real(0)) - size;
    colliders_.box[collider].hi = x + travel.cwiseMax(Real(0)) + size;
  }
}

void SpringsRigid::append(StepContext& c) {
  for (Coupled& k : coupled_) {
    const std::uint32_t i = k.particle;
    k.solver_index = 0;
    k.added = 0;
    const Real inv_mass = particles_.inv_mass[i];
    if (inv_mass == 0) continue;
    FEDER_ASSERT(solver_bodies_.index[particles_.solver_slot[i]] == 0);  // it takes part once
    SolverBody s;
    s.velocity = particles_.velocity[i];
    SolverMass m;
    m.inv_mass = inv_mass;
    m.inv_mass_axes = Vec3::Constant(inv_mass);
    m.center = particles_.position[i];
    k.solver_index = solver_bodies_.append(particles_.solver_slot[i], s, m);
  }
  find_attachments();
  add_carried_mass();
  center_contacts(c);
}

void SpringsRigid::find_attachments() {
  const Bodies& b = rigid_.bodies();
  attachments_.clear();
  for (const Springs::Attachment& a : springs_.attachments()) {
    if (!objects_.alive(a.body)) {
      *structure_changed_ = true;  // the next sync drops it
      continue;
    }
    Attachment k;
    k.coupled = find_coupled(a.point);
    FEDER_ASSERT(k.coupled != kNone && coupled_[k.coupled].attached);
    k.body = rigid_.index(a.body);
    k.solver_index = solver_bodies_.index[b.solver_slot[k.body]];
    k.local = a.local - b.local_com[k.body];
    k.arm = rotate(b.rotation[k.body], k.local);
    attachments_.push_back(k);
  }
}

Mat3 SpringsRigid::body_response(const Attachment& k) const {
  FEDER_ASSERT(k.solver_index < solver_bodies_.mass.size());
  const SolverMass& m = solver_bodies_.mass[k.solver_index];
  const Mat3 arm = skew(k.arm);
  Mat3 r = -(arm * m.inv_inertia * arm);
  r.diagonal() += m.inv_mass_axes;
  return r;
}

void SpringsRigid::add_carried_mass() {
  attached_to_.assign(rigid_.bodies().size(), 0);
  for (const Attachment& k : attachments_) ++attached_to_[k.body];
  for (const Attachment& k : attachments_) {
    const Real trace = body_response(k).trace();
    FEDER_ASSERT(attached_to_[k.body] > 0);
    if (trace > 0) coupled_[k.coupled].added += 3 / (trace * static_cast<Real>(attached_to_[k.body]));
  }
}

// A mass point has no angular velocity, so contacts act on its centre: the body's arm ends there, else the moment of
// friction about the point would be lost.
void SpringsRigid::center_contacts(StepContext& c) {
  const Contacts& contacts = collide_.contacts();
  for (const std::uint32_t slot : contacts.active) {
    Contact& contact = collide_.contacts().slots[slot];
    const bool net_a = colliders_.owner[contact.collider_a] == ColliderOwner::point;
    const bool net_b = colliders_.owner[contact.collider_b] == ColliderOwner::point;
    if (!net_a && !net_b) continue;
    const std::uint32_t point = net_a ? contact.collider_a : contact.collider_b;
    FEDER_ASSERT(particles_.collider[colliders_.owner_index[point]] == point);
    FEDER_ASSERT(contact.point_count <= kMaxContactPoints);
    const Vec3 at = colliders_.center[point];
    for (int k = 0; k < contact.point_count; ++k) {
      contact.points[k].arm_a = net_a ? Vec3(0, 0, 0) : Vec3(at - colliders_.center[contact.collider_a]);
      contact.points[k].arm_b = net_b ? Vec3(0, 0, 0) : Vec3(at - colliders_.center[contact.collider_b]);
    }
    if (!warned_ && net_a != net_b) warn_soft_contact(point, c);
  }
}

void SpringsRigid::warn_soft_contact(std::uint32_t collider, StepContext& c) {
  FEDER_ASSERT(find_coupled(colliders_.owner_index[collider]) != kNone);
  const Coupled& k = coupled_[find_coupled(colliders_.owner_index[collider])];
  const ObjectId net = colliders_.object[collider];
  if (!k.implicit || k.solver_index == 0 || !(c.h * springs_.max_frequency(net) > Real(0.5))) return;
  warned_ = true;
  c.events->warn("implicit_contact",
                 objects_.describe(net) +
                     " touches a body while its integrator is implicit and "
                     "h w is large: it yields too much there; take symplectic_euler and more substeps, or attach",
                 net);
}

Vec3 SpringsRigid::attachment_error(const Attachment& k) const {
  const Coupled& p = coupled_[k.coupled];
  const Bodies& b = rigid_.bodies();
  const Vec3 x =
      p.solver_index != 0
          ? Vec3(solver_bodies_.mass[p.solver_index].center + solver_bodies_.state[p.solver_index].delta_position)
          : particles_.position[p.particle];
  const Vec3 center =
      b.position[k.body] + (k.solver_index != 0 ? solver_bodies_.state[k.solver_index].delta_position : Vec3(0, 0, 0));
  return x - center - k.arm;
}

void SpringsRigid::solve_attachments(int rounds, Real rate) {
  for (Attachment& k : attachments_) {
    if (k.solver_index != 0) k.arm = rotate(solver_bodies_.state[k.solver_index].rotation, k.local);
    Mat3 response = body_response(k);
    response.diagonal().array() += solver_bodies_.mass[coupled_[k.coupled].solver_index].inv_mass;
    k.mass = inverse(response);  // zero when neither can move
  }
  for (int round = 0; round < rounds; ++round)
    for (const Attachment& k : attachments_) {
      SolverBody& point = solver_bodies_.state[coupled_[k.coupled].solver_index];
      SolverBody& body = solver_bodies_.state[k.solver_index];
      Vec3 velocity = point.velocity - velocity_at(body, k.arm);
      if (rate > 0) velocity += closing_velocity(attachment_error(k), rate);
      const Vec3 impulse = -(k.mass * velocity);
      const SolverMass& pm = solver_bodies_.mass[coupled_[k.coupled].solver_index];
      const SolverMass& bm = solver_bodies_.mass[k.solver_index];
      point.velocity += pm.inv_mass * impulse;
      body.velocity -= bm.inv_mass_axes.cwiseProduct(impulse);
      body.angular_velocity -= bm.inv_inertia * cross(k.arm, impulse);
    }
}

void SpringsRigid::before_integrate(StepContext&) {
  for (Coupled& k : coupled_) {
    k.before = particles_.position[k.particle];
    if (k.solver_index != 0) solver_bodies_.state[k.solver_index].velocity = particles_.velocity[k.particle];
  }
  if (!attachments_.empty()) solve_attachments(kAttachmentRounds, 0);  // forces have moved the bodies' velocities since
  for (Coupled& k : coupled_) {
    const std::uint32_t i = k.particle;
    if (k.solver_index == 0 || particles_.inv_mass[i] == 0) continue;  // quarantined in the substep before: stays fixed
    k.given = particles_.velocity[i] = solver_bodies_.state[k.solver_index].velocity;
    if (k.added == 0) continue;
    FEDER_ASSERT(k.added > 0 && particles_.inertia[i] == particles_.mass[i]);  // carried inertia has been taken off
    particles_.inertia[i] = particles_.mass[i] + k.added;
    particles_.inv_mass[i] = 1 / particles_.inertia[i];
  }
}

void SpringsRigid::after_integrate(StepContext&) {
  for (Coupled& k : coupled_) {
    const std::uint32_t i = k.particle;
    if (k.added == 0 || k.solver_index == 0) continue;
    const Real inertia = particles_.inertia[i];
    FEDER_ASSERT(inertia >= particles_.mass[i]);
    particles_.inertia[i] = particles_.mass[i];
    if (particles_.inv_mass[i] == 0) continue;  // quarantined meanwhile
    particles_.inv_mass[i] = 1 / particles_.mass[i];
    const Vec3 impulse = inertia * (particles_.velocity[i] - k.given);
    particles_.velocity[i] = k.given + impulse / particles_.mass[i];
  }
}

void SpringsRigid::hand_over(StepContext& c) {
  for (Coupled& k : coupled_) {
    if (k.solver_index == 0) continue;
    SolverBody& s = solver_bodies_.state[k.solver_index];
    s.velocity = particles_.velocity[k.particle];
    s.delta_position = k.before - solver_bodies_.mass[k.solver_index].center;
  }
  FEDER_ASSERT(c.h > 0);
  if (!attachments_.empty()) solve_attachments(kAttachmentRounds, kAttachmentShare / c.h);
  for (Coupled& k : coupled_) {
    if (k.solver_index == 0) continue;
    k.given = solver_bodies_.state[k.solver_index].velocity;
    k.given_delta_position = solver_bodies_.state[k.solver_index].delta_position;
  }
}

void SpringsRigid::read_back(StepContext& c) {
  if (!attachments_.empty()) solve_attachments(kAttachmentRounds, 0);
  for (const Coupled& k : coupled_) {
    const std::uint32_t i = k.particle;
    if (k.solver_index == 0 || particles_.inv_mass[i] == 0) continue;
    const SolverBody& s = solver_bodies_.state[k.solver_index];
    const bool held = k.added > 0 || k.attached;
    if (!held && s.velocity == k.given) continue;  // no contact: the integrator's result stays, to the bit
    particles_.velocity[i] = s.velocity;
    FEDER_ASSERT(solver_bodies_.index[particles_.solver_slot[i]] == k.solver_index);
    const Vec3 pushed = s.delta_position - k.given_delta_position - c.h * k.given;
    if (held) particles_.place(i, solver_bodies_.mass[k.solver_index].center);
    particles_.move(i, held ? s.delta_position : pushed);
  }
}

void SpringsRigid::read_back_velocities(StepContext&) {
  if (!attachments_.empty()) solve_attachments(kAttachmentRounds, 0);
  for (const Coupled& k : coupled_)
    if (k.solver_index != 0 && particles_.inv_mass[k.particle] != 0)
      particles_.velocity[k.particle] = solver_bodies_.state[k.solver_index].velocity;
}

// A sleeping body acts as fixed, but a net never sleeps and may creep away below it: bodies in contact with free
// points, or attached to them, stay awake.
void SpringsRigid::keep_awake(StepContext&) {
  const Bodies& b = rigid_.bodies();
  for (const Attachment& k : attachments_)
    if (coupled_[k.coupled].solver_index != 0 && b.type[k.body] == BodyType::dynamic)
      rigid_.wake(b.object[k.body], WakeCause::joint, particles_.net[coupled_[k.coupled].particle]);
  const Contacts& contacts = collide_.contacts();
  for (const std::uint32_t slot : contacts.active) {
    std::uint32_t point = contacts.slots[slot].collider_a, body = contacts.slots[slot].collider_b;
    if (colliders_.owner[point] == ColliderOwner::body) std::swap(point, body);
    if (colliders_.owner[point] != ColliderOwner::point || colliders_.owner[body] != ColliderOwner::body) continue;
    if (colliders_.motion[point] != ColliderMotion::dynamic || colliders_.motion[body] != ColliderMotion::dynamic)
      continue;
    rigid_.wake(colliders_.object[body], WakeCause::contact, colliders_.object[point]);
  }
}

}  // namespace feder
