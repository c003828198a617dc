// A search for contact within one sheet that holds over steps, as a neighbour list with a skin does (Verlet 1967): its
// points are taken to rest where it finds them, each may go a distance of its own from there, its skin, and the
// candidates are all pairs that could then come within their thickness. At the start of a part each point is allowed
// what it has gone, what its velocity takes it on in twice the part, and what being pushed may add; while that is
// within every skin the candidates hold, and a pair whose points are not allowed to come near is not even measured.
// Skins follow the velocities: a point that trembles among others at rest gets a wide one and makes no searches.
// Kept between steps, and in snapshots: where points were and their skins, from which the candidates follow. Used where
// a sheet with flat parts lies folded and most of it is slow; else candidates are those of one step (near.cpp). Weak
// spot: all of the sheet is searched again where one skin is used up.
#include <algorithm>
#include <cmath>

#include "contact/impl.h"

namespace feder {
namespace {
constexpr Real kSlow = Real(0.1);     // thicknesses in twice a part, of the mean point
constexpr Real kParts = 6;            // skin in parts of the present motion
constexpr Real kLeastSkin = 2;        // of the deviation that any search allows
constexpr Real kWiden = Real(1.5);    // of a skin that was used up
constexpr Real kNarrow = Real(0.95);  // of the others
constexpr Real kWidest = 4;           // thicknesses
}  // namespace

KeptOf SurfaceContact::Impl::kept_of(std::uint32_t group) const {
  const SurfaceGroup& g = *surfaces.groups[group];
  const std::uint32_t n = g.members[0];
  const Surface& s = list[n];
  return {s.object, s.version, group, n, s.first, s.count, s.thickness};
}

// Drops what is kept of other points than those of the step, and takes over what a snapshot holds.
void SurfaceContact::Impl::check_kept() {
  for (std::uint32_t k = 0; k < searches.size(); ++k) {
    NearSearch& near = *searches[k];
    if (k >= surfaces.group_count || surfaces.groups[k]->members.size() != 1) {
      near.drop();
      continue;
    }
    const KeptOf now = kept_of(k);
    if (near.kept && !(near.kept_of == now)) near.drop();
    for (const KeptImage& image : kept_images) {
      if (!(image.of == now) || image.rest.size() != now.count) continue;
      near.drop();
      near.kept = true, near.kept_of = now, near.rest = image.rest;
    }
    const Surface& s = list[now.surface];
    if (near.kept && (!s.self || paired(now.surface) || !link_marks.empty())) near.drop();
  }
  kept_images.clear();
}

bool SurfaceContact::Impl::slow(const SurfaceGroup& g, const NearSearch& near, Real part) const {
  const std::uint32_t n = g.members[0];
  const Surface& s = list[n];
  if (g.members.size() != 1 || !s.active || !s.self || paired(n) || any_tangled || !link_marks.empty()) return false;
  if (near.near_vertex.size() != s.count || !flat_parts[n] || sealed[n]) return false;
  Real sum = 0;
  for (const std::uint32_t i : near.near_vertex) sum += length(velocity[i].vec());
  return 2 * part * sum < kSlow * s.thickness * static_cast<Real>(s.count);
}

// Where points are, with their skins; `again`: they had some.
void SurfaceContact::Impl::choose_rest(const SurfaceGroup& g, NearSearch& near, bool again, Real part) {
  const Surface& s = list[g.members[0]];
  const Real least = kLeastSkin * kMaxDeviation * s.thickness, widest = kWidest * s.thickness;
  near.rest.resize(s.count);
  for (std::uint32_t k = 0; k < s.count; ++k) {
    const std::uint32_t i = s.first + k;
    Row4& rest = near.rest[k];
    Real skin = least + kParts * part * length(velocity[i].vec());
    if (again) skin = std::max(skin, std::min(rest.w * (allowed[i] > rest.w ? kWiden : kNarrow), widest));
    rest.set(current_position(i));
    rest.w = delta_position[i].w == 0 ? Real(0) : skin;
  }
}

// Sets what each point is allowed to deviate in this part; false when that is more than its skin.
bool SurfaceContact::Impl::kept_holds(NearSearch& near, Real part) {
  bool good = true;
  for (const std::uint32_t i : near.near_vertex) {
    const Real far = length(Vec3(current_position(i) - search_position[i]));
    const Real more = 2 * part * length(velocity[i].vec()) + bearable[near_surface[i]];
    allowed[i] = delta_position[i].w == 0 ? far : far + more;
    good = good && !(allowed[i] > max_deviation[i]);
  }
  return good;
}

// Whether a candidate may come within its thickness while its points stay in what they are allowed.
bool SurfaceContact::Impl::in_reach(const NearCandidate& p) const {
  const Real a = allowed[p.v[0]], b = allowed[p.v[1]], c = allowed[p.v[2]], d = allowed[p.v[3]];
  return !(p.spare > (p.edges ? std::max(a, b) + std::max(c, d) : a + std::max({b, c, d})));
}

// Candidates for the coming part, and where they are kept what its points are allowed in it.
void SurfaceContact::Impl::update_pairs(const SurfaceGroup& g, NearSearch& near, Real time, Real part) {
  if (near.kept && any_tangled) near.drop();  // its candidates leave out what crosses now
  if (near.kept && !near.listed) {            // from a snapshot: not a search of this step
    list_features(g, near, time, false), collect_pairs(g, near, time);
    --search_total;
  }
  if (near.kept ? kept_holds(near, part) : !near.pairs_stale) return;
  const bool again = near.kept && !sealed[g.members[0]];
  near.kept = false;
  list_features(g, near, time, false);
  if (slow(g, near, part)) {
    choose_rest(g, near, again, part);
    near.kept = true, near.kept_of = kept_of(list[g.members[0]].loop);
    list_features(g, near, time, false);
  }
  collect_pairs(g, near, time);
  const bool holds = !near.kept || kept_holds(near, part);
  FEDER_ASSERT(holds), static_cast<void>(holds);
}

void SurfaceContact::Impl::save_kept(Writer& w) const {
  std::uint64_t count = 0;
  for (const auto& near : searches) count += near->kept;
  w.add(count);
  for (const auto& near : searches)
    if (near->kept) w.add(near->kept_of), w.list(near->rest);
}

void SurfaceContact::Impl::load_kept(Reader& r) {
  for (const auto& near : searches) near->drop();
  kept_images.clear();
  for (std::uint64_t left = r.get<std::uint64_t>(); left > 0; --left) {
    KeptImage& image = kept_images.emplace_back(arena);
    r.get(image.of), r.list(image.rest);
  }
}

}  // namespace feder
