// Per substep: the bodies' velocities are integrated; the boundary is placed at the bodies' poses; the fluid moves and
// changes the boundary's velocities as it presses on it; the velocities go back to the solver bodies, so that contacts
// and joints are solved with the fluid's impulses; then the boundary is placed at the poses after the solve, and the
// fluid projects its particles out of it. A sleeping body is a fixed boundary, until fluid presses on it. Kept between
// calls: the list of the boundary, for queries. Weak spot: a body far lighter than the fluid around it follows the
// fluid within an iteration, its contacts with other bodies only within a substep.
#include "couple/fluid_rigid.h"

#include <algorithm>
#include <cmath>

#include "couple/coupling.h"
#include "feder/params.h"
#include "fluid/block_sums.h"
#include "fluid/pool.h"
#include "state/bodies.h"

namespace feder {
namespace {

constexpr Real kWakeImpulse = Real(1e-7);  // N s per kg of the body: more than rounding

}  // namespace

const SystemDescriptor& FluidRigid::descriptor() {
  return coupling_descriptor<FluidRigid, Fluid, Rigid>("boundary shapes");
}

FluidRigid::FluidRigid(SystemSetup& s)
    : arena_(s.store.arena(kName)), fluid_(system_of<Fluid>(s)), rigid_(system_of<Rigid>(s)),
      colliders_(s.store.need<Colliders>(ContactService::kSystem)),
      solver_bodies_(s.store.need<SolverBodies>(Rigid::kName)), boundary_(fluid_.boundary()), objects_(s.objects),
      contacts_(s.store.need<ContactBook>(ContactService::kSystem)), finder_(contacts_.finder(kName)) {}

FluidRigid::~FluidRigid() { boundary_.shapes.clear(), boundary_.bodies.clear(); }

std::size_t FluidRigid::count() const { return boundary_.shapes.size(); }

void FluidRigid::add_passes(StepPlan& plan) {
  boundary_.shapes.clear(), boundary_.bodies.clear();
  if (fluid_.pool_count() == 0 || rigid_.count() == 0) return;
  contacts_.use();
  using F = FluidRigid;
  plan.add<&F::collect>(Rank::boundary_list, "list boundary", kName, this);
  compared_.clear();
  carriers_.clear();
  fluid_.list_carriers(carriers_);
  if (!carriers_.empty()) {
    plan.add<&F::carry_emitters>(before(Rank::fluid_emit), "carry emitters", kName, this);
    plan.add<&F::carry_drains>(before(Rank::fluid_drain), "carry drains", kName, this);
  }
  plan.add<&F::set_boundary>(Rank::boundary_place, "place boundary", kName, this);
  plan.add<&F::weigh>(Rank::boundary_weigh, "weigh impulses", kName, this);
  plan.add<&F::give_velocities>(Rank::boundary_push, "push bodies", kName, this);
  plan.add<&F::set_boundary>(Rank::boundary_follow, "move boundary", kName, this);
  plan.add<&F::push_again>(Rank::boundary_return, "push bodies after projection", kName, this);
  plan.add<&F::follow_stopped>(after(Rank::commit), "non-penetration of stopped bodies", kName, this);
  plan.add<&F::keep_awake>(Rank::keep_awake, "keep awake", kName, this);
  plan.add<&F::report_contacts>(Rank::fluid_events, "contacts", kName, this);
  plan.add<&F::place_for_queries>(Rank::query_boundary, "place boundary for queries", kName, this);
  bool sensors = false;
  for (std::uint32_t k = 0; k < colliders_.size(); ++k)
    sensors = sensors || (colliders_.sensor[k] && colliders_.motion[k] != ColliderMotion::none);
  if (sensors) plan.add<&F::report_sensors>(Rank::fluid_events, "sensors", kName, this);
}

void FluidRigid::list_boundary() {
  const Bodies& b = rigid_.bodies();
  boundary_.shapes.clear(), boundary_.bodies.clear();
  collider_.clear(), body_.clear();
  index_of_body_.assign(b.size(), kNone);
  for (std::uint32_t k = 0; k < colliders_.size(); ++k) {
    if (colliders_.motion[k] == ColliderMotion::none || colliders_.sensor[k] ||
        colliders_.owner[k] != ColliderOwner::body)
      continue;
    const std::uint32_t i = colliders_.owner_index[k];
    if (index_of_body_[i] == kNone) {
      FEDER_ASSERT(body_.size() == boundary_.bodies.size());
      index_of_body_[i] = static_cast<std::uint32_t>(boundary_.bodies.size());
      BoundaryBody body;
      body.object = b.object[i];
      body.dynamic = b.type[i] == BodyType::dynamic;
      boundary_.bodies.push_back(body);
      body_.push_back(i);
    }
    BoundaryShape w;
    w.shape = colliders_.shape[k];
    w.body = index_of_body_[i];
    w.group = colliders_.group[k], w.mask = colliders_.mask[k];
    w.local = colliders_.local[k];
    boundary_.shapes.push_back(w);
    collider_.push_back(k);
  }
}

void FluidRigid::place_boundary(bool between_steps) {
  const Bodies& b = rigid_.bodies();
  boundary_.weighed = false;
  for (std::size_t n = 0; n < boundary_.bodies.size(); ++n) {
    BoundaryBody& w = boundary_.bodies[n];
    const std::uint32_t i = body_[n];
    const std::uint32_t at = between_steps ? 0 : solver_bodies_.index[b.solver_slot[i]];
    FEDER_ASSERT(b.object[i] == w.object && (at == 0 || at < solver_bodies_.state.size()));
    // impulses on a body that moves have been handed over: the velocity is read anew below
    FEDER_ASSERT(w.solver_index == 0 || !w.dynamic || w.impulse.isZero(0));
    w.solver_index = at;
    w.contact_weight = 0;
    w.impulse = Vec3::Zero();
    if (at == 0) {
      w.center = b.position[i];
      w.velocity = w.angular_velocity = w.inv_mass = Vec3::Zero();
      w.inv_inertia = Mat3::Zero();
      continue;
    }
    const SolverBody& s = solver_bodies_.state[at];
    const SolverMass& m = solver_bodies_.mass[at];
    w.center = m.center + s.delta_position;
    w.velocity = s.velocity, w.angular_velocity = s.angular_velocity;
    w.inv_mass = m.inv_mass_axes, w.inv_inertia = m.inv_inertia;
    boundary_.weighed = boundary_.weighed || w.dynamic;
  }
  for (BoundaryShape& w : boundary_.shapes) {
    const std::uint32_t i = body_[w.body], at = boundary_.bodies[w.body].solver_index;
    const Quat rotation = at == 0 ? b.rotation[i] : solver_bodies_.state[at].rotation;
    w.pose = Pose{boundary_.bodies[w.body].center, rotation} * w.local;
    w.box = w.shape->bounds(w.pose);
  }
}

void FluidRigid::give_velocities(StepContext&) {
  for (BoundaryBody& w : boundary_.bodies) {
    if (w.solver_index == 0 || !w.dynamic) continue;
    SolverBody& s = solver_bodies_.state[w.solver_index];
    s.velocity = w.velocity, s.angular_velocity = w.angular_velocity;
    w.impulse = Vec3::Zero();  // handed over
  }
}

void FluidRigid::compare_densities(StepContext& c) {
  const Bodies& b = rigid_.bodies();
  if (compared_.size() < b.size()) compared_.resize(b.size());
  for (std::uint32_t i = 0; i < b.size(); ++i) {
    const ObjectId body = b.object[i];
    if (compared_[i] == body || b.type[i] != BodyType::dynamic) continue;
    compared_[i] = body;
    if (std::count(warned_.begin(), warned_.end(), body)) continue;
    Real volume = 0;
    for (std::uint32_t k = b.first_collider[i]; k != kNone; k = colliders_.next_of_body[k])
      if (!colliders_.sensor[k]) volume += colliders_.shape[k]->mass(1).mass;
    if (!(volume > 0)) continue;
    const Real density = b.mass[i] / volume;
    for (std::size_t n = 0; n < fluid_.pool_count(); ++n) {
      const FluidPool& p = fluid_.pool_at(n);
      if (std::max(density / p.desc.density, p.desc.density / density) <= kMaxDensityRatio) continue;
      c.events->warn("density_ratio",
                     objects_.describe(body) + " has a density of " + print_value(density) + " kg/m3, " +
                         objects_.describe(p.object) + " of " + print_value(p.desc.density) +
                         ": a ratio of more than " + print_value(kMaxDensityRatio) +
                         " throws the lighter one about; bring the densities nearer to each other",
                     body);
      warned_.push_back(body);
      break;
    }
  }
}

void FluidRigid::collect(StepContext& c) {
  compare_densities(c);
  list_boundary();
  mismatch_ = given_ = pushed_ = 0;
  fluid_.clear_contact_states();
}

// Where bodies are at the start of the substep, with the velocities of the substep.
void FluidRigid::carry_emitters(StepContext&) {
  const Bodies& b = rigid_.bodies();
  carriers_.clear();
  fluid_.list_carriers(carriers_);
  for (FluidCarrier& k : carriers_) {
    const std::uint32_t i = objects_.index(k.body), at = solver_bodies_.index[b.solver_slot[i]];
    k.center = b.position[i], k.pose.rotation = b.rotation[i];
    if (at != 0) {
      const SolverBody& s = solver_bodies_.state[at];
      k.center = solver_bodies_.mass[at].center + s.delta_position, k.pose.rotation = s.rotation;
      k.velocity = s.velocity, k.angular_velocity = s.angular_velocity;
    }
    k.pose.position = k.center - rotate(k.pose.rotation, b.local_com[i]);
  }
  fluid_.carry(carriers_);
}

// Where bodies are after the step.
void FluidRigid::carry_drains(StepContext&) {
  const Bodies& b = rigid_.bodies();
  carriers_.clear();
  fluid_.list_carriers(carriers_);
  for (FluidCarrier& k : carriers_) {
    const std::uint32_t i = objects_.index(k.body);
    k.pose = b.origin_pose(i), k.center = b.position[i];
    k.velocity = b.velocity[i], k.angular_velocity = b.angular_velocity[i];
  }
  fluid_.carry(carriers_);
}

void FluidRigid::place_for_queries(StepContext&) {
  list_boundary();
  place_boundary(true);
}

void FluidRigid::set_boundary(StepContext& c) {
  place_boundary(false);
  for (std::size_t n = 0; n < fluid_.pool_count(); ++n)
    for (double& p : fluid_.pool_at(n).pushed) p = 0;
  if (boundary_.weighed) weigh_fluids(c, before_);
}

void FluidRigid::weigh_fluids(const StepContext& c, double (&sum)[3]) const {
  struct Sums {
    double v[3] = {0, 0, 0};
    void add(const Sums& s) {
      for (int k = 0; k < 3; ++k) v[k] += s.v[k];
    }
  };
  for (double& k : sum) k = 0;
  for (std::size_t n = 0; n < fluid_.pool_count(); ++n) {
    const FluidPool& p = fluid_.pool_at(n);
    const Sums own = sum_blocks<Sums>(p.count, kParticleGrain, *c.jobs, *c.scratch, [&](std::uint32_t i, Sums& s) {
      s.v[0] += static_cast<double>(p.v[i].x);
      s.v[1] += static_cast<double>(p.v[i].y);
      s.v[2] += static_cast<double>(p.v[i].z);
    });
    for (int k = 0; k < 3; ++k) sum[k] += static_cast<double>(p.mass) * own.v[k];
  }
}

// Momentum balance of two states: velocities of all particles and of the bodies, before and after. A fixed body, or one
// locked along an axis, has no change of velocity there: its impulses are summed instead.
void FluidRigid::compare_impulses(const StepContext& c, const Vec3& gravity_seconds) {
  if (!boundary_.weighed) return;
  double after[3], gained[3] = {0, 0, 0};
  weigh_fluids(c, after);
  for (const BoundaryBody& w : boundary_.bodies) {
    const bool moves = w.dynamic && w.solver_index != 0;
    for (int k = 0; k < 3; ++k) {
      const Real inv_mass = moves ? solver_bodies_.mass[w.solver_index].inv_mass_axes[k] : Real(0);
      gained[k] +=
          inv_mass > 0
              ? static_cast<double>(w.velocity[k] - solver_bodies_.state[w.solver_index].velocity[k]) / inv_mass
              : static_cast<double>(w.impulse[k]);
    }
    given_ += static_cast<double>(length(w.impulse));
    if (moves) pushed_ += static_cast<double>(length(w.impulse));
  }
  for (std::size_t n = 0; n < fluid_.pool_count(); ++n) {
    const FluidPool& p = fluid_.pool_at(n);
    if (!p.active()) continue;
    const double weight = static_cast<double>(p.desc.gravity_scale) * p.mass * p.count;
    for (int k = 0; k < 3; ++k) gained[k] -= weight * static_cast<double>(gravity_seconds[k]) + p.pushed[k];
  }
  double off = 0;
  for (int k = 0; k < 3; ++k) {
    const double d = after[k] - before_[k] + gained[k];
    off += d * d;
  }
  mismatch_ = std::max(mismatch_, std::sqrt(off));
}

// Directly after the fluid's own passes: couplings with nets and sheets change velocities of particles as well.
void FluidRigid::weigh(StepContext& c) { compare_impulses(c, c.h * c.gravity); }

void FluidRigid::push_again(StepContext& c) {
  compare_impulses(c, Vec3::Zero());
  give_velocities(c);
}

// Continuous collision detection has put bodies back to where they met something: the fluid that they hold goes with
// them. Its velocities are those of the next substep to change, where bodies get their share.
void FluidRigid::follow_stopped(StepContext& c) {
  const Bodies& b = rigid_.bodies();
  Real least = kInfinity;
  for (std::size_t n = 0; n < fluid_.pool_count(); ++n) least = std::min(least, fluid_.pool_at(n).clearance / 4);
  bool any = false;
  for (BoundaryShape& w : boundary_.shapes) {
    const std::uint32_t i = body_[w.body];
    const Pose now = Pose{b.position[i], b.rotation[i]} * w.local;
    if (!(largest_motion(*w.shape, w.pose, now) > least)) continue;
    w.pose = now, w.box = w.shape->bounds(now);
    any = true;
  }
  if (!any) return;
  for (std::size_t n = 0; n < fluid_.pool_count(); ++n) {
    FluidPool& p = fluid_.pool_at(n);
    if (p.active()) p.project_out(boundary_, *c.jobs, false);
  }
}

void FluidRigid::keep_awake(StepContext&) {
  const Bodies& b = rigid_.bodies();
  fluid_contacts_.clear();
  fluid_.list_contact_states(fluid_contacts_);
  for (std::size_t n = 0; n < boundary_.bodies.size(); ++n) {
    BoundaryBody& w = boundary_.bodies[n];
    const std::uint32_t i = body_[n];
    FEDER_ASSERT(!(w.pressed < 0));
    if (!w.dynamic || w.pressed <= kWakeImpulse * b.mass[i]) continue;
    // in calm fluid it may rest as well
    ObjectId fluid;
    bool calm = true;
    for (const FluidContactState& t : fluid_contacts_) {
      if (t.body != w.object) continue;
      if (!fluid) fluid = t.fluid;
      calm = calm && fluid_.pool_at(objects_.index(t.fluid)).drowsy();
    }
    if (fluid && calm) continue;
    objects_.for_each(kFluidKind, [&](ObjectId id) {  // pressed earlier in the step: no particle is in contact now
      if (!fluid) fluid = id;
    });
    rigid_.wake(b.object[i], kFluidCause, fluid);
  }
}

// A fluid is in contact with a body from its first particle at it to its last; the event has their number.
void FluidRigid::report_contacts(StepContext&) {
  fluid_contacts_.clear();
  fluid_.list_contact_states(fluid_contacts_);
  for (const FluidContactState& t : fluid_contacts_) {
    ContactFinding n;
    n.key = {t.body, t.fluid};
    n.index = t.count, n.number = 1;
    n.point = t.point, n.normal = t.normal;
    n.speed = t.speed, n.impulse = pressed_on(t.body);
    contacts_.see(finder_, n);
  }
}

Real FluidRigid::pressed_on(ObjectId body) const {
  for (const BoundaryBody& w : boundary_.bodies)
    if (w.object == body) return w.pressed;
  return 0;
}

// A fluid enters a sensor with its first particle and leaves it with its last; the event has their number.
void FluidRigid::report_sensors(StepContext&) {
  inside_.clear();
  const Bodies& b = rigid_.bodies();
  for (std::uint32_t k = 0; k < colliders_.size(); ++k) {
    if (colliders_.motion[k] == ColliderMotion::none || !colliders_.sensor[k] ||
        colliders_.owner[k] != ColliderOwner::body)
      continue;
    const Pose pose = b.com_pose(colliders_.owner_index[k]) * colliders_.local[k];
    objects_.for_each(kFluidKind, [&](ObjectId id) {
      const std::uint32_t n =
          fluid_.count_inside(id, *colliders_.shape[k], pose, colliders_.group[k], colliders_.mask[k]);
      if (n == 0) return;
      for (Inside& i : inside_) {  // parts of a compound
        if (i.sensor != colliders_.object[k] || i.fluid != id) continue;
        i.count += n;
        return;
      }
      inside_.push_back({colliders_.object[k], id, n});
    });
  }
  for (const Inside& i : inside_) {
    ContactFinding n;
    n.key = {i.sensor, i.fluid, 0, 1};
    n.index = i.count, n.number = 1;
    contacts_.see(finder_, n);
  }
}

void FluidRigid::hash(Hash& h) const {
  contacts_.each(finder_, [&](const ContactRecord& r) { h.add(r.key.a.slot), h.add(r.key.b.slot), h.add(r.index); });
}

void FluidRigid::residuals(std::vector<Residual>& out) const {
  out.push_back({"fluid_rigid.impulse_mismatch", given_ > 0 ? mismatch_ / given_ : 0});
  out.push_back({"fluid_rigid.impulse_ns", pushed_});
}

void FluidRigid::validate() const {
  const Bodies& b = rigid_.bodies();
  FEDER_ASSERT(boundary_.shapes.empty() ||
               (boundary_.shapes.size() == collider_.size() && boundary_.bodies.size() == body_.size()));
  for (std::size_t n = 0; n < boundary_.bodies.size(); ++n) {
    FEDER_ASSERT(body_[n] < b.size() && index_of_body_[body_[n]] == n &&
                 b.object[body_[n]] == boundary_.bodies[n].object);
    // a body that went bad within the step is fixed since then
    FEDER_ASSERT(boundary_.bodies[n].dynamic || b.type[body_[n]] != BodyType::dynamic);
  }
  for (std::size_t n = 0; n < boundary_.shapes.size(); ++n) {
    const BoundaryShape& w = boundary_.shapes[n];
    FEDER_ASSERT(colliders_.shape[collider_[n]] == w.shape && colliders_.owner_index[collider_[n]] == body_[w.body]);
  }
}

}  // namespace feder
