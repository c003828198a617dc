// Where a cloth may cross itself: contact looks there and leads crossings out (contact/tangles.cpp). A cloth that was
// made from a mesh or a snapshot may, one of which vertices were put somewhere does near them, and where it tore, until
// contact sees both sides; while crossings are left, all of it. Nothing else makes crossings, so nothing else is
// searched. A cloth with more crossings than edges is released: without contact with itself the material pulls it
// straight, until there are half as many; so is one, for some steps at most, of which vertices were put far away. After
// kStuck steps in which there are not fewer than ever, what crosses is left to the material as with inside = "ignore".
// After kPatience steps a warning says so and the cloth rests: it is only counted, when released not even that, and
// next tried after kPatience steps, then after twice as many, and so on.
#include <algorithm>

#include "cloth/impl.h"
#include "geom/crossings.h"

namespace feder {
namespace {
constexpr std::uint32_t kPatience = 180;                  // steps
constexpr std::uint32_t kStuck = 30;                      // steps
constexpr std::uint32_t kMaxDoublings = 4;                // of a rest
constexpr std::uint32_t kTrialsFalling = 6, kTrials = 2;  // moves in a step: while the number falls, and otherwise
constexpr std::uint32_t kStepsPerRing = 20;
// Crossings above which a cloth is released, and held again: edges by these, and some in coarse meshes.
constexpr std::uint32_t kReleased = 1, kHeld = 2, kMinReleased = 16, kMinHeld = 8;
constexpr Real kOverstretched = 4;  // rest lengths of an edge

// An edge is so long that contact would hold back for seconds what pulls it together.
bool overstretched(const ClothMesh& m, const Vec3* x, const Vec3* rest) {
  return std::any_of(m.edges.begin(), m.edges.end(), [&](const ClothEdge& e) {
    return length(x[e.b] - x[e.a]) > kOverstretched * length(rest[e.b] - rest[e.a]);
  });
}
}  // namespace

bool Cloth::Impl::untangles(const Sheet& s) { return s.state.tangles > 0 && s.state.tangles_rest == 0; }

Aabb Cloth::Impl::suspects(const Sheet& s) {
  Aabb all;
  const Vec3* x = vertices.position.data() + s.first;
  if (s.suspect || s.state.tangles > 0 || s.state.suspect_steps > 0) return bounds_of({x, s.points});
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

// What contact is to do about crossings in this step.
void Cloth::Impl::show_tangles(const Sheet& s, Surface& f) {
  const ClothState& t = s.state;
  f.ignores_inside = s.settings.ignores_inside || (t.tangles > 0 && t.tangled_steps >= kStuck);
  const bool resting = t.released && t.tangles_rest > 0 && !t.edited;
  const bool put = t.edited || t.suspect_steps > 0;
  f.self = !resting && !(put && overstretched(s.mesh, &vertices.position[s.first], &vertices.rest[s.first]));
  if (!f.self) return;
  f.suspects = suspects(s);
  const auto edges = static_cast<std::uint32_t>(s.mesh.edges.size());
  f.most_tangles = t.released ? std::max(kMinHeld, edges / kHeld) : std::max(kMinReleased, edges / kReleased);
  if (t.tangles_rest > 0 || s.settings.ignores_inside) return;
  f.untangle_trials = t.tangled_steps == 0 ? kTrialsFalling : kTrials;
  f.untangle_rings = t.tangled_steps / kStepsPerRing;
}

// What contact left of the crossings in this step.
void Cloth::Impl::read_tangles(StepContext& c) {
  for (std::size_t n = 0; n < sheets.size(); ++n) {
    Sheet& s = *sheets[n];
    if (!s.active()) continue;
    ClothState& t = s.state;
    const bool edited = t.edited != 0;
    t.edited = 0, s.suspect = false, s.edited.clear();
    if (t.suspect_steps > 0) --t.suspect_steps;
    if (t.tangles_rest > 0 && --t.tangles_rest == 0) t.tangled_steps = 0, t.least_tangles = t.tangles;
    const std::uint32_t left = surfaces.list[n].tangles;
    if (left == kNone) continue;
    const bool released = left > surfaces.list[n].most_tangles, held = t.released && !released;
    const bool rose = edited && left > t.tangles;
    t.tangles = left, t.released = released;
    if (left == 0) {
      t.least_tangles = t.tangled_steps = t.tangles_rest = t.tangles_rests = t.warned_tangles = 0;
      continue;
    }
    // progress: fewer than ever; the count of a released cloth says nothing
    if (held || rose || t.least_tangles == 0 || (!released && left < t.least_tangles)) {
      t.least_tangles = left, t.tangled_steps = t.tangles_rest = t.tangles_rests = 0;
      continue;
    }
    if (t.tangles_rest > 0 || ++t.tangled_steps < kPatience) continue;
    t.tangles_rest = kPatience << std::min(t.tangles_rests, kMaxDoublings);
    ++t.tangles_rests;
    if (t.warned_tangles || s.settings.ignores_inside) continue;
    t.warned_tangles = 1;
    c.events->warn("tangled",
                   objects.describe(s.object) + " crosses itself in " + (released ? "at least " : "") +
                       std::to_string(left) + " places that do not come apart" +
                       (released ? ", and has no contact with itself meanwhile" : "") +
                       ": move vertices apart by set_point, or let the material do it with inside = \"ignore\" or " +
                       "self_collision = false",
                   s.object);
  }
}

}  // namespace feder
