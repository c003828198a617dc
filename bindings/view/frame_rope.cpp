// Ropes: tubes with smooth normals and round caps of one ring. Pinned points get a mark.
#include "feder/rope.h"
#include "view/collector.h"

namespace feder::view {
namespace {

constexpr std::uint32_t kSides = 8;

class RopeSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    Rope* ropes = c.world.find<Rope>();
    if (!ropes) return;
    for (std::size_t n = 0; n < ropes->rope_count(); ++n) {
      const Rope::Info rope = ropes->info(n);
      Bounds b;
      for (const Vec3& p : rope.points) b.include(to_float3(p), static_cast<float>(rope.radius));
      add_bounds(c.frame, b);
      if (c.toggles.meshes) {
        make_tube(rope);
        add_mesh(c.frame, rope.object, c.color(rope.object, "rope"), points_, faces_);
      }
      if (c.toggles.points) add_pins(c, rope);
      c.label(rope.object, rope.points[0], rgb(0x1d2126));
    }
  }

 private:
  // A ring of points round each point of the rope, in a frame that is carried along without twist; an end has a tip.
  void make_tube(const Rope::Info& rope) {
    points_.clear(), faces_.clear();
    const std::size_t count = rope.points.size();
    Vec3 across = Vec3::Zero();
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 along =
          normalized_or(Vec3(rope.points[i + 1 < count ? i + 1 : i] - rope.points[i > 0 ? i - 1 : 0]), Vec3(0, 1, 0));
      const Vec3 flat = across - dot(across, along) * along;
      if (!(dot(flat, flat) > Real(1e-4)))
        across =
            normalized_or(cross(along, std::abs(along[1]) < Real(0.9) ? Vec3(0, 1, 0) : Vec3(1, 0, 0)), Vec3(1, 0, 0));
      else
        across = normalized_or(flat, Vec3(1, 0, 0));
      const Vec3 third = cross(along, across);
      if (i == 0) points_.push_back(rope.points[0] - rope.radius * along);
      for (std::uint32_t k = 0; k < kSides; ++k) {
        static constexpr Real kHalf = Real(0.70710678);
        static constexpr Real kCosine[kSides] = {1, kHalf, 0, -kHalf, -1, -kHalf, 0, kHalf};
        const Real a = kCosine[k], b = kCosine[(k + 6) % kSides];
        points_.push_back(rope.points[i] + rope.radius * (a * across + b * third));
      }
      if (i + 1 == count) points_.push_back(rope.points[i] + rope.radius * along);
    }
    const auto ring = [](std::size_t i, std::uint32_t k) {
      return static_cast<std::uint32_t>(1 + i * kSides) + k % kSides;
    };
    const auto last = static_cast<std::uint32_t>(points_.size() - 1);
    for (std::uint32_t k = 0; k < kSides; ++k) {
      faces_.insert(faces_.end(), {0u, ring(0, k + 1), ring(0, k)});
      for (std::size_t i = 0; i + 1 < count; ++i)
        faces_.insert(faces_.end(),
                      {ring(i, k), ring(i, k + 1), ring(i + 1, k), ring(i, k + 1), ring(i + 1, k + 1), ring(i + 1, k)});
      faces_.insert(faces_.end(), {last, ring(count - 1, k), ring(count - 1, k + 1)});
    }
  }

  void add_pins(Collecting& c, const Rope::Info& rope) const {
    const PointGroup group = begin_points(c.frame, rope.object, rgb(0x3a3f45));
    for (std::size_t i = 0; i < rope.points.size(); ++i)
      if (rope.inv_mass[i] == 0)
        c.frame.points.push_back({to_float3(rope.points[i]), static_cast<float>(Real(1.5) * rope.radius), 0});
    end_points(c.frame, group);
  }

  std::vector<Vec3> points_;
  std::vector<std::uint32_t> faces_;
};

}  // namespace

Row view_rope() { return {"rope", make_source<RopeSource>}; }

}  // namespace feder::view
