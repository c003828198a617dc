// Cloth: triangles with smooth normals, seen from both sides. Pinned vertices get a mark.
#include <algorithm>

#include "feder/cloth.h"
#include "state/cloth_vertices.h"
#include "view/collector.h"

namespace feder::view {
namespace {

class ClothSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    Cloth* cloth = c.world.find<Cloth>();
    if (!cloth) return;
    for (std::size_t n = 0; n < cloth->cloth_count(); ++n) {
      const Cloth::Info sheet = cloth->info(n);
      cloth->smooth_positions(sheet.object, points_);
      Bounds b;
      for (const Vec3& p : points_) b.include(to_float3(p), static_cast<float>(sheet.thickness / 2));
      add_bounds(c.frame, b);
      if (c.toggles.meshes) add_mesh(c.frame, sheet.object, c.color(sheet.object, "cloth"), points_, sheet.triangles);
      if (c.toggles.points) add_pins(c, *cloth, sheet);
      if (!points_.empty()) c.label(sheet.object, points_[0], rgb(0x1d2126));
    }
  }

 private:
  void add_pins(Collecting& c, const Cloth& cloth, const Cloth::Info& sheet) const {
    Frame& f = c.frame;
    const PointGroup group = begin_points(f, sheet.object, rgb(0x3a3f45));
    for (std::uint32_t i = 0; i < sheet.count; ++i)
      if (cloth.vertices().inv_mass[sheet.first + i] == 0)
        f.points.push_back({to_float3(points_[i]), static_cast<float>(sheet.thickness), 0});
    end_points(f, group);
  }

  std::vector<Vec3> points_;
};
}  // namespace

Row view_cloth() { return {"cloth", make_source<ClothSource>}; }

}  // namespace feder::view
