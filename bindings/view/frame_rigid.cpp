// Rigid bodies as instances, grouped by geometry in two passes (count, fill); planes as grounds. What a collider
// appears as is worked out when it is first seen and kept by collider index.
#include <algorithm>
#include <bit>
#include <cmath>

#include "feder/query.h"
#include "feder/rigid.h"
#include "state/bodies.h"
#include "state/colliders.h"
#include "view/collector.h"

namespace feder::view {
namespace {

constexpr std::uint8_t kSensorAlpha = 70;
constexpr std::uint32_t kAxisColors[] = {0xd03a2f, 0x3a9d3a, 0x2f62d0};

class RigidSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    Rigid* rigid = c.world.find<Rigid>();
    Collide* collide = c.world.find<Collide>();
    if (!rigid || !collide) return;
    const Bodies& bodies = rigid->bodies();
    const Colliders& colliders = collide->colliders();
    if (c.toggles.shapes) collect_shapes(c, bodies, colliders);
    if (c.toggles.velocities || c.toggles.axes || c.toggles.labels) collect_records(c, bodies);
    if (c.toggles.bounds)
      for (std::uint32_t k = 0; k < colliders.size(); ++k)
        if (colliders.motion[k] != ColliderMotion::none)
          add_box(c.frame.overlay_lines, colliders.box[k], rgb(colliders.awake[k] ? 0xd8a13c : 0x8a8f98));
  }

 private:
  struct Seen {
    const Shape* shape = nullptr;
    ObjectId object;
    ColliderMotion motion = ColliderMotion::none;
    std::uint8_t sensor = 0;
    Fitted fitted;
    Color awake, asleep;
  };

  static bool drawn(const Collecting& c, const Colliders& k, std::uint32_t i) {
    return k.motion[i] != ColliderMotion::none && k.owner[i] == ColliderOwner::body &&
           (!k.sensor[i] || c.toggles.sensors);
  }

  void collect_shapes(Collecting& c, const Bodies& bodies, const Colliders& colliders) {
    if (appearance_version_ != c.appearance.version) seen_.clear(), appearance_version_ = c.appearance.version;
    seen_.resize(colliders.size());
    std::fill(count_.begin(), count_.end(), 0);
    for (std::uint32_t k = 0; k < colliders.size(); ++k) {
      if (!drawn(c, colliders, k)) continue;
      const Seen& s = see(c, colliders, k);
      if (s.fitted.geometry == kNone) {
        add_ground(c, bodies, colliders, k);
        continue;
      }
      const std::size_t key = 2 * s.fitted.geometry + (s.awake.a < 255 ? 1 : 0);
      if (key >= count_.size()) count_.resize(key + 1, 0), index_.resize(key + 1, 0);
      ++count_[key];
    }
    make_batches(c.frame);
    for (std::uint32_t k = 0; k < colliders.size(); ++k)
      if (drawn(c, colliders, k) && seen_[k].fitted.geometry != kNone) add_instance(c.frame, bodies, colliders, k);
  }

  // Opaque batches first.
  void make_batches(Frame& f) {
    auto at = static_cast<std::uint32_t>(f.instances.size());
    for (const std::size_t translucent : {0u, 1u})
      for (std::size_t key = translucent; key < count_.size(); key += 2) {
        if (count_[key] == 0) continue;
        f.batches.push_back({static_cast<std::uint32_t>(key / 2), at, count_[key], translucent == 1});
        index_[key] = at;
        at += count_[key];
      }
    f.instances.resize(at);
  }

  const Seen& see(Collecting& c, const Colliders& colliders, std::uint32_t k) {
    Seen& s = seen_[k];
    if (s.shape == colliders.shape[k] && s.object == colliders.object[k] && s.motion == colliders.motion[k] &&
        s.sensor == colliders.sensor[k])
      return s;
    s.shape = colliders.shape[k], s.object = colliders.object[k], s.motion = colliders.motion[k];
    s.sensor = colliders.sensor[k];
    s.fitted = c.geometry.fit(colliders.shapes[k]);
    s.awake = color_of(c, s);
    s.asleep = feder::view::asleep(s.awake);
    return s;
  }

  static Color color_of(Collecting& c, const Seen& s) {
    const Objects& objects = c.world.objects();
    std::string_view group = s.shape->kind();
    if (const TagMask tags = objects.tags(s.object))
      group = objects.tag_names()[static_cast<std::size_t>(std::countr_zero(tags))];
    Color color = s.motion == ColliderMotion::fixed && !s.sensor
                      ? c.own_color(s.object).value_or(fixed_color(s.object.slot))
                      : c.color(s.object, group);
    const auto clear = c.appearance.transparencies.find(s.object);
    if (clear != c.appearance.transparencies.end())
      color.a = static_cast<std::uint8_t>(std::lround(255 * (1 - clear->second)));
    if (s.sensor) color.a = kSensorAlpha;
    return color;
  }

  static void add_ground(Collecting& c, const Bodies& bodies, const Colliders& colliders, std::uint32_t k) {
    Vec3 normal;
    Real distance;
    if (!colliders.shape[k]->half_space(normal, distance)) return;
    const Pose pose = bodies.com_pose(colliders.owner_index[k]) * colliders.local[k];
    const Vec3 n = rotate(pose.rotation, normal);
    const ObjectId object = colliders.object[k];
    c.frame.grounds.push_back({to_float3(n), static_cast<float>(distance + dot(n, pose.position)),
                               c.own_color(object).value_or(rgb(0xc2c1bd)), object});
  }

  void add_instance(Frame& f, const Bodies& bodies, const Colliders& colliders, std::uint32_t k) {
    const Seen& s = seen_[k];
    const std::uint32_t body = colliders.owner_index[k];
    const Pose pose = bodies.com_pose(body) * colliders.local[k];
    const bool rests = s.motion == ColliderMotion::dynamic && !bodies.awake[body];
    Instance& out = f.instances[index_[2 * s.fitted.geometry + (s.awake.a < 255 ? 1 : 0)]++];
    const Quat& q = pose.rotation;
    out = {to_float3(pose.position),
           {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z), static_cast<float>(q.w)},
           s.fitted.scale,
           s.fitted.stretch,
           rests ? s.asleep : s.awake,
           s.object.slot,
           (rests ? kAsleep : 0u) | (s.sensor ? kSensor : 0u) | (s.motion == ColliderMotion::fixed ? kFixed : 0u)};
    const Aabb box = s.shape->bounds(pose);
    const Bounds b{to_float3(box.lo), to_float3(box.hi)};
    f.bounds.include(b);
    if (s.motion != ColliderMotion::fixed && !s.sensor) f.moving.include(b);
  }

  static void collect_records(Collecting& c, const Bodies& bodies) {
    for (std::uint32_t i = 0; i < bodies.size(); ++i) {
      if (bodies.type[i] == BodyType::free) continue;
      const Vec3& x = bodies.position[i];
      const Real size = std::min(bodies.extent[i], Real(4));
      if (c.toggles.velocities && bodies.type[i] != BodyType::fixed)
        add_arrow(c.frame.overlay_lines, x, Vec3(Real(0.2) * bodies.velocity[i]), rgb(0x2b8a3e), 2);
      if (c.toggles.axes && bodies.type[i] != BodyType::fixed)
        for (int axis = 0; axis < 3; ++axis) {
          const Vec3 e = vec3(axis == 0, axis == 1, axis == 2);
          add_line(c.frame.overlay_lines, x, Vec3(x + size * rotate(bodies.rotation[i], e)), rgb(kAxisColors[axis]), 2);
        }
      if (std::isfinite(bodies.extent[i])) c.label(bodies.object[i], x, rgb(0x1d2126));
    }
  }

  std::vector<Seen> seen_;                    // by collider
  std::vector<std::uint32_t> count_, index_;  // by 2 * geometry + translucent
  std::uint64_t appearance_version_ = 0;
};

}  // namespace

Row view_rigid() { return {"rigid", make_source<RigidSource>}; }

}  // namespace feder::view
