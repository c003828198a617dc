// Soft bodies: their skins. Pinned points get a mark.
#include "feder/soft.h"
#include "view/collector.h"

namespace feder::view {
namespace {

class SoftSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    Soft* all = c.world.find<Soft>();
    if (!all) return;
    for (std::size_t n = 0; n < all->soft_count(); ++n) {
      const Soft::Info soft = all->info(n);
      Bounds b;
      for (const Vec3& p : soft.points) b.include(to_float3(p), static_cast<float>(soft.thickness / 2));
      add_bounds(c.frame, b);
      if (c.toggles.meshes) add_mesh(c.frame, soft.object, c.color(soft.object, "soft"), soft.points, soft.skin);
      if (c.toggles.points) add_pins(c, soft);
      c.label(soft.object, soft.points[0], rgb(0x1d2126));
    }
  }

 private:
  void add_pins(Collecting& c, const Soft::Info& soft) const {
    const PointGroup group = begin_points(c.frame, soft.object, rgb(0x3a3f45));
    for (std::size_t i = 0; i < soft.points.size(); ++i)
      if (soft.inv_mass[i] == 0)
        c.frame.points.push_back({to_float3(soft.points[i]), static_cast<float>(soft.thickness), 0});
    end_points(c.frame, group);
  }
};

}  // namespace

Row view_soft() { return {"soft", make_source<SoftSource>}; }

}  // namespace feder::view
