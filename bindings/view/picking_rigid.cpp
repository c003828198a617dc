// Picking bodies: pulled by a critically damped spring at the point that is held.
#include <algorithm>

#include "feder/query.h"
#include "feder/rigid.h"
#include "state/bodies.h"
#include "view/picking.h"

namespace feder::view {
namespace {

constexpr double kPullHertz = 4;       // of the spring of a grip; softer where a step is too long for it
constexpr double kAngularDamping = 3;  // 1/s, of a held body
constexpr Real kFar = 10000;           // m

// 1 / mass of a body at a point and in a direction.
Real inv_mass_at(const Bodies& b, std::uint32_t i, const Vec3& arm, const Vec3& n) {
  const Vec3 turn = cross(arm, n);
  return b.inv_mass[i] + dot(turn, b.world_inv_inertia(i) * turn);
}

// Along `v`: v times the mass that is felt there, times `rate`.
Vec3 felt(const Bodies& b, std::uint32_t i, const Vec3& arm, const Vec3& v, Real rate) {
  const Vec3 n = normalized_or(v, Vec3::Zero());
  const Real w = inv_mass_at(b, i, arm, n);
  return w > 0 ? Vec3(v * (rate / w)) : Vec3(Vec3::Zero());
}

BodyType type_of(World& world, ObjectId body) {
  const Rigid& rigid = *world.find<Rigid>();
  return rigid.bodies().type[rigid.index(body)];
}

class BodyView final : public ObjectView {
 public:
  const ObjectKind& kind() const override { return kBodyKind; }

  void pick(World& world, const Ray& ray, Real, Real& depth, std::optional<Pick>& best) const override {
    Collide* collide = world.query<Collide>();
    RaycastHit hit;
    if (!collide || !collide->raycast(ray.origin, ray.direction * kFar, {}, hit)) return;
    if (!(hit.fraction * kFar < depth)) return;
    depth = hit.fraction * kFar;
    if (world.objects().kind(hit.object) == kBodyKind)
      best = Pick{hit.object, kNone, hit.point, depth, type_of(world, hit.object) == BodyType::dynamic};
  }
  Vec3 position(World& world, ObjectId body, std::uint32_t, const Vec3& local) const override {
    return to_world(world.find<Rigid>()->pose(body), local);
  }
  std::pair<std::string, Vec3> landmark(World& world, ObjectId body) const override {
    return {world.objects().name(body), world.find<Rigid>()->pose(body).position};
  }

  Grip grip(World& world, const Pick& p) const override {
    return {p.object, kNone, false, to_local(world.find<Rigid>()->pose(p.object), p.position), p.position};
  }
  Command take(const Grip& g) const override {
    return [g](lua::Script& s) { s.world()->find<Rigid>()->wake(g.object); };
  }
  Command pull(World& world, const Grip& g) const override {
    const double dt = world.desc().dt;
    const Rigid& rigid = *world.find<Rigid>();
    const Bodies& b = rigid.bodies();
    const std::uint32_t i = rigid.index(g.object);
    const Vec3 x = position(world, g.object, kNone, g.local);
    // critically damped; explicit, so its frequency times the step stays well below one
    const Real frequency = static_cast<Real>(std::min(2 * 3.14159265 * kPullHertz, 0.4 / dt));
    const Vec3 arm = x - b.position[i];
    Vec3 force =
        felt(b, i, arm, away(world, g), frequency * frequency) - felt(b, i, arm, b.velocity_at(i, x), 2 * frequency);
    force -= world.desc().gravity * (b.mass[i] * b.gravity_scale[i]);
    const Mat3 rotation = to_matrix(b.rotation[i]);
    const Vec3 torque = rotation * (b.inertia[i] * (rotation.transpose() * b.angular_velocity[i])) *
                        static_cast<Real>(-kAngularDamping);
    return [object = g.object, force, torque, x](lua::Script& s) {
      Rigid& r = *s.world()->find<Rigid>();
      if (!s.world()->objects().alive(object)) return;
      r.apply_force(object, force, &x);
      r.apply_torque(object, torque);
    };
  }
  Command release(World& world, const Grip& g, bool pin) const override {
    if (!pin) return [](lua::Script&) {};
    const Pick held{g.object, kNone, g.target, 0, true};
    return set_pinned(held, !is_pinned(world, held));
  }
  bool is_pinned(World& world, const Pick& p) const override { return type_of(world, p.object) == BodyType::fixed; }
  Command set_pinned(const Pick& p, bool pinned) const override {
    return [p, pinned](lua::Script& s) {
      s.world()->find<Rigid>()->set_type(p.object, pinned ? BodyType::fixed : BodyType::dynamic);
    };
  }

  bool keeps(World& world, ObjectId body) const override { return type_of(world, body) != BodyType::fixed; }
  Kept state(World& world, ObjectId body) const override {
    const Rigid& rigid = *world.find<Rigid>();
    const std::uint32_t i = rigid.index(body);
    const Pose pose = rigid.pose(body);
    return {{pose.position}, {rigid.bodies().velocity[i], rigid.bodies().angular_velocity[i]}, pose.rotation};
  }
  // Where the file says something new, of the pose or of the motion, the file is right.
  bool apply(World& world, ObjectId body, const Kept& was_built, const Kept& now) const override {
    const Kept built = state(world, body);
    const Quat &q = built.rotation, &r = was_built.rotation;
    const bool pose = built.position == was_built.position && q.x == r.x && q.y == r.y && q.z == r.z && q.w == r.w;
    const bool motion = built.velocity == was_built.velocity;
    Rigid& rigid = *world.find<Rigid>();
    if (pose) rigid.set_pose(body, {now.position[0], now.rotation});
    if (motion) rigid.set_velocity(body, now.velocity[0]), rigid.set_angular_velocity(body, now.velocity[1]);
    return pose || motion;
  }
};

}  // namespace

const ObjectView* live_rigid() {
  static const BodyView view;
  return &view;
}

}  // namespace feder::view
