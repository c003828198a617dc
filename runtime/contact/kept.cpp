// A search for contact within one sheet that holds over steps, as a neighbour list with a skin does (Verlet 1967): its
// points are taken to rest where it finds them, each may go a distance of its own from there, its skin, and the
// candidates are all pairs that could then come within their thickness. At the start of a part each point is allowed
// what it has gone, what its velocity takes it on in twice the part, and what being pushed may add; while that is
// within every skin the candidates hold, and a pair whose points are not allowed to come near is not even measured.
// Skins follow the velocities: a point that trembles among others at rest gets a wide one and makes no searches.
// Candidates are kept by pairs of blocks (flat_parts.h): where points use up their skins, or have got far wider ones
// than they need, those are renewed with the blocks they belong to, and the pairs of all other blocks stay.
// Kept between steps, and in snapshots: where points were and their skins, from which the candidates follow, searched
// in part or anew. Used where a sheet with flat parts lies folded and most of it is slow; else candidates are those of
// one step (near.cpp). Weak spot: certificates and bounds of all blocks are made for each search in part.
#include <algorithm>
#include <cmath>

#include "contact/impl.h"

namespace feder {
namespace {
constexpr Real kSlow = Real(0.1);       // thicknesses in twice a part, of the mean point
constexpr Real kParts = 6;              // skin in parts of the present motion
constexpr Real kLeastSkin = 2;          // of the deviation that any search allows
constexpr Real kWiden = Real(1.5);      // of a skin that was used up
constexpr Real kWidest = 4;             // thicknesses
constexpr Real kLoose = 2;              // times what is needed: a skin that makes too many candidates
constexpr std::size_t kSomeLoose = 16;  // one in so many points
constexpr Real kUsed = Real(0.75);      // of a skin, beyond which it is renewed with others
constexpr Real kFolded = 1;             // candidates by points, from which a search is kept
constexpr Real kUnfolded = Real(0.1);   // rows by points, below which it is so no longer
constexpr Real kMany = Real(0.6);       // of the blocks, beyond which all are searched
constexpr Real kMeanSkin = 8;           // thicknesses: more than that no search of slow points keeps
}  // namespace

// Whether what a snapshot holds, whoever wrote it, may stand for a search of the points as they are: places near them
// and skins that leave few candidates. What any such places and skins lead to is right.
bool SurfaceContact::Impl::sound(const KeptImage& image, const KeptOf& now) const {
  if (!(image.of == now) || image.rest.size() != now.count) return false;
  const Real thickness = list[now.surface].thickness;
  Real sum = 0;
  for (std::uint32_t k = 0; k < now.count; ++k) {
    const Row4& rest = image.rest[k];
    if (!(rest.w >= 0) || !(length(Vec3(position[now.first + k] - rest.vec())) <= rest.w + kWidest * thickness))
      return false;
    sum += rest.w;
  }
  return sum <= kMeanSkin * thickness * static_cast<Real>(now.count);
}

KeptOf SurfaceContact::Impl::kept_of(std::uint32_t group) const {
  const SurfaceGroup& g = *surfaces.groups[group];
  const std::uint32_t n = g.members[0];
  const Surface& s = list[n];
  return {s.object, s.version, group, n, s.first, s.count, double(s.thickness)};
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
      if (!sound(image, now)) continue;
      near.drop();
      near.kept = true, near.kept_of = now, near.rest = image.rest, near.rows = image.rows;
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
  if (static_cast<Real>(near.candidates.size()) < kFolded * static_cast<Real>(s.count)) return false;
  Real sum = 0;
  for (const std::uint32_t i : near.near_vertex) sum += length(velocity[i].vec());
  return 2 * part * sum < kSlow * s.thickness * static_cast<Real>(s.count);
}

// Skin of a point that had none.
Real SurfaceContact::Impl::fresh_skin(const Surface& s, std::uint32_t k, Real part) const {
  return kLeastSkin * kMaxDeviation * s.thickness + kParts * part * length(velocity[s.first + k].vec());
}

// Where point k of the sheet is, with its skin; `again`: it had one.
void SurfaceContact::Impl::choose_rest(const Surface& s, NearSearch& near, std::uint32_t k, bool again, Real part) {
  const std::uint32_t i = s.first + k;
  Row4& rest = near.rest[k];
  Real skin = fresh_skin(s, k, part);
  if (again && allowed[i] > rest.w) skin = std::max(skin, std::min(rest.w * kWiden, kWidest * s.thickness));
  rest.set(current_position(i));
  rest.w = delta_position[i].w == 0 ? Real(0) : skin;
}

// Sets what each point is allowed to deviate in this part; false when that is more than its skin, or when many skins
// are far wider than is needed now.
bool SurfaceContact::Impl::kept_holds(NearSearch& near, Real part) {
  bool good = true;
  std::size_t loose = 0;
  for (const std::uint32_t i : near.near_vertex) {
    const Surface& s = list[near_surface[i]];
    loose += max_deviation[i] > kLoose * fresh_skin(s, i - s.first, part);
    const Real far = length(Vec3(current_position(i) - search_position[i]));
    const Real more = 2 * part * length(velocity[i].vec()) + bearable[near_surface[i]];
    allowed[i] = delta_position[i].w == 0 ? far : far + more;
    good = good && !(allowed[i] > max_deviation[i]);
  }
  return good && loose < near.near_vertex.size() / kSomeLoose;
}

// Whether a candidate may come within its thickness while its points stay in what they are allowed.
bool SurfaceContact::Impl::in_reach(const NearCandidate& p) const {
  const Real a = allowed[p.v[0]], b = allowed[p.v[1]], c = allowed[p.v[2]], d = allowed[p.v[3]];
  return !(p.spare > (p.edges ? std::max(a, b) + std::max(c, d) : a + std::max({b, c, d})));
}

// Candidates by pairs of blocks; with what is left of the search before where that was taken over.
void SurfaceContact::Impl::collect_kept(const SurfaceGroup& g, NearSearch& near, Real time) {
  const std::uint32_t n = g.members[0], first = list[n].first;
  FlatParts& parts = *flat_parts[n];
  const auto count = [&] { return static_cast<std::uint32_t>(near.candidates.size()); };
  near.old_of.assign(parts.blocks(), kNone), near.next_old.resize(near.old_meetings.size());
  for (std::uint32_t m = 0; m < near.old_meetings.size(); ++m) {
    std::uint32_t& head = near.old_of[near.old_meetings[m].a];
    near.next_old[m] = head, head = m;
  }
  near.meetings.clear();
  const auto close = [&] {  // the pair of blocks before
    test_offered(near, time);
    if (!near.meetings.empty()) near.meetings.back().last = count();
  };
  const auto wanted = [&](std::uint32_t a, std::uint32_t b) {
    close();
    near.meetings.push_back({a, b, count(), count()});
    if (near.old_meetings.empty() || near.again[a] || near.again[b]) return true;
    for (std::uint32_t m = near.old_of[a]; m != kNone; m = near.next_old[m]) {
      const NearSearch::Meeting& old = near.old_meetings[m];
      if (old.b != b) continue;
      const auto from = near.old_candidates.begin();
      near.candidates.insert(near.candidates.end(), from + old.first, from + old.last);
      return false;
    }
    return true;  // no certificate rules it out any more
  };
  if (!sealed[n])
    parts.find_pairs(kNear * list[n].thickness, wanted, [&](const std::uint32_t(&v)[4], bool edges) {
      offer_pair(near, {first + v[0], first + v[1], first + v[2], first + v[3]}, edges, time);
    });
  close();
  near.old_meetings.clear();
}

// Searches again for the blocks with points that have used up most of their skins; false where those are many.
bool SurfaceContact::Impl::search_part(const SurfaceGroup& g, NearSearch& near, Real time, Real part) {
  const std::uint32_t n = g.members[0];
  const Surface& s = list[n];
  const FlatParts& parts = *flat_parts[n];
  if (static_cast<Real>(near.rows) < kUnfolded * static_cast<Real>(s.count)) return false;
  near.again.assign(parts.blocks(), 0);
  std::uint32_t count = 0;
  const auto used_up = [&](std::uint32_t k) {
    const Real skin = near.rest[k].w;
    return allowed[s.first + k] > kUsed * skin || skin > kLoose * fresh_skin(s, k, part);
  };
  for (std::uint32_t b = 0; b < parts.blocks(); ++b)
    for (const std::uint32_t k : parts.points_of(b)) {
      if (!used_up(k)) continue;
      near.again[b] = 1, ++count;
      break;
    }
  if (static_cast<Real>(count) > kMany * static_cast<Real>(parts.blocks())) return false;
  for (std::uint32_t k = 0; k < s.count; ++k)
    if (used_up(k)) choose_rest(s, near, k, true, part);
  near.meetings.swap(near.old_meetings), near.candidates.swap(near.old_candidates);
  list_features(g, near, time, false);
  collect_pairs(g, near, time);
  return true;
}

// Candidates for the coming part, and where they are kept what its points are allowed in it.
void SurfaceContact::Impl::update_pairs(const SurfaceGroup& g, NearSearch& near, Real time, Real part) {
  if (near.kept && any_tangled) near.drop();  // its candidates leave out what crosses now
  if (near.kept && !near.listed) {            // from a snapshot: not a search of this step
    list_features(g, near, time, false), collect_pairs(g, near, time);
    --search_total;
  }
  if (near.kept ? kept_holds(near, part) : !near.pairs_stale) return;
  if (!near.kept || !search_part(g, near, time, part)) {
    const bool again = near.kept && !sealed[g.members[0]];
    near.kept = false;
    list_features(g, near, time, false);
    collect_pairs(g, near, time);
    if (slow(g, near, part)) {
      const Surface& s = list[g.members[0]];
      near.rest.resize(s.count);
      for (std::uint32_t k = 0; k < s.count; ++k) choose_rest(s, near, k, again, part);
      near.kept = true, near.kept_of = kept_of(s.loop);
      list_features(g, near, time, false);
      collect_pairs(g, near, time);
      --search_total;
    }
  }
  if (near.kept) kept_holds(near, part);
}

void SurfaceContact::Impl::save_kept(Writer& w) const {
  std::uint64_t count = 0;
  for (const auto& near : searches) count += near->kept;
  w.add(count);
  for (const auto& near : searches)
    if (near->kept) w.add(near->kept_of), w.add(near->rows), w.list(near->rest);
}

void SurfaceContact::Impl::load_kept(Reader& r) {
  for (const auto& near : searches) near->drop();
  kept_images.clear();
  for (std::uint64_t left = r.get<std::uint64_t>(); left > 0; --left) {
    KeptImage& image = kept_images.emplace_back(arena);
    r.get(image.of), r.get(image.rows), r.list(image.rest);
  }
}

}  // namespace feder
