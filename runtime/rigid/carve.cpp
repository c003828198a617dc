// Bodies that lose or gain material: their field with another solid cut out or welded on. Density, pose and the motion
// of every point stay; what is cut off becomes bodies of their own. All that can fail comes first.
#include <cmath>

#include "feder/sdf.h"
#include "rigid/impl.h"

namespace feder {
namespace {

constexpr Real kStaticDensity = 1000;  // kg/m3, of what comes off a body without a mass

Pose inverse(const Pose& p) {
  const Quat back = conjugate(p.rotation);
  return {-rotate(back, p.position), back};
}

ShapePtr field_of(const ShapePtr& shape) {
  if (sdf_report(*shape)) return shape;
  if (ShapePtr solid = shape->solid()) return solid;
  return make_sdf({.shape = shape});
}

}  // namespace

// The only collider of a body; SceneError for compounds.
std::uint32_t Rigid::Impl::only_collider(std::uint32_t i, const char* verb) const {
  const std::uint32_t k = bodies.first_collider[i];
  if (k == kNone || colliders.next_of_body[k] != kNone)
    throw SceneError(std::string(verb) +
                     ": expected a body of one shape, got a compound; make it a field by feder.sdf");
  return k;
}

BodySolid Rigid::Impl::solid_like(std::uint32_t i, const ShapePtr& shape, const Pose& place, Real density) const {
  BodySolid s;
  s.parts = {{shape, place}};
  const MassProperties m = transformed(shape->mass(1), place);
  s.volume = m.mass, s.mass = density * m.mass, s.center = m.center, s.inertia = density * m.inertia;
  if (bodies.type[i] == BodyType::dynamic && !(s.mass >= kMinMass && s.mass <= kMaxMass))
    throw SceneError("carve: what is left weighs " + std::to_string(s.mass) + " kg; expected from 1e-9 to 1e14");
  return s;
}

void Rigid::Impl::carve(std::uint32_t i, const ShapePtr& tool, const Pose& place, bool weld) {
  const char* verb = weld ? "weld_on" : "carve";
  if (!tool) throw SceneError(std::string(verb) + ".shape: expected a shape, got none");
  if (!is_finite(place.position)) throw SceneError(std::string(verb) + ".position: expected finite numbers");
  if (dimension == 2) throw SceneError(std::string(verb) + ": fields are solids; expected a world of three dimensions");
  const std::uint32_t k = only_collider(i, verb);
  const Pose own{colliders.local[k].position + bodies.local_com[i], colliders.local[k].rotation};  // in the body frame
  const ShapePtr field = field_of(colliders.shapes[k]);
  const Pose there = inverse(own) * place;
  const std::vector<ShapePtr> parts =
      sdf_parts(weld ? sdf_union(*field, *tool, there) : sdf_subtract(*field, *tool, there));
  const Real density = volume[i] > 0 && bodies.mass[i] > 0 ? bodies.mass[i] / volume[i] : kStaticDensity;
  std::vector<BodySolid> solids;
  for (const ShapePtr& part : parts) solids.push_back(solid_like(i, part, own, density));
  // from here on nothing fails
  wake_touching(i, WakeCause::script);
  if (bodies.type[i] == BodyType::dynamic) wake(i, WakeCause::script, {});
  const Pose origin = bodies.origin_pose(i);
  BodyDesc like = description_of(i, k);
  const Vec3 old_center = bodies.position[i], v = bodies.velocity[i], w = bodies.angular_velocity[i];
  const auto velocity_at = [&](const BodySolid& s) {
    return Vec3(v + cross(w, to_world(origin, s.center) - old_center));
  };
  // the largest stays this body
  const BodySolid& kept = solids[0];
  changed(i), edited(i);
  const Vec3 moved_by = kept.center - bodies.local_com[i];
  for (JointRecord& r : records) {
    if (r.alive && r.body_a == i) r.local_a.position -= moved_by;
    if (r.alive && r.body_b == i) r.local_b.position -= moved_by;
  }
  bodies.local_com[i] = kept.center;
  bodies.position[i] = to_world(origin, kept.center);
  bodies.velocity[i] = velocity_at(kept);
  colliders.shapes[k] = kept.parts[0].shape, colliders.shape[k] = colliders.shapes[k].get();
  colliders.local[k] = {own.position - kept.center, own.rotation};
  load_mass(i, kept);
  spin_invariant[i] = kUnknownSpin;
  if (bodies.type[i] == BodyType::dynamic) wake_one(i, WakeCause::none, {});
  place_colliders(i, 0, Vec3::Zero());
  refresh_joints_of(i);
  any_field = true;
  const ObjectId body = bodies.object[i];
  if (solids.size() == 1) carved_off.push_back({body, {}});
  for (std::size_t n = 1; n < solids.size(); ++n) {
    like.shape = solids[n].parts[0].shape;
    like.position = to_world(origin, own.position), like.rotation = origin.rotation * own.rotation;
    like.density = density, like.mass = 0;
    like.velocity = velocity_at(solids[n]), like.angular_velocity = w;
    const ObjectId piece = add(like);
    colliders.material[bodies.first_collider[index(piece)]] = colliders.material[k];
    carved_off.push_back({body, piece});
  }
}

// What a part of body i takes over from it.
BodyDesc Rigid::Impl::description_of(std::uint32_t i, std::uint32_t k) const {
  BodyDesc d;
  d.type = bodies.type[i];
  d.tags = objects.tags(bodies.object[i]);
  d.friction_static = colliders.friction_static[k], d.friction_dynamic = colliders.friction_dynamic[k];
  d.restitution = colliders.restitution[k], d.rolling_friction = colliders.rolling_friction[k];
  d.surface_velocity = colliders.surface_velocity[k];
  d.group = colliders.group[k], d.mask = colliders.mask[k];
  d.linear_damping = bodies.linear_damping[i], d.angular_damping = bodies.angular_damping[i];
  d.gravity_scale = bodies.gravity_scale[i];
  d.lock = bodies.lock[i], d.bullet = bodies.bullet[i], d.can_sleep = bodies.can_sleep[i];
  d.sleep_threshold = bodies.sleep_threshold[i];
  return d;
}

void Rigid::carve(ObjectId body, const ShapePtr& tool, const Pose& place) {
  const Command command(impl_->commands, "rigid.carve", body, tool, place);
  impl_->carve(impl_->index(body), tool, place, false);
}
void Rigid::weld_on(ObjectId body, const ShapePtr& shape, const Pose& place) {
  const Command command(impl_->commands, "rigid.weld_on", body, shape, place);
  impl_->carve(impl_->index(body), shape, place, true);
}

}  // namespace feder
