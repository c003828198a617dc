// Making, changing and removing bodies: mass properties from shapes, one collider per part of a compound, and the
// checks that keep impossible numbers out. Nothing is changed before all checks have passed.
#include <algorithm>

#include "rigid/impl.h"

namespace feder {
namespace {

// kg: beyond, products of inverses leave the float range

std::string text(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%g", x);
  return buffer;
}

// SceneError that says what was expected and what came.
void require(bool good, const char* what, double came) {
  if (!good) throw SceneError(std::string("body.") + what + ", got " + text(came));
}

void require_mass(Real mass) {
  require(mass >= kMinMass && mass <= kMaxMass,
          "mass: expected from 1e-9 to 1e14 kg (rock from 0.1 mm to 3 km in size; mind the density)", mass);
}

// Shapes with their pose in the body frame, nested compounds opened; a mesh that shall have a mass is the solid within.
void flatten(const ShapePtr& shape, const Pose& at, bool with_mass, std::vector<CompoundPart>& out) {
  const std::span<const CompoundPart> parts = shape->parts();
  if (parts.empty()) {
    const ShapePtr solid = with_mass ? shape->solid() : nullptr;
    out.push_back({solid ? solid : shape, at});
    return;
  }
  for (const CompoundPart& p : parts) {
    flatten(p.shape, at * p.pose, with_mass, out);
    out.back().surface = p.surface;
  }
}

bool finite_pose(const Pose& p) {
  return is_finite(p.position) && is_finite(p.rotation.vec()) && is_finite(p.rotation.w);
}

void check_motion(const BodyDesc& d) {
  require(is_finite(d.position), "position: expected three finite numbers", d.position.sum());
  const Quat& q = d.rotation;
  const Real n = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  require(is_finite(n) && n > Real(1e-6), "rotation: expected a quaternion that is not zero", n);
  require(is_finite(d.velocity), "velocity: expected three finite numbers", d.velocity.sum());
  require(is_finite(d.angular_velocity), "angular_velocity: expected three finite numbers", d.angular_velocity.sum());
  require(is_finite(d.surface_velocity), "surface_velocity: expected three finite numbers", d.surface_velocity.sum());
  require(is_finite(d.center_of_mass), "center_of_mass: expected three finite numbers", d.center_of_mass.sum());
  require(is_finite(d.gravity_scale), "gravity_scale: expected a finite number", d.gravity_scale);
}

void check_numbers(const BodyDesc& d) {
  const auto not_negative = [](Real x) { return x >= 0 && is_finite(x); };
  require(d.density > 0 && is_finite(d.density), "density: expected a number above 0", d.density);
  require(not_negative(d.mass), "mass: expected a number above 0", d.mass);
  require(not_negative(d.friction_static) && not_negative(d.friction_dynamic),
          "friction: expected a number not below 0", d.friction_static);
  require(d.restitution >= 0 && d.restitution <= 1, "restitution: expected a number from 0 to 1", d.restitution);
  require(not_negative(d.rolling_friction), "rolling_friction: expected a number not below 0", d.rolling_friction);
  require(not_negative(d.sleep_threshold), "sleep_threshold: expected a number not below 0", d.sleep_threshold);
  require(not_negative(d.linear_damping), "linear_damping: expected a number not below 0", d.linear_damping);
  require(not_negative(d.angular_damping), "angular_damping: expected a number not below 0", d.angular_damping);
}

// Cube root by Newton's method: the C library's differs between machines.
double cube_root(double x) {
  if (!(x > 0)) return 0;
  double r = x > 1 ? x : 1;
  for (int i = 0; i < 200; ++i) {
    const double next = r - (r * r * r - x) / (3 * r * r);
    if (!(next < r)) break;
    r = next;
  }
  return r;
}

// Moments of inertia that differ enough for gyroscopic motion.
bool uneven(const Mat3& inertia) {
  const Real mean = (inertia(0, 0) + inertia(1, 1) + inertia(2, 2)) / 3;
  return (inertia - mean * Mat3::Identity()).cwiseAbs().maxCoeff() > Real(1e-4) * mean;
}

// The parts of a description and what they weigh; SceneError where no body can be made of them.
BodySolid solid_of(const BodyDesc& d, int dimension) {
  BodySolid s;
  const ShapePtr whole = dimension == 2 ? d.shape->section() : d.shape;
  flatten(whole, Pose{}, d.type == BodyType::dynamic, s.parts);
  FEDER_ASSERT(!s.parts.empty());
  if (!whole->parts().empty()) s.surfaces.assign(whole->surfaces().begin(), whole->surfaces().end());
  std::vector<MassProperties> masses;
  masses.reserve(s.parts.size());
  for (const CompoundPart& p : s.parts) masses.push_back(transformed(p.shape->mass(1), p.pose));
  const MassProperties m = combined(masses);
  s.volume = m.mass;
  s.mass = d.mass > 0 ? d.mass : d.density * s.volume;
  s.inertia = m.inertia;
  if (s.volume > 0) s.inertia *= s.mass / s.volume;
  s.center = d.has_center ? d.center_of_mass : m.center;
  if (d.type != BodyType::dynamic) return s;
  for (const CompoundPart& p : s.parts)
    if (!(p.shape->mass(1).mass > 0))
      throw SceneError(std::string("body.shape: a ") + p.shape->kind() +
                       " has no volume and can only be static or kinematic");
  require_mass(s.mass);
  const Mat3 inv = dimension == 2 ? Mat3(Mat3::Identity() / s.inertia(2, 2)) : inverse(s.inertia);
  require(inv.allFinite() && inv.trace() > 0 && s.inertia.allFinite(), "shape: too small or too large for its mass",
          s.mass);
  return s;
}

}  // namespace

std::uint32_t Rigid::Impl::index(ObjectId body) const {
  const std::uint32_t i = objects.index(body, kBodyKind);
  FEDER_ASSERT(i < bodies.size() && bodies.object[i] == body);
  return i;
}

void Rigid::Impl::set_mass(std::uint32_t i) {
  const bool dynamic = bodies.type[i] == BodyType::dynamic;
  FEDER_ASSERT(!dynamic || (bodies.mass[i] >= kMinMass && bodies.mass[i] <= kMaxMass));
  bodies.inv_mass[i] = dynamic ? 1 / bodies.mass[i] : 0;
  bodies.inv_inertia[i] = Mat3::Zero();
  if (!dynamic) return;
  if (dimension == 2)
    bodies.inv_inertia[i](2, 2) = 1 / bodies.inertia[i](2, 2);
  else
    bodies.inv_inertia[i] = inverse(bodies.inertia[i]);
  load_principal(i);
  asymmetric[i] = dimension == 3 && !(bodies.lock[i] & (kLockRx | kLockRy | kLockRz)) && uneven(bodies.inertia[i]);
}

// Room for bodies that were added or loaded; their last edit counts as one of this step.
void Rigid::Impl::resize_arrays() {
  edited_step.resize(bodies.size(), now);
  each_array(*this, [&](auto& array) { array.resize(bodies.size()); });
  islands.resize(bodies.size());
}

// Pose, velocities, damping and locks of the new body i.
void Rigid::Impl::load_motion(std::uint32_t i, const BodyDesc& d, const Vec3& center) {
  bodies.type[i] = d.type;
  bodies.lock[i] = dimension == 2 ? std::uint8_t(d.lock | kLockZ | kLockRx | kLockRy) : d.lock;
  bodies.rotation[i] = normalized(d.rotation);
  bodies.local_com[i] = center;
  bodies.position[i] = d.position + rotate(bodies.rotation[i], center);
  const Real planar = dimension == 2 ? 0 : 1;
  bodies.velocity[i] = Vec3(d.velocity[0], d.velocity[1], planar * d.velocity[2]);
  bodies.angular_velocity[i] =
      Vec3(planar * d.angular_velocity[0], planar * d.angular_velocity[1], d.angular_velocity[2]);
  if (d.type == BodyType::fixed) bodies.velocity[i] = bodies.angular_velocity[i] = Vec3::Zero();
  bodies.gravity_scale[i] = d.gravity_scale;
  bodies.linear_damping[i] = d.linear_damping;
  bodies.angular_damping[i] = d.angular_damping;
  bodies.can_sleep[i] = d.can_sleep;
  bodies.sleep_threshold[i] = d.sleep_threshold;
  bodies.bullet[i] = d.bullet;
}

// Mass, size and what is kept of the rotation of the new body i.
void Rigid::Impl::load_mass(std::uint32_t i, const BodySolid& solid) {
  bodies.mass[i] = solid.volume > 0 ? solid.mass : 0;
  bodies.inertia[i] = solid.inertia;
  bodies.extent[i] = 0;
  for (const CompoundPart& p : solid.parts)
    bodies.extent[i] = std::max(bodies.extent[i], p.shape->extent(to_local(p.pose, solid.center)));
  level_trend[i] = 0;
  core_depth[i] = kInfinity;
  for (const CompoundPart& p : solid.parts) core_depth[i] = std::min(core_depth[i], collide.core_depth(*p.shape));
  volume[i] = solid.volume;
  const double radius = cube_root(static_cast<double>(solid.volume) * 3 / (4 * static_cast<double>(kPi)));
  area[i] = kPi * static_cast<Real>(radius * radius);
  pace[i] = 0;
  level[i] = sleep_candidate[i] = asymmetric[i] = 0;
  kept_momentum[i] = kept_angular_velocity[i] = Vec3::Zero();
  next_in_island[i] = kNone;
  set_mass(i);
}

ObjectId Rigid::Impl::add(const BodyDesc& d) {
  if (!d.shape) throw SceneError("body.shape: expected a shape, got none");
  check_motion(d);
  check_numbers(d);
  const BodySolid solid = solid_of(d, dimension);
  if (d.type == BodyType::free) throw SceneError("body.type: expected static, kinematic or dynamic");
  for (const CompoundPart& p : solid.parts) collide.check_shape(*p.shape);
  // from here on nothing fails
  const std::uint32_t i = bodies.add();
  resize_arrays();
  load_motion(i, d, solid.center);
  load_mass(i, solid);
  bodies.solver_slot[i] = solver_bodies.add();
  bodies.object[i] = objects.add(kBodyKind, i, d.name, d.tags);
  add_colliders(i, d, solid);
  if (d.type == BodyType::dynamic) {
    wake_one(i, WakeCause::none, {});
    if (d.sleeping) put_to_sleep(i);
  }
  if (d.type == BodyType::kinematic) bodies.awake[i] = 1;
  for (const CompoundPart& p : solid.parts) any_field = any_field || p.shape->inner_radius() > 0;
  for (const CompoundPart& p : solid.parts)
    if (!p.shape->warnings().empty() && (unsaid.empty() || unsaid.back() != bodies.object[i]))
      unsaid.push_back(bodies.object[i]);
  place_colliders(i, 0, Vec3::Zero());
  if (body_count++ == 0) *structure_changed = true;
  list_stale = true;
  return bodies.object[i];
}

// The surface of collider k: what its part states, then that part's material, then the body.
void Rigid::Impl::load_surface(std::uint32_t k, const BodyDesc& d, const ShapeSurface& own) {
  const std::string& name = own.material.empty() ? d.material : own.material;
  colliders.material[k] = name.empty() ? std::uint16_t(0) : collide.material(name);
  SurfaceNumbers stated, all{d.friction_static, d.friction_dynamic, d.restitution, d.rolling_friction};
  if (!own.material.empty()) stated = collide.material_numbers(colliders.material[k]);
  override_numbers(stated, own.numbers);
  override_numbers(all, stated);
  colliders.friction_static[k] = all.friction_static;
  colliders.friction_dynamic[k] = all.friction_dynamic;
  colliders.restitution[k] = all.restitution;
  colliders.rolling_friction[k] = all.rolling_friction;
  colliders.surface_velocity[k] = own.has_velocity ? own.velocity : d.surface_velocity;
  colliders.stated[k] = static_cast<std::uint8_t>(
      (stated.friction_static >= 0 ? kStatesStatic : 0) | (stated.friction_dynamic >= 0 ? kStatesDynamic : 0) |
      (stated.restitution >= 0 ? kStatesRestitution : 0) | (stated.rolling_friction >= 0 ? kStatesRolling : 0) |
      (own.has_velocity ? kStatesVelocity : 0));
  // materials of a mesh's triangles get their numbers
  for (const ShapeSurface& s : colliders.shape[k]->surfaces())
    if (!s.material.empty()) collide.material(s.material);
}

// One collider per part; what all of them share comes from the description.
void Rigid::Impl::add_colliders(std::uint32_t i, const BodyDesc& d, const BodySolid& solid) {
  const ShapeSurface none;
  // in reverse, so that the list of a body runs in the order of the parts
  for (auto part = solid.parts.rbegin(); part != solid.parts.rend(); ++part) {
    const std::uint32_t k = colliders.add();
    colliders.shape[k] = part->shape.get();
    colliders.shapes[k] = part->shape;
    colliders.local[k] = {part->pose.position - solid.center, part->pose.rotation};
    colliders.next_of_body[k] = bodies.first_collider[i];
    bodies.first_collider[i] = k;
    colliders.motion[k] = motion_of(d.type);
    colliders.owner[k] = ColliderOwner::body;
    colliders.owner_index[k] = i;
    colliders.solver_slot[k] = d.type == BodyType::fixed ? kNone : bodies.solver_slot[i];
    colliders.object[k] = bodies.object[i];
    colliders.sensor[k] = sensing(d.sensor, d.senses_fixed);
    colliders.bullet[k] = d.bullet;
    load_surface(k, d, part->surface ? solid.surfaces[part->surface - 1u] : none);
    colliders.group[k] = d.group;
    colliders.mask[k] = d.mask;
  }
}

// Poses and boxes of a body's colliders now; boxes include the motion within `dt`.
void Rigid::Impl::place_colliders(std::uint32_t i, Real dt, const Vec3& gravity) {
  FEDER_ASSERT(dt >= 0 && bodies.type[i] != BodyType::free);
  const Vec3& v = bodies.velocity[i];
  const Vec3& w = bodies.angular_velocity[i];
  const bool dynamic = bodies.type[i] == BodyType::dynamic;
  const Real pull = dynamic ? bodies.gravity_scale[i] * dt * dt : 0;
  const Vec3 step = v * dt + gravity * pull;
  const Pose com = bodies.com_pose(i);
  const Real angle = length(w) * dt;
  const bool moves =
      dynamic ? bodies.awake[i] != 0 : bodies.type[i] == BodyType::kinematic && (!v.isZero(0) || !w.isZero(0));
  each_collider(i, [&](std::uint32_t k) {
    FEDER_ASSERT(colliders.owner[k] == ColliderOwner::body && colliders.owner_index[k] == i);
    const Pose pose = com * colliders.local[k];
    colliders.pose[k] = pose;
    colliders.center[k] = com.position;
    colliders.velocity[k] = v;
    colliders.angular_velocity[k] = w;
    colliders.awake[k] = moves;
    const Shape& shape = *colliders.shape[k];
    Aabb box = shape.bounds(pose);
    FEDER_ASSERT(!(box.lo[0] > box.hi[0] || box.lo[1] > box.hi[1] || box.lo[2] > box.hi[2]));
    // rotation moves the shape out of its box by at most the arc of its farthest point, and by twice its extent
    const Real extent = bodies.extent[i];
    const Real arc = angle > 0 && is_finite(extent) ? std::min(angle * extent, 2 * extent) : Real(0);
    box.lo += step.cwiseMin(Real(0)) - Vec3::Constant(kContactMargin + arc);
    box.hi += step.cwiseMax(Real(0)) + Vec3::Constant(kContactMargin + arc);
    colliders.box[k] = box;
  });
}

void Rigid::Impl::changed(std::uint32_t i) {
  each_collider(i, [&](std::uint32_t k) {
    collide.forget(k);
    colliders.changed.push_back(k);
  });
}

void Rigid::Impl::set_pose(std::uint32_t i, const Pose& origin) {
  if (!finite_pose(origin)) throw SceneError("set_position: expected finite numbers");
  wake_touching(i, WakeCause::script);
  if (bodies.type[i] == BodyType::dynamic) wake(i, WakeCause::script, {});
  bodies.rotation[i] = normalized(origin.rotation);
  bodies.position[i] = origin.position + rotate(bodies.rotation[i], bodies.local_com[i]);
  bodies.has_target[i] = 0;
  kept_angular_velocity[i] = kept_momentum[i] = Vec3::Zero();
  spin_invariant[i] = kUnknownSpin;
  changed(i);
  edited(i);
  place_colliders(i, 0, Vec3::Zero());
  if (bodies.type[i] == BodyType::fixed) refresh_joints_of(i);
}

void Rigid::Impl::set_type(std::uint32_t i, BodyType type) {
  if (type == BodyType::free) throw SceneError("set_type: expected static, kinematic or dynamic");
  if (type == bodies.type[i]) return;
  FEDER_ASSERT(bodies.type[i] != BodyType::free && bodies.solver_slot[i] < solver_bodies.index.size());
  if (type == BodyType::dynamic) {
    each_collider(i, [&](std::uint32_t k) {
      if (!(colliders.shape[k]->mass(1).mass > 0))
        throw SceneError(std::string("set_type: a ") + colliders.shape[k]->kind() + " cannot be dynamic");
    });
    require_mass(bodies.mass[i]);
  }
  if (bodies.type[i] == BodyType::dynamic) wake(i, WakeCause::script, {});
  wake_touching(i, WakeCause::script);
  changed(i);
  edited(i);
  bodies.type[i] = type;
  bodies.awake[i] = type == BodyType::kinematic;
  bodies.has_target[i] = 0;
  if (type == BodyType::fixed) bodies.velocity[i] = bodies.angular_velocity[i] = Vec3::Zero();
  set_mass(i);
  each_collider(i, [&](std::uint32_t k) {
    colliders.motion[k] = motion_of(type);
    colliders.solver_slot[k] = type == BodyType::fixed ? kNone : bodies.solver_slot[i];
  });
  if (type == BodyType::dynamic) wake_one(i, WakeCause::none, {});
  place_colliders(i, 0, Vec3::Zero());
  refresh_joints_of(i);
  list_stale = true;
}

void Rigid::Impl::remove(std::uint32_t i, const std::string& where) {
  for (std::uint32_t j = 0; j < records.size(); ++j)
    if (records[j].alive && (records[j].body_a == i || records[j].body_b == i))
      remove_joint(j, where, WakeCause::destroyed);
  wake_touching(i, WakeCause::destroyed);
  if (bodies.type[i] == BodyType::dynamic) wake(i, WakeCause::destroyed, bodies.object[i]);
  FEDER_ASSERT(next_in_island[i] == kNone);  // else its ring would lead to a free index
  std::uint32_t k = bodies.first_collider[i];
  while (k != kNone) {
    const std::uint32_t next = colliders.next_of_body[k];
    collide.forget(k);
    colliders.remove(k);
    k = next;
  }
  solver_bodies.remove(bodies.solver_slot[i]);
  objects.remove(bodies.object[i], where);
  bodies.remove(i);
  FEDER_ASSERT(body_count > 0);
  if (--body_count == 0) *structure_changed = true;
  list_stale = true;
}

}  // namespace feder
