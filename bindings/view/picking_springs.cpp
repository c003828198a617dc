// Picking points of nets: pinned while they are held, and led to the mouse at a bounded speed.
#include <algorithm>

#include "feder/net.h"
#include "view/picking.h"

namespace feder::view {
namespace {

class NetView final : public ObjectView {
 public:
  const ObjectKind& kind() const override { return kNetKind; }

  // The point that the ray misses by the least angle.
  void pick(World& world, const Ray& ray, Real slack, Real& depth, std::optional<Pick>& best) const override {
    const Springs* springs = world.find<Springs>();
    if (!springs) return;
    Real best_angle = slack;
    world.objects().for_each(kNetKind, [&](ObjectId id) {
      const std::size_t count = springs->point_count(id);
      for (std::size_t i = 0; i < count; ++i) {
        const Vec3 x = springs->point(id, i);
        const Vec3 to = x - ray.origin;
        const Real along = dot(to, ray.direction);
        if (!(along > 0) || along > depth + Real(0.02) * along) continue;
        const Real angle = length(to - along * ray.direction) / along;
        if (angle >= best_angle) continue;
        best_angle = angle;
        best = Pick{id, static_cast<std::uint32_t>(i), x, along, true};
      }
    });
  }
  bool has_point(World& world, ObjectId net, std::uint32_t point) const override {
    return point < world.find<Springs>()->point_count(net);
  }
  Vec3 position(World& world, ObjectId net, std::uint32_t point, const Vec3&) const override {
    return world.find<Springs>()->point(net, point == kNone ? 0 : point);
  }
  std::pair<std::string, Vec3> landmark(World& world, ObjectId net) const override {
    const Springs& springs = *world.find<Springs>();
    const std::string& name = world.objects().name(net);
    const std::size_t count = springs.point_count(net);
    if (name.empty() || count == 0) return {};
    return {name + " end", springs.point(net, count - 1)};
  }

  Grip grip(World& world, const Pick& p) const override {
    return {p.object, p.point, is_pinned(world, p), Vec3::Zero(), p.position};
  }
  Command take(const Grip& g) const override {
    return [g](lua::Script& s) { s.world()->find<Springs>()->pin(g.object, g.point); };
  }
  // Nets are stiff, a force would have to be stiffer: the point is moved.
  Command pull(World& world, const Grip& g) const override {
    const double dt = world.desc().dt;
    const Real share = static_cast<Real>(std::min(1.0, 15 * dt));
    const Vec3 to = away(world, g);
    const Vec3 next = position(world, g.object, g.point, Vec3::Zero()) + to * share;
    const Vec3 v = to * static_cast<Real>(share / dt);
    return [g, next, v](lua::Script& s) {
      Springs& springs = *s.world()->find<Springs>();
      springs.set_point(g.object, g.point, next);
      springs.set_velocity(g.object, g.point, v);
    };
  }
  Command release(World& world, const Grip& g, bool pin) const override {
    if (pin || g.was_pinned) return [](lua::Script&) {};
    const Vec3 v = world.find<Springs>()->velocity(g.object, g.point);
    return [g, v](lua::Script& s) {
      Springs& springs = *s.world()->find<Springs>();
      springs.unpin(g.object, g.point);
      springs.set_velocity(g.object, g.point, v);
    };
  }
  bool is_pinned(World& world, const Pick& p) const override {
    return p.point != kNone && world.find<Springs>()->pinned(p.object, p.point);
  }
  Command set_pinned(const Pick& p, bool pinned) const override {
    if (p.point == kNone) return {};
    return [p, pinned](lua::Script& s) {
      Springs& springs = *s.world()->find<Springs>();
      pinned ? springs.pin(p.object, p.point) : springs.unpin(p.object, p.point);
    };
  }

  bool keeps(World&, ObjectId) const override { return true; }
  Kept state(World& world, ObjectId net) const override {
    const Springs& springs = *world.find<Springs>();
    Kept s;
    for (std::size_t i = 0; i < springs.point_count(net); ++i)
      s.position.push_back(springs.point(net, i)), s.velocity.push_back(springs.velocity(net, i));
    return s;
  }
  // Nets need the same number of points.
  bool apply(World& world, ObjectId net, const Kept& was_built, const Kept& now) const override {
    const Kept built = state(world, net);
    if (built.position.size() != now.position.size() || built.position != was_built.position) return false;
    Springs& springs = *world.find<Springs>();
    for (std::size_t i = 0; i < now.position.size(); ++i) {
      springs.set_point(net, i, now.position[i]);
      springs.set_velocity(net, i, now.velocity[i]);
    }
    return true;
  }
};

}  // namespace

const ObjectView* live_springs() {
  static const NetView view;
  return &view;
}

}  // namespace feder::view
