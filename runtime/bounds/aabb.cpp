// Axis-aligned box: exact tests of six comparisons, merged and refitted without loss. Loose around what lies askew.
#include "bounds/hierarchy_of.h"
#include "bounds/segment_box.h"

namespace feder {
namespace {

struct AabbVolume {
  Aabb box;

  static AabbVolume around(std::span<const Vec3> points, bool) {
    AabbVolume v;
    for (const Vec3& p : points) v.box.include(p);
    return v;
  }
  static AabbVolume joined(const AabbVolume& a, const AabbVolume& b) {
    AabbVolume v = a;
    v.box.include(b.box);
    return v;
  }
  bool contains(const Vec3& p) const { return overlaps({Aabb{p, p}}); }
  bool overlaps(const AabbVolume& o) const { return feder::overlaps(box, o.box); }
  bool meets(const Aabb& other) const { return feder::overlaps(box, other); }
  bool meets_ray(const Vec3& origin, const Vec3& ray) const { return segment_hits(box, origin, ray); }
  double cost() const { return half_surface(box); }
  double volume() const {
    const Vec3 d = box.hi - box.lo;
    return static_cast<double>(d[0]) * static_cast<double>(d[1]) * static_cast<double>(d[2]);
  }
  bool edges(EdgeVisitor visit) const { return edges_of_box(box, visit); }
};

}  // namespace

VolumeKind bounds_aabb() { return volume_kind<AabbVolume>("aabb", "axis-aligned box: exact, refits without loss"); }

}  // namespace feder
