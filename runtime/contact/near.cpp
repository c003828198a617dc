// Proximity of surfaces, to themselves and to each other: points near triangles and edges near edges.
// A search extrapolates uniform motion over the rest of the step and allows each vertex a deviation from it; its
// candidates are all pairs that could then come within their thickness, from trees of swept boxes. The non-penetration
// projection (non_penetration.cpp) asks for a new search before a vertex uses up its deviation, and searches again
// along the true displacements when one did: usually there is one search per step, and one per substep while cloth is
// being stopped; where a folded sheet has come to rest, one in many steps. In each substep the closest points of
// candidates (Ericson, Real-Time Collision Detection, 2005, 5.1.5 and 5.1.9) give rows that keep the thickness, where
// Bridson, Fedkiw & Anderson 2002 have repulsion impulses. A pair that is closer than the thickness at rest keeps to
// its rest distance. A flat sheet against itself is searched by its parts instead of by trees (flat_parts.h): what
// moves as one piece costs a test per triangle. Kept between steps: what follows from meshes, and the candidates of
// folded sheets at rest (kept.cpp). Weak spot: normals and weights are frozen through a substep, or a part of one where
// the approach is fast; that no pair crosses meanwhile is left to the projection.
#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/impl.h"

namespace feder {
namespace {

// Of the thickness, at rest: two sides of a crack in a solid, which have no inside and outside while they lie together.
constexpr Real kCrack = Real(1e-3);
constexpr Real kRestShare = Real(0.9);  // of the rest distance, kept where that is below the thickness
constexpr int kMaxSearches = 64;        // parts of a substep
constexpr Real kNoDirection = std::numeric_limits<Real>::min() * Real(16);  // m
constexpr JobGrain kListGrain{1024, 10'000};                                // points per job
constexpr std::size_t kOffered = 1024;                                      // pairs that are tested together
constexpr Real kClosedShare = Real(0.2);  // of a certificate (flat_parts.h), that deviations may take
constexpr Real kMostlySure =
    Real(0.5);  // of the least windows: share from which certificates are worth a small deviation
constexpr Real kFreeShare =
    Real(0.05);  // of the weights on free vertices, below which a pair is that of its pinned ones

// Quotient along a segment; 0 where its ends coincide.
Real share(Real part, Real whole) { return whole > 0 ? part / whole : Real(0); }

// Closest point of the triangle to p by barycentric weights (Ericson 2005, 5.1.5).
void closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, Real (&w)[3]) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const Real d1 = dot(ab, ap), d2 = dot(ac, ap);
  w[0] = w[1] = w[2] = 0;
  if (d1 <= 0 && d2 <= 0) return void(w[0] = 1);
  const Vec3 bp = p - b;
  const Real d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return void(w[1] = 1);
  const Real vc = d1 * d4 - d3 * d2;
  // an edge without length is skipped: its neighbours decide
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return void((w[1] = d1 / (d1 - d3), w[0] = 1 - w[1]));
  const Vec3 cp = p - c;
  const Real d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return void(w[2] = 1);
  const Real vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return void((w[2] = d2 / (d2 - d6), w[0] = 1 - w[2]));
  const Real va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0 && (d4 - d3) + (d5 - d6) > 0)
    return void((w[2] = (d4 - d3) / ((d4 - d3) + (d5 - d6)), w[1] = 1 - w[2]));
  const Real sum = va + vb + vc;
  if (!(sum > 0)) return void(w[0] = 1);
  w[1] = vb / sum, w[2] = vc / sum, w[0] = 1 - w[1] - w[2];
}

// Closest points of two segments, as shares from a to b and from c to d (Ericson 2005, 5.1.9).
void closest_on_segments(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, Real& s, Real& t) {
  const Vec3 u = b - a, v = d - c, r = a - c;
  const Real uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), ur = dot(u, r), vr = dot(v, r);
  const Real det = uu * vv - uv * uv;
  s = det > Real(1e-6) * uu * vv ? clamp((uv * vr - ur * vv) / det, 0, 1) : Real(0);
  t = share(uv * s + vr, vv);
  if (t < 0) t = 0, s = clamp(share(-ur, uu), 0, 1);
  if (t > 1) t = 1, s = clamp(share(uv - ur, uu), 0, 1);
  FEDER_ASSERT(!(s < 0 || s > 1 || t < 0 || t > 1));
}

// From the closest point of the second feature to that of the first, with the weights of the four points in it.
template <class Position>
Vec3 gap_vector(const std::uint32_t* v, bool edges, Position&& position_of, Real (&weight)[4]) {
  const Vec3 x0 = position_of(v[0]), x1 = position_of(v[1]), x2 = position_of(v[2]), x3 = position_of(v[3]);
  if (edges) {
    Real s = 0, t = 0;
    closest_on_segments(x0, x1, x2, x3, s, t);
    weight[0] = 1 - s, weight[1] = s, weight[2] = t - 1, weight[3] = -t;
  } else {
    Real w[3];
    closest_on_triangle(x0, x1, x2, x3, w);
    weight[0] = 1;
    for (int k = 0; k < 3; ++k) weight[k + 1] = -w[k];
  }
  FEDER_ASSERT(sums_to(weight, 0));
  return weight[0] * x0 + weight[1] * x1 + weight[2] * x2 + weight[3] * x3;
}

// Calls f(batch, pairs) for pairs of one kind, eight at a time as far as they go; `which` names them among `all`.
template <class Pair, class F>
void each_batch(Array<Pair>& all, const Array<std::uint32_t>& which, F&& f) {
  PairBatch batch;
  for (std::size_t first = 0; first < which.size(); first += kLanes) {
    const std::size_t count = std::min(which.size() - first, std::size_t(kLanes));
    for (std::size_t i = 0; i < kLanes; ++i) {
      const Pair& p = all[which[first + std::min(i, count - 1)]];
      for (int k = 0; k < 4; ++k) batch.v[k][i] = p.v[k];
      batch.wanted.v[i] = kNear * p.thickness;
    }
    f(
        batch, [&](std::size_t i) -> Pair& { return all[which[first + i]]; }, count);
  }
}

}  // namespace

std::uint32_t SurfaceContact::Impl::surface_pair_of(std::uint32_t a, std::uint32_t b) const {
  for (std::uint32_t k = 0; k < surface_pairs.size(); ++k)
    if ((surface_pairs[k].a == a && surface_pairs[k].b == b) || (surface_pairs[k].a == b && surface_pairs[k].b == a))
      return k;
  return kNone;
}

bool SurfaceContact::Impl::paired(std::uint32_t n) const {
  return std::any_of(surface_pairs.begin(), surface_pairs.end(),
                     [&](const SurfacePair& k) { return k.a == n || k.b == n; });
}

bool SurfaceContact::Impl::near_wanted(const SurfaceGroup& g) const {
  for (const std::uint32_t n : g.members) {
    if ((list[n].active && list[n].self) || paired(n)) return true;
  }
  return false;
}

// Bounds of what other surfaces a surface may be in contact with in this step: nothing where there are none.
void SurfaceContact::Impl::bound_others(const SurfaceGroup& g) {
  box.resize(list.size()), others_box.resize(list.size());
  for (const std::uint32_t n : g.members) {
    const Surface& s = list[n];
    box[n] = others_box[n] = Aabb();
    if (paired(n))
      for (std::uint32_t i = s.first; i < s.first + s.count; ++i) box[n].include(vertex_box[i]);
  }
  for (const SurfacePair& k : surface_pairs) {
    if (list[k.a].loop != list[g.members[0]].loop) continue;
    others_box[k.a].include(box[k.b]), others_box[k.b].include(box[k.a]);
  }
}

FlatParts& SurfaceContact::Impl::parts_of(const Surface& s) {
  for (PartsOf& p : all_parts)
    if (p.object == s.object) return *p.parts;
  all_parts.push_back({s.object, std::make_unique<FlatParts>(arena)});
  return *all_parts.back().parts;
}

// Contacts of flat sheets with themselves are found by their parts. Where a smaller deviation would rule out all of
// them, or most where the usual one does not, that is what the search allows, unless points are to be held back.
void SurfaceContact::Impl::measure_parts(const SurfaceGroup& g, Real time, bool held) {
  for (const std::uint32_t n : g.members) {
    const Surface& s = list[n];
    if (!s.active || !s.self || own_search[n]) continue;
    FlatParts& p = parts_of(s);
    p.build(s);
    if (!p.flat()) continue;
    Real* deviation = max_deviation.data() + s.first;
    p.measure({search_position.data() + s.first, search_velocity.data() + s.first, deviation, time, held}, *jobs);
    flat_parts[n] = &p, sealed[n] = p.decide(kInfinity);
    const Real less = kClosedShare / p.heights(), share = p.sure_share();
    if (sealed[n] || held || !(less < bearable[n])) continue;
    sealed[n] = p.decide(less);
    if (sealed[n] || (share < kMostlySure && p.sure_share() > kMostlySure)) {
      bearable[n] = less;
      for (std::uint32_t i = 0; i < s.count; ++i) deviation[i] = std::min(deviation[i], less);
    } else {
      p.decide(kInfinity);
    }
  }
}

// Points, triangles and edges of the surfaces that take part, with their swept boxes.
void SurfaceContact::Impl::list_features(const SurfaceGroup& g, NearSearch& near, Real time, bool held) {
  for_each_of([](auto& array) { array.clear(); }, near.near_vertex, near.near_point, near.near_triangle,
              near.near_edge);
  // drift: boxes move along with a group that nothing holds, else they would cover its path
  near.drift = Vec3::Zero();
  Real sum = 0;
  bool free = true;
  for (const std::uint32_t n : g.members) {
    const Surface& s = list[n];
    free = free && !s.pinned && s.active;
    for (std::uint32_t i = s.first; i < s.first + s.count; ++i)
      near.drift += mass[i] * velocity[i].vec(), sum += mass[i];
  }
  near.drift = free && !near.kept ? Vec3(near.drift / sum) : Vec3(0, 0, 0);
  // points: uniform motion relative to the drift, and the allowed deviation round it
  const std::uint32_t size = surfaces.size();
  vertex_box.resize(size), search_position.resize(size), search_velocity.resize(size), max_deviation.resize(size);
  allowed.resize(size), search_row.resize(size), search_way.resize(size);
  near_surface.resize(size), flat_parts.resize(list.size()), bearable.resize(list.size()), sealed.resize(list.size());
  own_search.resize(list.size());
  for (const std::uint32_t n : g.members) {
    const Surface& s = list[n];
    own_search[n] = s.active && s.self ? search_of(s) : nullptr;
    flat_parts[n] = nullptr, sealed[n] = 0, bearable[n] = kMaxDeviation * s.thickness;
    if (!(s.active && s.self) && !paired(n)) continue;
    const Real half = Real(0.5) * s.thickness;
    const auto base = near.near_vertex.size();
    near.near_vertex.resize(base + s.count);
    jobs->for_blocks(s.count, kListGrain, [&](std::uint32_t begin, std::uint32_t end, int) {
      for (std::uint32_t k = begin; k < end; ++k) {
        const std::uint32_t i = s.first + k;
        near.near_vertex[base + k] = i;
        near_surface[i] = n;
        const Row4* rest = near.kept ? &near.rest[k] : nullptr;
        search_position[i] = rest ? rest->vec() : current_position(i);
        search_velocity[i] = delta_position[i].w != 0 && !rest ? velocity[i].vec() : Vec3(0, 0, 0);
        const Vec3 beside = search_velocity[i] - near.drift, far = search_position[i] + time * beside;
        // a point that the projection holds back to the drift deviates by all of its motion
        max_deviation[i] = rest                       ? rest->w
                           : delta_position[i].w == 0 ? Real(0)
                                                      : bearable[n] + (held ? time * length(beside) : Real(0));
        Aabb& b = vertex_box[i];
        b.lo = search_position[i].cwiseMin(far), b.hi = search_position[i].cwiseMax(far);
        b.grow(max_deviation[i] + Real(1.1) * half);
      }
    });
  }
  bound_others(g);
  measure_parts(g, time, held || near.kept);
  for (const std::uint32_t i : near.near_vertex)
    search_row[i].set(search_position[i]), search_row[i].w = max_deviation[i], search_way[i].set(search_velocity[i]);
  // features that may be in contact
  for (const std::uint32_t n : g.members) {
    const Surface& s = list[n];
    const std::uint32_t* ends = s.edges.ends;
    if ((flat_parts[n] || !(s.active && s.self)) && others_box[n].empty()) continue;
    for (std::uint32_t i = s.first; i < s.first + s.count; ++i)
      if (searched(n, vertex_box[i])) near.near_point.push_back(i);
    for (std::size_t t = 0; t + 2 < s.triangles.size(); t += 3) {
      const std::uint32_t* v = &s.triangles[t];
      if (!searched(n, box_of(s.first + v[0], s.first + v[1], s.first + v[2]))) continue;
      for (int k = 0; k < 3; ++k) near.near_triangle.push_back(s.first + v[k]);
    }
    for (std::uint32_t e = 0; e < s.edges.count; ++e, ends += s.edges.stride) {
      if (!searched(n, box_of(s.first + ends[0], s.first + ends[1], s.first + ends[1]))) continue;
      near.near_edge.push_back(s.first + ends[0]), near.near_edge.push_back(s.first + ends[1]);
    }
  }
  FEDER_ASSERT(near.near_triangle.size() % 3 == 0 && near.near_vertex.size() <= size);
  near.triangle_box.resize(near.near_triangle.size() / 3), near.edge_box.resize(near.near_edge.size() / 2);
  for (std::size_t t = 0; t < near.triangle_box.size(); ++t) {
    const std::uint32_t* v = &near.near_triangle[3 * t];
    near.triangle_box[t] = box_of(v[0], v[1], v[2]);
  }
  for (std::size_t e = 0; e < near.edge_box.size(); ++e) {
    const std::uint32_t* v = &near.near_edge[2 * e];
    near.edge_box[e] = box_of(v[0], v[1], v[1]);
  }
}

// Offers a pair of features to test_offered, unless its surfaces do not collide.
void SurfaceContact::Impl::offer_pair(NearSearch& near, const std::uint32_t (&v)[4], bool edges, Real time) {
  FEDER_ASSERT(v[0] != v[2] && v[0] != v[3] && v[1] != v[2] && v[1] != v[3]);
  FEDER_ASSERT(edges || (v[0] != v[1] && v[2] != v[3]));
  const std::uint32_t surface_a = near_surface[v[0]], surface_b = near_surface[v[3]];
  FEDER_ASSERT(surface_a < list.size() && surface_b < list.size());
  FEDER_ASSERT(near_surface[v[2]] == surface_b && near_surface[v[1]] == (edges ? surface_a : surface_b));
  const std::uint32_t both = surface_a == surface_b ? kNone : surface_pair_of(surface_a, surface_b);
  if (surface_a == surface_b ? !list[surface_a].active || !list[surface_a].self : both == kNone) return;
  if (!link_marks.empty() && linked(v, edges)) return;
  NearCandidate& p = near.offered.emplace_back();
  std::copy(v, v + 4, p.v);
  p.edges = edges, p.surface_pair = both;
  p.thickness = Real(0.5) * (list[surface_a].thickness + list[surface_b].thickness);
  if (near.offered.size() == kOffered) test_offered(near, time);
}

// Adds the pairs offered, in order, but for those whose distance is more than they can close in `time`.
void SurfaceContact::Impl::test_offered(NearSearch& near, Real time) {
  if (near.offered.empty()) return;
  for (std::uint32_t edges = 0; edges < 2; ++edges) {
    near.which.clear();
    for (std::uint32_t k = 0; k < near.offered.size(); ++k)
      if (near.offered[k].edges == edges) near.which.push_back(k);
    each_batch(near.offered, near.which, [&](PairBatch& b, auto&& pair, std::size_t count) {
      const unsigned meets = kernels->meet(b, edges != 0, &search_row[0].x, &search_way[0].x, time);
      for (std::size_t i = 0; i < count; ++i) {
        NearCandidate& p = pair(i);
        p.spare = b.distance.v[i] - b.wanted.v[i];
        p.idle = (meets >> i & 1) != 0 ? b.closing.v[i] : Real(-1);
      }
    });
  }
  for (NearCandidate& p : near.offered) {
    if (p.idle < 0) continue;
    const std::uint32_t split = p.edges ? 2 : 1;
    Real own[2] = {0, 0};
    for (std::uint32_t i = 0; i < 4; ++i) own[i >= split] = std::max(own[i >= split], max_deviation[p.v[i]]);
    const Real free = p.spare - own[0] - own[1];  // m, to be closed by extrapolated motion
    p.idle = free > 0 ? free / p.idle : Real(0);
    FEDER_ASSERT(!(p.idle < 0));
    // within one surface: no row pushes apart what is that close at rest
    if (p.surface_pair == kNone) {
      const Real rest = rest_distance(p);
      if (rest < kCrack * p.thickness && list[near_surface[p.v[0]]].solid) continue;
      p.thickness = std::min(p.thickness, kRestShare * rest);
    }
    if (tangled_pair(p) && list[near_surface[p.v[0]]].ignores_inside) continue;
    near.candidates.push_back(p);
  }
  near.offered.clear();
}

// Of a pair within one surface; where it is far beyond the thickness, less may be returned that is beyond it too.
Real SurfaceContact::Impl::rest_distance(const NearCandidate& p) const {
  const Surface& s = list[near_surface[p.v[0]]];
  const auto at = [&](std::uint32_t i) { return s.rest[i - s.first]; };
  const auto apart = [&](int i, int j) { return length(Vec3(at(p.v[i]) - at(p.v[j]))); };
  const Real least = p.edges ? apart(0, 2) - apart(0, 1) - apart(2, 3) : apart(0, 1) - apart(1, 2) - apart(1, 3);
  if (kRestShare * least > p.thickness) return least;
  Real weight[4];
  return length(gap_vector(p.v, p.edges, at, weight));
}

void SurfaceContact::Impl::find_pairs(const SurfaceGroup& g, NearSearch& near, Real time, bool held) {
  near.kept = false;
  list_features(g, near, time, held);
  collect_pairs(g, near, time);
}

// The candidates among the features that list_features found.
void SurfaceContact::Impl::collect_pairs(const SurfaceGroup& g, NearSearch& near, Real time) {
  near.pairs_stale = false, near.listed = true;
  ++search_total;
  near.since_found = 0;
  near.candidates.clear();
  if (near.kept) return collect_kept(g, near, time);
  for (const std::uint32_t n : g.members) {
    if (own_search[n]) find_own_pairs(near, n, time);
    if (!flat_parts[n] || sealed[n]) continue;
    const std::uint32_t first = list[n].first;
    flat_parts[n]->find_pairs(kNear * list[n].thickness, [&](const std::uint32_t(&v)[4], bool edges) {
      offer_pair(near, {first + v[0], first + v[1], first + v[2], first + v[3]}, edges, time);
    });
  }
  if (near.near_point.empty() && near.near_edge.empty()) return test_offered(near, time);
  // the trees are refitted by later searches of the step but built anew in the next one: the order of near.pairs must
  // follow from the state at the start of a step
  const std::span<const Aabb> triangle_boxes(near.triangle_box.data(), near.triangle_box.size()),
      edge_boxes(near.edge_box.data(), near.edge_box.size());
  near.trees_stale ? near.triangle_tree.build(triangle_boxes) : near.triangle_tree.refit(triangle_boxes);
  near.trees_stale ? near.edge_tree.build(edge_boxes) : near.edge_tree.refit(edge_boxes);
  near.trees_stale = false;
  // points against triangles
  for (const std::uint32_t i : near.near_point) {
    near.triangle_tree.query(vertex_box[i], [&](std::uint32_t t) {
      FEDER_ASSERT(t < near.triangle_box.size());
      const std::uint32_t* k = &near.near_triangle[3 * t];
      if (k[0] != i && k[1] != i && k[2] != i && searched_together(i, k[2]))
        offer_pair(near, {i, k[0], k[1], k[2]}, false, time);
    });
  }
  // edges against later edges
  near.edge_tree.pairs([&](std::uint32_t e, std::uint32_t f) {
    const std::uint32_t a = near.near_edge[2 * e], b = near.near_edge[2 * e + 1];
    const std::uint32_t p = near.near_edge[2 * f], q = near.near_edge[2 * f + 1];
    if (a != p && a != q && b != p && b != q && searched_together(a, p)) offer_pair(near, {a, b, p, q}, true, time);
  });
  test_offered(near, time);
}

// The candidates that may come near in this part, or all, with normal, distance and weights at the present positions.
void SurfaceContact::Impl::list_pairs_of(NearSearch& near, bool all, Real part) {
  near.pairs.clear();
  for (const NearCandidate& p : near.candidates)
    if (all || (near.kept ? in_reach(p) : near.since_found + part >= p.idle)) near.pairs.emplace_back(p);
  now_row.resize(delta_position.size());
  for (const std::uint32_t i : near.near_vertex) now_row[i].set(current_position(i));
  for (std::uint32_t edges = 0; edges < 2; ++edges) {
    near.which.clear();
    for (std::uint32_t k = 0; k < near.pairs.size(); ++k)
      if (near.pairs[k].edges == edges) near.which.push_back(k);
    each_batch(near.pairs, near.which, [&](PairBatch& b, auto&& pair, std::size_t count) {
      kernels->measure(b, edges != 0, &now_row[0].x);
      for (std::size_t i = 0; i < count; ++i) {
        NearPair& p = pair(i);
        p.distance = b.distance.v[i];
        const Vec3 normal(b.gap.x.v[i], b.gap.y.v[i], b.gap.z.v[i]);
        p.normal = p.distance > kNoDirection ? normal : Vec3(0, 1, 0);
        for (int k = 0; k < 4; ++k) p.weight[k] = b.weight[k].v[i];
      }
    });
  }
}

// Number of parts in which a substep is searched and projected: more than one where bodies approach by more than half a
// thickness in it.
int SurfaceContact::Impl::search_count(const SurfaceGroup& g, StepContext& c) const {
  Real most = 1;
  for (const std::uint32_t n : g.members)
    if (const Surface& s = list[n]; s.active)
      most = std::max(most, std::min(c.h * s.approach_speed / (Real(0.5) * s.thickness), Real(kMaxSearches)));
  FEDER_ASSERT(most >= 1 && most <= kMaxSearches);
  return std::min(static_cast<int>(std::ceil(most)), g.steps);
}

void SurfaceContact::Impl::make_near_rows(SurfaceGroup& g, NearSearch& near, Real time, Real part) {
  g.near_rows.clear();
  projection_start.resize(delta_position.size());
  for (const std::uint32_t n : g.members) {
    const auto first = delta_position.begin() + list[n].first;
    std::copy(first, first + list[n].total, projection_start.begin() + list[n].first);
  }
  // a candidate gets a row when it can come within its thickness in twice the part's motion
  update_pairs(g, near, time, part);
  list_pairs_of(near, false, part);
  for (const NearPair& p : near.pairs) {
    if (tangled_pair(p)) continue;
    const Real(&weight)[4] = p.weight;
    Vec3 u = Vec3::Zero();
    for (int k = 0; k < 4; ++k) u += weight[k] * velocity[p.v[k]].vec();
    const Real closing = std::max(-dot(u, p.normal), Real(0));
    if (p.distance > kNear * p.thickness + 2 * part * closing) continue;
    Vec3 d = Vec3::Zero();
    Real held = 0;
    for (int k = 0; k < 4; ++k) {
      const Row4& x = delta_position[p.v[k]];
      d += weight[k] * x.vec();
      if (x.w == 0) held += std::abs(weight[k]);
    }
    if (held > 2 * (1 - kFreeShare)) continue;
    // C = distance - thickness along the frozen normal, linear in the displacements
    SurfaceRow r;
    std::copy(p.v, p.v + 4, r.vertex);
    std::copy(weight, weight + 4, r.weight);
    r.normal = p.normal;
    r.offset = p.distance - p.thickness - dot(p.normal, d);
    const Surface &a = list[near_surface[p.v[0]]], &b = list[near_surface[p.v[3]]];
    FEDER_ASSERT((p.surface_pair == kNone) == (&a == &b) &&
                 (p.surface_pair == kNone || p.surface_pair < surface_pairs.size()));
    r.contact_state = p.surface_pair, r.edges = p.edges;
    r.friction = std::sqrt(a.friction * b.friction);
    r.relaxation = std::min(a.relaxation, b.relaxation);
    g.near_rows.push_back(r);
  }
  near.rows = static_cast<std::uint32_t>(g.near_rows.size());
  batch_rows(g, near);
}

// Impulses of the rows between two surfaces, for the contact book. Self-contact has no events.
void SurfaceContact::Impl::collect_near(const SurfaceGroup& g) {
  for (const SurfaceRow& r : g.near_rows) {
    if (r.contact_state == kNone || r.impulse == 0) continue;
    SurfacePair& k = surface_pairs[r.contact_state];
    k.impulse += r.impulse;
    if (!(r.impulse > k.strongest)) continue;
    k.strongest = r.impulse, k.speed = r.approach;
    Vec3 u = Vec3::Zero();
    for (int i = 0; i < 4; ++i) u += r.weight[i] * velocity[r.vertex[i]].vec();
    k.slip = length(Vec3(u - dot(u, r.normal) * r.normal));
    const bool reversed = near_surface[r.vertex[0]] != k.a;
    const std::uint32_t at = r.vertex[reversed ? 3 : 0];
    FEDER_ASSERT(near_surface[at] == k.a && near_surface[r.vertex[reversed ? 0 : 3]] == k.b);
    k.index = at - list[k.a].first, k.point = current_position(at), k.normal = reversed ? r.normal : Vec3(-r.normal);
  }
}

// Momentum that vertex k of a row between two surfaces received, from its true change; of a pinned vertex what its pin
// took.
void SurfaceContact::Impl::account(const SurfaceRow& r, int k, const Vec3& change, const Vec3& wanted, Real h) {
  SurfacePair& pair = surface_pairs[r.contact_state];
  const std::uint32_t i = r.vertex[k];
  FEDER_ASSERT(h > 0 && (near_surface[i] == pair.a || near_surface[i] == pair.b));
  double(&to)[3] = pair.given[near_surface[i] == pair.a ? 0 : 1];
  const bool held = delta_position[i].w == 0;
  const double scale = (held ? 1.0 : static_cast<double>(mass[i])) / static_cast<double>(h);
  for (int j = 0; j < 3; ++j) to[j] += scale * static_cast<double>(held ? wanted[j] : change[j]);
}

}  // namespace feder
