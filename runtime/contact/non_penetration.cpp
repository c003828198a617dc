// Non-penetration projection: no pair of features crosses in a substep, or in a part of one (loop.cpp). It replaces
// continuous collision detection by separating planes: two convex features on different sides of a plane at the start
// and at the end of a linear motion have not met in between, because x(t).n is linear in t. The plane's normal is that
// of the closest points at the start; each vertex of one side has to stay beyond each of the other along it by a share
// of the distance they had. First pairs are pushed apart by their masses, which keeps momentum; should that not settle
// in kPasses sweeps, impact zones (Provot 1997) move points as one, which always ends.
// Contact rows do the real work, the projection acts where they failed; its corrections are counted in the residuals.
// Kept between calls: only the zones' work memory. Weak spot: a zone loses the relative motion that its pairs cannot
// keep.
#include <algorithm>
#include <atomic>

#include "contact/impl.h"

namespace feder {
namespace {
constexpr int kPasses = 12;              // sweeps over all pairs, before impact zones
constexpr Real kKept = Real(0.1);        // of the distance of a pair, at least, in one part
constexpr Real kKeptInZone = Real(0.2);  // likewise in an impact zone; the difference is for rounding
constexpr JobGrain kVertexGrain{2048, 8'000};
constexpr Real kSearched = Real(0.999);  // of the deviation that the search allows
}  // namespace

// From the extrapolated position to the present one.
Vec3 SurfaceContact::Impl::deviation(const NearSearch& near, std::uint32_t i) const {
  return current_position(i) - search_position[i] - near.since_found * search_velocity[i];
}

// Is every vertex within the deviation that the search allowed for? Candidates become stale, so that the next part
// searches anew, when one has used most of it or is about to.
bool SurfaceContact::Impl::within_search(NearSearch& near, Real part) {
  if (near.kept) {
    bool good = true;
    for (const std::uint32_t i : near.near_vertex)
      good = good && (delta_position[i].w == 0 || !(length(deviation(near, i)) > allowed[i]));
    return good;
  }
  std::atomic<bool> stale{false}, beyond{false};  // of all blocks: the order does not matter
  const auto check = [&](std::uint32_t first, std::uint32_t last, int) {
    bool used = false, more = false;
    for (std::uint32_t k = first; k < last; ++k) {
      const std::uint32_t i = near.near_vertex[k];
      FEDER_ASSERT(near_surface[i] < list.size() && !(max_deviation[i] < 0));
      if (delta_position[i].w == 0) continue;
      const Vec3 off = current_position(i) - search_row[i].vec() - near.since_found * search_way[i].vec(),
                 faster = part * (velocity[i].vec() - search_way[i].vec());
      const Real far = dot(off, off), most = Real(0.75) * bearable[near_surface[i]], most2 = most * most;
      used = used || far > most2 || dot(faster, faster) > most2;
      more = more || std::sqrt(far) > max_deviation[i];
    }
    if (used) stale.store(true, std::memory_order_relaxed);
    if (more) beyond.store(true, std::memory_order_relaxed);
  };
  jobs->for_blocks(static_cast<std::uint32_t>(near.near_vertex.size()), kVertexGrain, check);
  near.pairs_stale = near.pairs_stale || stale.load();
  return !beyond.load();
}

// Is each vertex of the first feature beyond each of the second along the normal? With `push`, separates those that are
// not, by a correction of positions and of velocities.
bool SurfaceContact::Impl::separate(NearPair& p, Real h, bool push) {
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
      if (p.edges && ((i == 1 && p.v[1] == p.v[0]) || (j == 3 && p.v[3] == p.v[2])))
        continue;  // an edge without length: its point once
      good = false;
      Row4 &a = delta_position[p.v[i]], &b = delta_position[p.v[j]];
      const Real w = a.w + b.w;
      if (!push || !(w > 0)) continue;
      const Real share = Real(1.01) * (wanted - gap) / w;
      if (p.surface_pair == kNone) {
        const Vec3 from = (current_position(p.v[i]) - current_position(p.v[j])) -
                          h * (velocity[p.v[i]].vec() - velocity[p.v[j]].vec());
        gained_momentum[near_surface[p.v[0]]] += (share / h) * cross(from, p.normal);
      }
      a.add((a.w * share) * p.normal), b.add((-b.w * share) * p.normal);
      velocity[p.v[i]].add((a.w * share / h) * p.normal), velocity[p.v[j]].add((-b.w * share / h) * p.normal);
      along[i] += a.w * share, along[j] -= b.w * share;
      ++projected;
    }
  return good;
}

// Of the points of a search, about where the first of them was in the beginning.
Vec3 SurfaceContact::Impl::angular_momentum(const NearSearch& near) const {
  Vec3 sum = Vec3::Zero();
  for (const std::uint32_t i : near.near_vertex)
    sum += mass[i] * cross(current_position(i) - position[near.near_vertex[0]], velocity[i].vec());
  return sum;
}

// Root of the zone of `i`: its lowest vertex; with path halving.
std::uint32_t SurfaceContact::Impl::zone_root(std::uint32_t i) {
  FEDER_ASSERT(zone_of[i] != kNone);
  while (zone_of[i] != i) {
    FEDER_ASSERT(zone_of[i] < i);  // the lowest of a zone is its root
    i = zone_of[i] = zone_of[zone_of[i]];
  }
  return i;
}

// Impact zones (Provot, "Collision and self-collision handling in cloth model dedicated to design garments", 1997): the
// vertices of pairs that are not apart move on from the start of the part with their common velocity, plus a share of
// their motion relative to it that leaves all of them apart; the share is the same for all, so momentum is kept. With a
// share of zero they are as far apart as they were, so growing the zones until no pair is left terminates. A zone with
// a pinned vertex has zero velocity.
void SurfaceContact::Impl::project_out(const SurfaceGroup& g, NearSearch& near, Real part) {
  zone_of.resize(delta_position.size()), saved_displacement.resize(delta_position.size());
  const std::uint32_t alone = g.members.size() == 1 ? g.members[0] : kNone;
  if (alone != kNone) gained_momentum[alone] -= angular_momentum(near);
  for (const std::uint32_t i : near.near_vertex) zone_of[i] = kNone, saved_displacement[i] = delta_position[i];
  const auto join = [&](std::uint32_t& root, std::uint32_t i) {
    const bool fresh = zone_of[i] == kNone;
    if (fresh) zone_of[i] = i, ++projected;
    const std::uint32_t other = zone_root(i);
    const bool merged = root != kNone && root != other;
    if (merged) zone_of[std::max(root, other)] = std::min(root, other);
    root = std::min(root, other);
    return fresh || merged;
  };
  // vertices beyond their allowed deviation are zones of their own: the candidates do not cover them
  for (const std::uint32_t i : near.near_vertex) {
    std::uint32_t root = kNone;
    if (delta_position[i].w != 0 && length(deviation(near, i)) > max_deviation[i]) join(root, i);
  }
  // join what is not apart, until no zone grows
  for (bool grown = true; grown;) {
    move_zones(near, part);
    grown = false;
    for (NearPair& p : near.pairs) {
      if (separate(p, 1, false)) continue;
      std::uint32_t root = kNone;
      for (const std::uint32_t i : p.v) grown = join(root, i) || grown;
    }
  }
  // velocities keep the same share of their relative part
  for (const std::uint32_t i : near.near_vertex) {
    if (zone_of[i] == kNone || delta_position[i].w == 0) continue;
    const Zone& z = zones[zone_root(i)];
    velocity[i].set(z.velocity + z.freedom * (velocity[i].vec() - z.velocity));
  }
  if (alone != kNone) gained_momentum[alone] += angular_momentum(near);
}

// The largest s in [0, 1] with |a + s b| <= r.
Real share_within(const Vec3& a, const Vec3& b, Real r) {
  const Real bb = dot(b, b), ab = dot(a, b), spare = r * r - dot(a, a);
  if (spare >= bb + 2 * ab) return 1;
  return spare > 0 && bb > 0 ? (std::sqrt(ab * ab + bb * spare) - ab) / bb : Real(0);
}

// Velocities of the zones, and displacements of their vertices by them, as far as the search allows.
void SurfaceContact::Impl::move_zones(const NearSearch& near, Real part) {
  FEDER_ASSERT(saved_displacement.size() == delta_position.size() && projection_start.size() == delta_position.size());
  zones.resize(delta_position.size());
  for (const std::uint32_t i : near.near_vertex) zones[i] = Zone();
  const auto each = [&](auto&& f) {
    for (const std::uint32_t i : near.near_vertex)
      if (zone_of[i] != kNone) f(i, zones[zone_root(i)]);
  };
  // common velocity, by mass
  each([&](std::uint32_t i, Zone& z) {
    z.held = z.held || delta_position[i].w == 0;
    z.velocity += mass[i] * velocity[i].vec(), z.mass += mass[i];
  });
  for (const std::uint32_t i : near.near_vertex)
    if (zone_of[i] == i) zones[i].velocity = zones[i].held ? Vec3(0, 0, 0) : Vec3(zones[i].velocity / zones[i].mass);
  // from the start of the part along the drift; the share of the common motion within the allowed deviation
  each([&](std::uint32_t i, Zone& z) {
    if (delta_position[i].w == 0) return;
    delta_position[i].set(projection_start[i].vec() + part * near.drift);
    if (!z.held)
      z.share = std::min(
          z.share, share_within(deviation(near, i), part * (z.velocity - near.drift), kSearched * max_deviation[i]));
  });
  // the share of the relative motion within the deviation, and within what keeps each pair apart
  each([&](std::uint32_t i, Zone& z) {
    if (delta_position[i].w == 0) return;
    if (!z.held) delta_position[i].add((part * z.share) * (z.velocity - near.drift));
    z.freedom =
        std::min(z.freedom, share_within(deviation(near, i), saved_displacement[i].vec() - delta_position[i].vec(),
                                         kSearched * max_deviation[i]));
  });
  for (const NearPair& p : near.pairs)
    if (zone_of[p.v[0]] != kNone) {
      Zone& z = zones[zone_root(p.v[0])];
      z.freedom = std::min(z.freedom, freedom(p));
    }
  each([&](std::uint32_t i, Zone& z) {
    if (delta_position[i].w != 0)
      delta_position[i].add(z.freedom * (saved_displacement[i].vec() - delta_position[i].vec()));
  });
}

// Share of the motion from `delta_position` to `saved_displacement` that keeps a pair apart that lies in one zone;
// else 1.
Real SurfaceContact::Impl::freedom(const NearPair& p) {
  const std::uint32_t root = zone_root(p.v[0]), split = p.edges ? 2 : 1;
  Real now[4], saved[4], share = 1;
  for (int k = 0; k < 4; ++k) {
    if (zone_of[p.v[k]] == kNone || zone_root(p.v[k]) != root) return 1;
    now[k] = dot(p.normal, current_position(p.v[k]) - current_position(p.v[0]));
    saved[k] = now[k] + dot(p.normal, saved_displacement[p.v[k]].vec() - delta_position[p.v[k]].vec());
  }
  const Real kept = kKeptInZone * p.distance;
  for (std::uint32_t i = 0; i < split; ++i)
    for (std::uint32_t j = split; j < 4; ++j) {
      const Real gap = now[i] - now[j], then = saved[i] - saved[j];
      if (then < kept) share = std::min(share, gap > kept ? (gap - kept) / (gap - then) : Real(0));
    }
  FEDER_ASSERT(!(share < 0 || share > 1));
  return share;
}

// Searches this part again from its start, along the true displacements: some vertices deviated from the extrapolated
// motion by more than the search allowed, or impact zones are to hold them back, which takes more candidates (`held`).
void SurfaceContact::Impl::search_again(const SurfaceGroup& g, NearSearch& near, Real part, bool held) {
  FEDER_ASSERT(saved_velocity.empty());
  saved_displacement.resize(delta_position.size());
  for (const std::uint32_t i : near.near_vertex) saved_displacement[i] = delta_position[i];
  // back to the start of the part, with the velocities of the true displacements
  for (const std::uint32_t i : near.near_vertex) {
    if (delta_position[i].w == 0) continue;
    saved_velocity.push_back(velocity[i]);
    velocity[i].set((delta_position[i].vec() - projection_start[i].vec()) / part);
    delta_position[i].set(projection_start[i].vec());
  }
  find_pairs(g, near, part, held);
  list_pairs_of(near, true, part);
  std::size_t n = 0;
  for (const std::uint32_t i : near.near_vertex)
    if (delta_position[i].w != 0) delta_position[i] = saved_displacement[i], velocity[i] = saved_velocity[n++];
  FEDER_ASSERT(n == saved_velocity.size());  // the search lists the same vertices again
  saved_velocity.clear();
  near.since_found = part;
  near.pairs_stale = true;
  ++widened;
}

void SurfaceContact::Impl::project_pairs(const SurfaceGroup& g, NearSearch& near, Real part) {
  FEDER_ASSERT(part > 0);
  near.since_found += part;
  if (!within_search(near, part)) search_again(g, near, part, false);
  bool good = false;
  for (int pass = 0; pass < kPasses && !good; ++pass) {
    good = true;
    for (NearPair& p : near.pairs) good = separate(p, part, true) && good;
  }
  if (good && within_search(near, part)) return;
  search_again(g, near, part, true);
  project_out(g, near, part);
}

}  // namespace feder
