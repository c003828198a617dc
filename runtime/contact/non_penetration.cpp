// No pair crosses in a substep (or in a part of one, see near_parts). Two convex features that lie on different sides
// of a plane at the start and at the end of a linear motion, have not met in between (x(t).n is linear). The plane's
// normal is that of the closest points at the start; the guard makes each vertex of the one side stay beyond each of
// the other along it by a share of the distance they had: first by pushing pairs apart as their masses say (momentum is
// kept), then, should that not settle, by moving zones of vertices as one, which always ends. Rows do the real work;
// the guard acts where they failed. Its corrections are counted in the residuals.
#include <algorithm>

#include "contact/impl.h"

namespace feder {
namespace {
constexpr int kPasses = 12;
constexpr Real kKept = Real(0.1);        // of the distance, in one substep
constexpr Real kKeptInZone = Real(0.2);  // the rest is for rounding
constexpr Real kSearched = Real(0.999);  // of the way that the search allows
}  // namespace

// Where a vertex is, beside where it was foreseen to be.
Vec3 SurfaceContact::Impl::astray(const NearSearch& near, std::uint32_t i) const {
  return current_position(i) - found_position[i] - near.since_found * found_velocity[i];
}

// Is every vertex where the search allowed it to be? The search is made anew for the next part when one has used most
// of that, or is about to.
bool SurfaceContact::Impl::near_path(NearSearch& near, Real part) {
  bool good = true;
  for (const std::uint32_t i : near.near_vertex) {
    FEDER_ASSERT(near_surface[i] < list.size() && !(stray[i] < 0));
    if (delta_position[i].w == 0) continue;
    const Real far = length(astray(near, i)), faster = length(Vec3(velocity[i].vec() - found_velocity[i]));
    const Real most = Real(0.75) * kStray * list[near_surface[i]].thickness;
    near.pairs_stale = near.pairs_stale || far > most || part * faster > most;
    good = good && !(far > stray[i]);
  }
  return good;
}

// Are the features apart along the normal? With `push`, moves those that are not.
bool SurfaceContact::Impl::separate(NearPair& p, Real h, bool push) {
  if (!p.live) return true;
  FEDER_ASSERT(is_direction(p.normal) && !(p.distance < 0));
  const std::uint32_t split = p.edges ? 2 : 1;
  const Real wanted = kKept * p.distance;
  Real along[4];
  for (int k = 0; k < 4; ++k) along[k] = dot(p.normal, current_position(p.v[k]) - current_position(p.v[0]));
  bool good = true;
  for (std::uint32_t i = 0; i < split; ++i)
    for (std::uint32_t j = split; j < 4; ++j) {
      const Real gap = along[i] - along[j];
      if (gap >= wanted) continue;
      if (p.edges && ((i == 1 && p.v[1] == p.v[0]) || (j == 3 && p.v[3] == p.v[2]))) continue;  // a point: once
      good = false;
      Row4 &a = delta_position[p.v[i]], &b = delta_position[p.v[j]];
      const Real w = a.w + b.w;
      if (!push || !(w > 0)) continue;
      const Real share = Real(1.01) * (wanted - gap) / w;
      a.add((a.w * share) * p.normal), b.add((-b.w * share) * p.normal);
      velocity[p.v[i]].add((a.w * share / h) * p.normal), velocity[p.v[j]].add((-b.w * share / h) * p.normal);
      along[i] += a.w * share, along[j] -= b.w * share;
      ++projected;
    }
  return good;
}

// The first vertex of the group that `i` is held with.
std::uint32_t SurfaceContact::Impl::zone_root(std::uint32_t i) {
  FEDER_ASSERT(zone_of[i] != kNone);
  while (zone_of[i] != i) {
    FEDER_ASSERT(zone_of[i] < i);  // the first of a group is its root
    i = zone_of[i] = zone_of[zone_of[i]];
  }
  return i;
}

// Zones of impact (Provot, "Collision and self-collision handling in cloth model dedicated to design garments", 1997):
// the vertices of pairs that are not apart go on from where the part began with their common velocity, and with as much
// of their motion beside it as leaves all of them apart; the same share for all, so that momentum is kept. Without that
// share they are as far apart as they were, so growing the zones until no pair is left ends. A zone with a held vertex
// in it has no common velocity.
void SurfaceContact::Impl::project_out(NearSearch& near, Real part) {
  zone_of.resize(delta_position.size()), wished.resize(delta_position.size());
  for (const std::uint32_t i : near.near_vertex) zone_of[i] = kNone, wished[i] = delta_position[i];
  const auto join = [&](std::uint32_t& root, std::uint32_t i) {
    const bool fresh = zone_of[i] == kNone;
    if (fresh) zone_of[i] = i, ++projected;
    const std::uint32_t other = zone_root(i);
    const bool merged = root != kNone && root != other;
    if (merged) zone_of[std::max(root, other)] = std::min(root, other);
    root = std::min(root, other);
    return fresh || merged;
  };
  for (const std::uint32_t i : near.near_vertex) {
    std::uint32_t root = kNone;
    if (delta_position[i].w != 0 && length(astray(near, i)) > stray[i]) join(root, i);
  }
  for (bool grown = true; grown;) {
    move_zones(near, part);
    grown = false;
    for (NearPair& p : near.pairs) {
      if (separate(p, 1, false)) continue;
      std::uint32_t root = kNone;
      for (const std::uint32_t i : p.v) grown = join(root, i) || grown;
    }
  }
  for (const std::uint32_t i : near.near_vertex) {
    if (zone_of[i] == kNone || delta_position[i].w == 0) continue;
    const Zone& z = zones[zone_root(i)];
    velocity[i].set(z.velocity + z.freedom * (velocity[i].vec() - z.velocity));
  }
}

// The largest s in [0, 1] with |a + s b| <= r.
Real share_within(const Vec3& a, const Vec3& b, Real r) {
  const Real bb = dot(b, b), ab = dot(a, b), spare = r * r - dot(a, a);
  if (spare >= bb + 2 * ab) return 1;
  return spare > 0 && bb > 0 ? (std::sqrt(ab * ab + bb * spare) - ab) / bb : Real(0);
}

// Velocities of the zones, and their vertices moved by them, as far as the search allows.
void SurfaceContact::Impl::move_zones(const NearSearch& near, Real part) {
  FEDER_ASSERT(wished.size() == delta_position.size() && projection_start.size() == delta_position.size());
  zones.resize(delta_position.size());
  for (const std::uint32_t i : near.near_vertex) zones[i] = Zone();
  const auto each = [&](auto&& f) {
    for (const std::uint32_t i : near.near_vertex)
      if (zone_of[i] != kNone) f(i, zones[zone_root(i)]);
  };
  each([&](std::uint32_t i, Zone& z) {
    z.held = z.held || delta_position[i].w == 0;
    z.velocity += mass[i] * velocity[i].vec(), z.mass += mass[i];
  });
  for (const std::uint32_t i : near.near_vertex)
    if (zone_of[i] == i) zones[i].velocity = zones[i].held ? Vec3(0, 0, 0) : Vec3(zones[i].velocity / zones[i].mass);
  each([&](std::uint32_t i, Zone& z) {
    if (delta_position[i].w == 0) return;
    delta_position[i].set(projection_start[i].vec() + part * near.drift);
    if (!z.held)
      z.share =
          std::min(z.share, share_within(astray(near, i), part * (z.velocity - near.drift), kSearched * stray[i]));
  });
  each([&](std::uint32_t i, Zone& z) {
    if (delta_position[i].w == 0) return;
    if (!z.held) delta_position[i].add((part * z.share) * (z.velocity - near.drift));
    z.freedom = std::min(
        z.freedom, share_within(astray(near, i), wished[i].vec() - delta_position[i].vec(), kSearched * stray[i]));
  });
  for (const NearPair& p : near.pairs)
    if (p.live && zone_of[p.v[0]] != kNone) {
      Zone& z = zones[zone_root(p.v[0])];
      z.freedom = std::min(z.freedom, freedom(p));
    }
  each([&](std::uint32_t i, Zone& z) {
    if (delta_position[i].w != 0) delta_position[i].add(z.freedom * (wished[i].vec() - delta_position[i].vec()));
  });
}

// Which share of the way from `delta_position` to `wished` keeps the pair apart, if it is within one zone.
Real SurfaceContact::Impl::freedom(const NearPair& p) {
  const std::uint32_t root = zone_root(p.v[0]), split = p.edges ? 2 : 1;
  Real now[4], wish[4], share = 1;
  for (int k = 0; k < 4; ++k) {
    if (zone_of[p.v[k]] == kNone || zone_root(p.v[k]) != root) return 1;
    now[k] = dot(p.normal, current_position(p.v[k]) - current_position(p.v[0]));
    wish[k] = now[k] + dot(p.normal, wished[p.v[k]].vec() - delta_position[p.v[k]].vec());
  }
  const Real kept = kKeptInZone * p.distance;
  for (std::uint32_t i = 0; i < split; ++i)
    for (std::uint32_t j = split; j < 4; ++j) {
      const Real gap = now[i] - now[j], then = wish[i] - wish[j];
      if (then < kept) share = std::min(share, gap > kept ? (gap - kept) / (gap - then) : Real(0));
    }
  FEDER_ASSERT(!(share < 0 || share > 1));
  return share;
}

// Searches this part anew, from where it began, along the ways that vertices really went: some left those that the
// search ahead foresaw, or are to be held back, which asks for more pairs.
void SurfaceContact::Impl::widen(const SurfaceGroup& g, NearSearch& near, Real part) {
  FEDER_ASSERT(swapped.empty());
  wished.resize(delta_position.size());
  for (const std::uint32_t i : near.near_vertex) wished[i] = delta_position[i];
  for (const std::uint32_t i : near.near_vertex) {
    if (delta_position[i].w == 0) continue;
    swapped.push_back(velocity[i]);
    velocity[i].set((delta_position[i].vec() - projection_start[i].vec()) / part);
    delta_position[i].set(projection_start[i].vec());
  }
  find_pairs(g, near, part, true);
  for (NearPair& p : near.pairs) {
    Real weight[4];
    measure(p, weight);
    p.live = 1;
  }
  std::size_t n = 0;
  for (const std::uint32_t i : near.near_vertex)
    if (delta_position[i].w != 0) delta_position[i] = wished[i], velocity[i] = swapped[n++];
  FEDER_ASSERT(n == swapped.size());  // the search lists the same vertices again
  swapped.clear();
  near.since_found = part;
  near.pairs_stale = true;
  ++widened;
}

void SurfaceContact::Impl::guard(const SurfaceGroup& g, NearSearch& near, Real part) {
  FEDER_ASSERT(part > 0);
  near.since_found += part;
  bool wide = !near_path(near, part);
  if (wide) widen(g, near, part);
  bool good = false;
  for (int pass = 0; pass < kPasses && !good; ++pass) {
    good = true;
    for (NearPair& p : near.pairs) good = separate(p, part, true) && good;
  }
  if (good && near_path(near, part)) return;
  if (!wide) widen(g, near, part);
  project_out(near, part);
}

}  // namespace feder
