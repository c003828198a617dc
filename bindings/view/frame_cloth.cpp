// Cloth: triangles with smooth normals, seen from both sides. Pinned vertices get a mark. With the layer `temporal`
// what trembles is drawn at rest: a drawn vertex follows by the share speed / (speed + kTremble) of its displacement
// per frame, so that it lags kTremble times the frame's time behind whatever moves steadily. It is drawn at most the
// thickness from where it is, so it lies no deeper in a collider than that.
#include <algorithm>

#include "feder/cloth.h"
#include "state/cloth_vertices.h"
#include "view/collector.h"

namespace feder::view {
namespace {

constexpr Real kTremble = Real(0.2);  // m/s

// Drawn vertices of one cloth, kept from frame to frame.
struct Drawn {
  ObjectId object;
  double time = 0;               // s, of the last frame
  std::vector<Vec3> seen, last;  // drawn; where they were
  bool used = false;             // in this frame
};

Vec3 within(const Vec3& from, const Vec3& to, Real most) {
  const Real size = length(to - from);
  return size > most ? from + (most / size) * (to - from) : to;
}

class ClothSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    Cloth* cloth = c.world.find<Cloth>();
    if (!cloth || !c.toggles.temporal) drawn_.clear();
    if (!cloth) return;
    for (Drawn& d : drawn_) d.used = false;
    for (std::size_t n = 0; n < cloth->cloth_count(); ++n) {
      const Cloth::Info sheet = cloth->info(n);
      cloth->smooth_positions(sheet.object, points_);
      if (c.toggles.temporal) calm(*cloth, sheet, c.world.time());
      Bounds b;
      for (const Vec3& p : points_) b.include(to_float3(p), static_cast<float>(sheet.thickness / 2));
      add_bounds(c.frame, b);
      if (c.toggles.meshes) add_mesh(c.frame, sheet.object, c.color(sheet.object, "cloth"), points_, sheet.triangles);
      if (c.toggles.points) add_pins(c, *cloth, sheet);
      if (!points_.empty()) c.label(sheet.object, points_[0], rgb(0x1d2126));
    }
    std::erase_if(drawn_, [](const Drawn& d) { return !d.used; });
  }

 private:
  void calm(const Cloth& cloth, const Cloth::Info& sheet, double time) {
    auto found = std::ranges::find(drawn_, sheet.object, &Drawn::object);
    if (found == drawn_.end()) found = drawn_.insert(found, Drawn{sheet.object, time, {}, {}});
    Drawn& d = *found;
    d.used = true;
    const auto passed = static_cast<Real>(time - d.time);
    // another mesh, or another past
    if (d.seen.size() != points_.size() || passed < 0) d.seen = d.last = points_;
    cloth.positions(sheet.object, true_);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Real speed = passed > 0 ? length(points_[i] - d.last[i]) / passed : Real(0);
      d.seen[i] += speed / (speed + kTremble) * (points_[i] - d.seen[i]);
      d.seen[i] = is_finite(d.seen[i]) ? within(true_[i], d.seen[i], sheet.thickness) : points_[i];
    }
    d.time = time, d.last = points_, points_ = d.seen;
  }

  void add_pins(Collecting& c, const Cloth& cloth, const Cloth::Info& sheet) const {
    Frame& f = c.frame;
    const PointGroup group = begin_points(f, sheet.object, rgb(0x3a3f45));
    for (std::uint32_t i = 0; i < sheet.count; ++i)
      if (cloth.vertices().inv_mass[sheet.first + i] == 0)
        f.points.push_back({to_float3(points_[i]), static_cast<float>(sheet.thickness), 0});
    end_points(f, group);
  }

  std::vector<Vec3> points_, true_;
  std::vector<Drawn> drawn_;
};
}  // namespace

Row view_cloth() { return {"cloth", make_source<ClothSource>}; }

}  // namespace feder::view
