// Where a cloth may cross itself: contact looks there and leads crossings out (contact/tangles.cpp). A cloth that was
// made from a mesh or a snapshot may, one of which vertices were put somewhere does near them, and where it tore, until
// contact sees both sides; while crossings are left, all of it. Nothing else makes crossings, so nothing else is
// searched. When their number has not fallen for kPatience steps a warning says so, and the search ends.
#include "cloth/impl.h"
#include "geom/crossings.h"

namespace feder {
namespace {
constexpr std::uint32_t kPatience = 300;  // steps
}  // namespace

bool Cloth::Impl::untangles(const Sheet& s) { return s.state.tangles > 0 && s.state.tangled_steps < kPatience; }

Aabb Cloth::Impl::suspects(const Sheet& s) {
  Aabb all;
  const Vec3* x = vertices.position.data() + s.first;
  if (s.suspect || untangles(s) || s.state.suspect_steps > 0) return bounds_of({x, s.points});
  if (s.edited.empty()) return all;
  edited_vertex.assign(s.points, 0);
  for (const std::uint32_t i : s.edited) edited_vertex[i] = 1;
  for (std::size_t t = 0; t < s.mesh.triangles.size(); t += 3) {
    const std::uint32_t* v = &s.mesh.triangles[t];
    if (!edited_vertex[v[0]] && !edited_vertex[v[1]] && !edited_vertex[v[2]]) continue;
    for (int k = 0; k < 3; ++k) all.include(x[v[k]]);
  }
  return all;
}

// What contact left of the crossings in this step.
void Cloth::Impl::read_tangles(StepContext& c) {
  for (std::size_t n = 0; n < sheets.size(); ++n) {
    Sheet& s = *sheets[n];
    if (!s.active()) continue;
    const bool edited = s.suspect || !s.edited.empty();
    s.suspect = false;
    s.edited.clear();
    if (s.state.suspect_steps > 0) --s.state.suspect_steps;
    const std::uint32_t left = surfaces.list[n].tangles;
    if (left == kNone) continue;
    const bool fell = left < s.state.tangles || s.state.tangles == 0 || edited;
    s.state.tangled_steps = fell || left == 0 ? 0 : s.state.tangled_steps + 1;
    s.state.tangles = left;
    if (left == 0) s.state.warned_tangles = 0;
    if (left == 0 || s.state.tangled_steps < kPatience || s.state.warned_tangles) continue;
    s.state.warned_tangles = 1;
    c.events->warn("tangled",
                   objects.describe(s.object) + " crosses itself in " + std::to_string(left) +
                       " places that do not come apart: move vertices apart by set_point, or let the material do it " +
                       "with inside = \"ignore\" or self_collision = false",
                   s.object);
  }
}

}  // namespace feder
