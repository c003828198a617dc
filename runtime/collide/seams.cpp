// Seams between flush colliders: a ball that rolls over tiles meets the edge of the next tile, a box that is a hair
// sunk into one meets the side of the next, and both would be braked by a surface that is flat. A point on a collider B
// with the normal m is a ghost when the union of B and another collider C that the same body touches cannot push along
// m: what lies off the point along m is over a face of C, that face passes through the point (kFlush), and B does not
// rise above it. Then C holds the body, and the point is left out. Within one mesh the pair test does the same with the
// normals of neighbouring triangles (narrow/convex_mesh.cpp).
// Geometry only, so the order of colliders does not matter; recycled contacts keep what was found. Weak spot: B and C
// must not move against each other, and C must touch; three faces that meet in a point are looked at two by two.
#include <algorithm>

#include "base/jobs.h"
#include "collide/impl.h"

namespace feder {
namespace {

constexpr Real kFlush = Real(1) / 20;       // of the margin: steps and sinking that count as flush
constexpr Real kOff = Real(1) / 2;          // of the margin: how far off the point the surface is looked at
constexpr Real kDeep = Real(1) / 8;         // of the margin: what overlaps by more is no grazing of a seam
constexpr Real kParallel = 1 - Real(5e-6);  // cosine: normals that are the same
// cosine, likewise where B is not reached yet and C is closer, so that no two give each other up
constexpr Real kAhead = 1 - Real(5e-7);
constexpr Real kFaceCosine = 1 - Real(1e-6);

struct Touch {
  Vec3 on_b;    // the point, on B
  Vec3 normal;  // from B to the body
  Real margin;
  Real parallel;  // cosine
};

Real distance_to(const Colliders& c, std::uint32_t k, const Vec3& p, Real limit, Vec3& normal) {
  const Pose& pose = c.pose[k];
  const Real distance = c.shape[k]->distance(to_local(pose, p), limit, normal);
  normal = rotate(pose.rotation, normal);
  return distance;
}

bool is_ghost(const Colliders& c, std::uint32_t b, std::uint32_t other, const Touch& t) {
  const Real off = kOff * t.margin, flush = kFlush * t.margin, limit = 2 * t.margin;
  Vec3 n, half;
  const Real far = distance_to(c, other, t.on_b + off * t.normal, limit, n);
  if (!(far < limit)) return false;
  const Real along = dot(t.normal, n);
  if (!(along < t.parallel) || !(along > -Real(0.1))) return false;
  // over a face, and that passes through the point
  const Real height = far - off * along;
  if (!(height < flush && height > -t.margin)) return false;
  distance_to(c, other, t.on_b + (off / 2) * t.normal, limit, half);
  if (!(dot(n, half) > kFaceCosine)) return false;
  // which B does not rise above
  Vec3 unused;
  const Vec3 above = t.on_b + (2 * flush - height) * n - flush * t.normal;
  return distance_to(c, b, above, limit, unused) > 0;
}

}  // namespace

// The moving and the resting side of a contact.
static std::uint32_t mover_of(const Colliders& c, const ContactEntry& e) {
  return c.motion[e.a] == ColliderMotion::dynamic ? e.a : e.b;
}

static bool move_together(const Colliders& c, std::uint32_t x, std::uint32_t y) {
  if (c.motion[x] == ColliderMotion::fixed && c.motion[y] == ColliderMotion::fixed) return true;
  return c.object[x] == c.object[y] || (!c.awake[x] && !c.awake[y]);
}

// Of the gaps at its points.
static Real closest_of(const Contact& contact) {
  Real closest = kInfinity;
  for (int k = 0; k < contact.point_count; ++k) closest = std::min(closest, contact.points[k].separation);
  return closest;
}

// Bit per point of the entry that is a ghost beside some other contact of the body, all in seam_entries.
std::uint32_t Collide::Impl::ghosts_of(const ContactEntry& e, std::span<const SeamEntry> group) const {
  const Colliders& c = *colliders;
  const Contact& contact = contacts->slots[e.slot];
  const std::uint32_t body = mover_of(c, e), b = body == e.a ? e.b : e.a;
  if (!c.shape[b]->convex()) return 0;  // its own seams are the pair test's
  std::uint32_t ghosts = 0;
  for (const SeamEntry& s : group) {
    const ContactEntry& near = entries[s.entry];
    const std::uint32_t other = body == near.a ? near.b : near.a;
    const Vec3& m = contacts->slots[near.slot].normal;
    const Vec3 its = body == near.a ? Vec3(-m) : m;
    const Vec3 normal = body == e.a ? Vec3(-contact.normal) : contact.normal;
    const Real along = dot(its, normal);
    if (other == b || along > kAhead || !move_together(c, b, other)) continue;
    const Real closest = closest_of(contacts->slots[near.slot]);
    for (int k = 0; k < contact.point_count; ++k) {
      const ContactPoint& p = contact.points[k];
      if (p.separation < -kDeep * memory[e.pair].margin) continue;
      const Real parallel = p.separation > 0 && p.separation > closest ? kAhead : kParallel;
      if (along > parallel) continue;
      const Vec3 at = c.center[e.a] + p.arm_a - normal * (p.separation / 2);
      if (is_ghost(c, b, other, {at, normal, memory[e.pair].margin, parallel})) ghosts |= 1u << k;
    }
  }
  return ghosts;
}

void Collide::Impl::leave_out(ContactEntry& e, std::uint32_t ghosts, Real dt) {
  Contact& contact = contacts->slots[e.slot];
  ContactBase& base = bases[e.slot];
  int kept = 0;
  for (int k = 0; k < contact.point_count; ++k) {
    if (ghosts >> k & 1u) continue;
    contact.points[kept] = contact.points[k], base.separation[kept] = base.separation[k];
    ++kept;
  }
  for (int k = kept; k < contact.point_count; ++k) contact.points[k] = {}, base.separation[k] = 0;
  contact.point_count = static_cast<std::uint8_t>(kept);
  check_contact(e, contact, memory[e.pair].margin, dt);
  if (!(e.bits & kNear)) e.bits &= static_cast<std::uint16_t>(~kArrived);
}

// After the narrow tests of all pairs.
void Collide::Impl::leave_out_ghosts(StepContext& c) {
  seam_entries.clear();
  constexpr std::uint32_t kWanted = kAgainstScenery | kTouching | kTested;
  for (std::uint32_t i = 0; i < entries.size(); ++i)
    if ((entries[i].bits & kWanted) == kWanted) seam_entries.push_back({mover_of(*colliders, entries[i]), i, 0});
  if (seam_entries.size() < 2) return;
  std::sort(seam_entries.begin(), seam_entries.end(), [](const SeamEntry& x, const SeamEntry& y) {
    return std::tie(x.body, x.entry) < std::tie(y.body, y.entry);
  });
  const std::uint32_t count = static_cast<std::uint32_t>(seam_entries.size());
  const auto group_of = [&](std::uint32_t i) {
    std::uint32_t first = i, last = i + 1;
    while (first > 0 && seam_entries[first - 1].body == seam_entries[i].body) --first;
    while (last < count && seam_entries[last].body == seam_entries[i].body) ++last;
    return std::span<const SeamEntry>(&seam_entries[first], last - first);
  };
  constexpr JobGrain kGrain{64, 20'000};  // contacts
  c.jobs->for_blocks(count, kGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t i = first; i < last; ++i) {
      const ContactEntry& e = entries[seam_entries[i].entry];
      const std::span<const SeamEntry> group = group_of(i);
      if (group.size() > 1 && contacts->slots[e.slot].fresh) seam_entries[i].ghosts = ghosts_of(e, group);
    }
  });
  for (const SeamEntry& s : seam_entries)
    if (s.ghosts) leave_out(entries[s.entry], s.ghosts, c.dt);
}

}  // namespace feder
