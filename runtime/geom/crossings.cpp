#include "geom/crossings.h"

#include <algorithm>

#include "geom/predicates.h"

namespace feder {

Aabb bounds_of(std::span<const Vec3> points) {
  Aabb all;
  for (const Vec3& p : points) all.include(p);
  return all;
}

void CrossingSearch::find(const CrossingMesh& m, const Aabb& where, Array<Crossing>& out, std::size_t most) {
  FEDER_ASSERT(m.triangles.size() % 3 == 0);
  out.clear(), chosen_.clear(), box_.clear();
  const Vec3* x = m.points.data();
  for (std::uint32_t t = 0; t < m.triangles.size() / 3; ++t) {
    const std::uint32_t* v = &m.triangles[3 * t];
    Aabb box{x[v[0]], x[v[0]]};
    box.include(x[v[1]]), box.include(x[v[2]]);
    if (overlaps(box, where)) chosen_.push_back(t), box_.push_back(box);
  }
  tree_.build({box_.data(), box_.size()});
  for (std::uint32_t e = 0; e < m.edges && out.size() <= most; ++e) {
    const std::uint32_t a = m.edge(e)[0], b = m.edge(e)[1];
    FEDER_ASSERT(a < m.points.size() && b < m.points.size());
    Aabb box{x[a], x[a]};
    box.include(x[b]);
    if (!overlaps(box, where)) continue;
    const std::size_t first = out.size();
    tree_.query(box, [&](std::uint32_t k) {
      const std::uint32_t t = chosen_[k], *v = &m.triangles[3 * t];
      for (int i = 0; i < 3; ++i)
        if (v[i] == a || v[i] == b) return;
      if (passes_through(x[a], x[b], x[v[0]], x[v[1]], x[v[2]])) out.push_back({e, t});
    });
    std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
              [](const Crossing& p, const Crossing& q) { return p.triangle < q.triangle; });
  }
}

}  // namespace feder
