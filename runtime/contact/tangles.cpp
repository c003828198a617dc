// Tangles: crossings of a surface with itself, which no contact row and no projection undoes, since these keep each
// pair of features on the side where it is. At the start of a step they are searched for where the owner says that some
// may be (Surface::suspects: points were put somewhere, or some were left), and led out by moves of positions alone:
// velocities stay. The moves shorten the lines along which the surface meets itself (Volino and Magnenat-Thalmann,
// "Resolving surface collisions through intersection contour minimization", 2006): where an edge along E passes through
// a triangle of normal N and R points along the line into a face of the edge, edge and triangle move against each other
// along the sum of R - 2 (E.R)/(E.N) N. A trial of all crossings is taken back for each connected bunch of them whose
// number would grow, so the number only falls. Features that cross each other have no contact rows meanwhile, and with
// Surface::ignores_inside no projection either, so that the owner's forces may pull them apart. A surface with more
// than most_tangles of them has no contact with itself at all until its forces
// have sorted it out: a search ends at the first crossing too many. Cost of a step: one search of the surface, and up
// to three per trial of what the trial moves; the owner says how many trials (6 while the number falls, 2 while it does
// not, none at rest). Kept between steps: nothing. Weak spot: where two lines end on each other no small move shortens
// them.
#include "contact/tangles.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "contact/impl.h"

namespace feder {
namespace {

constexpr Real kTrialMove = 1;           // thicknesses, or lengths of the edge, that a trial moves a point at most
constexpr Real kShorter = Real(0.3);     // of that, in the next two trials: along the gradient, to the neighbours
constexpr Real kLeastSlope = Real(0.1);  // of |E.N|: an edge along the triangle would ask for infinite moves

CrossingMesh crossing_mesh(const Surface& s, std::span<const Vec3> points) {
  return {points, s.triangles, s.edges.ends, s.edges.stride, s.edges.count};
}

std::uint32_t root_of(Array<std::uint32_t>& of, std::uint32_t i) {
  while (of[i] != i) i = of[i] = of[of[i]];
  return i;
}

// Calls f(point) for the ends of the edge and the corners of the triangle.
template <class F>
void each_point(const CrossingMesh& m, const Crossing& c, F&& f) {
  f(m.edge(c.edge)[0]), f(m.edge(c.edge)[1]);
  for (int k = 0; k < 3; ++k) f(m.triangles[3 * c.triangle + static_cast<std::uint32_t>(k)]);
}

// The faces of the edges that cross.
void list_faces(const CrossingMesh& m, Tangles& t) {
  const auto before = [](const Tangles::Faces& p, const Tangles::Faces& q) {
    return p.a != q.a ? p.a < q.a : p.b < q.b;
  };
  t.faces.clear();
  for (std::size_t k = 0; k < t.found.size(); ++k) {
    if (k > 0 && t.found[k].edge == t.found[k - 1].edge) continue;
    const std::uint32_t* end = m.edge(t.found[k].edge);
    t.faces.push_back({std::min(end[0], end[1]), std::max(end[0], end[1]), {kNone, kNone}});
  }
  std::sort(t.faces.begin(), t.faces.end(), before);
  for (std::size_t n = 0; n < m.triangles.size(); n += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = m.triangles[n + k], b = m.triangles[n + (k + 1) % 3];
      const Tangles::Faces side{std::min(a, b), std::max(a, b), {kNone, kNone}};
      const auto at = std::lower_bound(t.faces.begin(), t.faces.end(), side, before);
      if (at == t.faces.end() || at->a != side.a || at->b != side.b) continue;
      at->opposite[at->opposite[0] == kNone ? 0 : 1] = m.triangles[n + (k + 2) % 3];
    }
}

// Adds what a crossing asks of its points: edge and triangle against each other, along the gradient.
void add_shift(const CrossingMesh& m, const Crossing& c, Tangles& t, Real most) {
  const std::uint32_t a = std::min(m.edge(c.edge)[0], m.edge(c.edge)[1]),
                      b = std::max(m.edge(c.edge)[0], m.edge(c.edge)[1]);
  const std::uint32_t* v = &m.triangles[3 * c.triangle];
  const Vec3 &p = t.now[a], &q = t.now[b], &x = t.now[v[0]], &y = t.now[v[1]], &z = t.now[v[2]];
  const Vec3 normal = cross(y - x, z - x);
  const Real area = length(normal), long_edge = length(q - p);
  if (!(area > 0) || !(long_edge > 0)) return;
  const Vec3 n = normal / area, e = (q - p) / long_edge;
  // where the edge passes through, by weights of both features
  const Real above = dot(n, p - x), below = dot(n, q - x);
  const Real share = above != below ? clamp(above / (above - below), 0, 1) : Real(0.5);
  const Vec3 at = p + share * (q - p);
  Real w[3] = {std::max(Real(0), dot(n, cross(z - y, at - y)) / area),
               std::max(Real(0), dot(n, cross(x - z, at - z)) / area), 0};
  w[2] = std::max(Real(0), 1 - w[0] - w[1]);
  // the gradient, from the faces of the edge
  const Tangles::Faces key{a, b, {kNone, kNone}};
  const auto face = std::lower_bound(t.faces.begin(), t.faces.end(), key,
                                     [](const auto& f, const auto& g) { return f.a != g.a ? f.a < g.a : f.b < g.b; });
  FEDER_ASSERT(face != t.faces.end() && face->a == a && face->b == b);
  Vec3 gradient = Vec3::Zero();
  const Real slope = dot(e, n), steep = std::copysign(std::max(std::abs(slope), kLeastSlope), slope);
  for (const std::uint32_t o : face->opposite) {
    if (o == kNone) continue;
    const Vec3 inward = t.now[o] - p - dot(t.now[o] - p, e) * e;
    Vec3 r = normalized_or(cross(n, cross(e, inward)), Vec3(0, 0, 0));
    if (dot(r, inward) < 0) r = -r;
    gradient += r - (2 * dot(e, r) / steep) * n;
  }
  const Real size = length(gradient), edge_size = std::min(long_edge, std::sqrt(area));
  if (!(size > 0) || !is_finite(gradient)) return;
  const Vec3 move = (std::min(most, kTrialMove * edge_size) / size) * gradient;
  t.shift[a] += (1 - share) * move, t.shift[b] += share * move;
  for (int k = 0; k < 3; ++k) t.shift[v[k]] -= w[k] * move;
}

// Towards the mean of the neighbours along edges, for the points of what crosses and `rings` of edges round them.
void add_smoothing(const CrossingMesh& m, Tangles& t, std::uint32_t rings) {
  t.of.assign(t.now.size(), 0);
  for (const Crossing& c : t.found) each_point(m, c, [&](std::uint32_t i) { t.of[i] = rings + 1; });
  for (; rings > 0; --rings)
    for (std::uint32_t e = 0; e < m.edges; ++e) {
      std::uint32_t &p = t.of[m.edge(e)[0]], &q = t.of[m.edge(e)[1]];
      if (p == rings + 1 && q == 0) q = rings;
      if (q == rings + 1 && p == 0) p = rings;
    }
  for (std::uint32_t& of : t.of) of = of > 0;
  for (std::uint32_t e = 0; e < m.edges; ++e)
    for (int k = 0; k < 2; ++k) {
      const std::uint32_t i = m.edge(e)[k], j = m.edge(e)[1 - k];
      if (t.of[i] > 0) t.shift[i] += t.now[j] - t.now[i], ++t.of[i];
    }
  for (std::size_t i = 0; i < t.now.size(); ++i)
    if (t.of[i] > 1) t.shift[i] /= static_cast<Real>(2 * (t.of[i] - 1));
}

// Bounds of the features that a trial moves, before and after.
Aabb moved_bounds(const CrossingMesh& m, const Tangles& t) {
  Aabb all;
  const auto include = [&](const std::uint32_t* v, std::uint32_t count) {
    bool any = false;
    for (std::uint32_t k = 0; k < count; ++k) any = any || !t.shift[v[k]].isZero(0);
    for (std::uint32_t k = 0; any && k < count; ++k) all.include(t.now[v[k]]), all.include(t.trial[v[k]]);
  };
  for (std::size_t k = 0; k < m.triangles.size(); k += 3) include(&m.triangles[k], 3);
  for (std::uint32_t e = 0; e < m.edges; ++e) include(m.edge(e), 2);
  return all;
}

// Crossings after a trial: what it moves is searched for within `where`, the others are as before.
void find_after(const CrossingMesh& moved, const Aabb& where, Tangles& t) {
  const auto still = [&](const Crossing& c) {
    bool any = false;
    each_point(moved, c, [&](std::uint32_t i) { any = any || !t.shift[i].isZero(0); });
    return !any;
  };
  t.search.find(moved, where, t.after);
  std::erase_if(t.after, still);
  std::copy_if(t.found.begin(), t.found.end(), std::back_inserter(t.after), still);
  std::sort(t.after.begin(), t.after.end(), [](const Crossing& p, const Crossing& q) {
    return p.edge != q.edge ? p.edge < q.edge : p.triangle < q.triangle;
  });
}

// Bunches of crossings that share points, before and after a trial, and how many each has.
void count_bunches(const CrossingMesh& m, Tangles& t, bool patches) {
  const auto size = static_cast<std::uint32_t>(t.now.size());
  t.of.resize(size), t.counts.assign(size, {});
  for (std::uint32_t i = 0; i < size; ++i) t.of[i] = i;
  const auto join = [&](std::uint32_t i, std::uint32_t j) {
    const std::uint32_t p = root_of(t.of, i), q = root_of(t.of, j);
    t.of[std::max(p, q)] = std::min(p, q);
  };
  for (const Array<Crossing>* list : {&t.found, &t.after})
    for (const Crossing& c : *list) each_point(m, c, [&](std::uint32_t i) { join(m.edge(c.edge)[0], i); });
  for (std::uint32_t e = 0; patches && e < m.edges; ++e) {
    const std::uint32_t i = m.edge(e)[0], j = m.edge(e)[1];
    if (!t.shift[i].isZero(0) && !t.shift[j].isZero(0)) join(i, j);
  }
  for (const Crossing& c : t.found) ++t.counts[root_of(t.of, m.edge(c.edge)[0])].before;
  for (const Crossing& c : t.after) ++t.counts[root_of(t.of, m.edge(c.edge)[0])].after;
}

}  // namespace

// One trial with moves of `most`; bunches that it makes worse stay where they are.
bool SurfaceContact::Impl::try_untangle(const Surface& s, Tangles& t, Real most, bool smooth) {
  const std::uint32_t rings = smooth ? s.untangle_rings : 0;
  const CrossingMesh mesh = crossing_mesh(s, {t.now.data(), t.now.size()});
  const CrossingMesh moved = crossing_mesh(s, {t.trial.data(), t.trial.size()});
  t.shift.assign(t.now.size(), Vec3::Zero());
  if (smooth)
    add_smoothing(mesh, t, rings);
  else
    list_faces(mesh, t);
  for (const Crossing& c : t.found)
    if (!smooth) add_shift(mesh, c, t, most);
  for (std::uint32_t i = 0; i < t.now.size(); ++i) {
    const Real size = length(t.shift[i]);
    if (delta_position[s.first + i].w == 0) t.shift[i] = Vec3::Zero();
    if (size > most) t.shift[i] *= most / size;
    t.trial[i] = t.now[i] + t.shift[i];
  }
  const Aabb where = moved_bounds(mesh, t);
  // what is taken back may cross what is not: once more, then all of it
  for (int pass = 0; pass < 3; ++pass) {
    find_after(moved, where, t);
    count_bunches(mesh, t, rings > 0);
    bool good = true;
    for (std::uint32_t i = 0; i < t.now.size(); ++i) {
      const Tangles::Counts& k = t.counts[root_of(t.of, i)];
      if (k.after <= k.before && pass < 2) continue;
      if (pass == 2 && t.after.size() <= t.found.size()) break;
      good = good && k.after <= k.before;
      t.trial[i] = t.now[i];
    }
    if (pass == 2 && t.after.size() > t.found.size()) return false;
    if (good) break;
  }
  t.now.swap(t.trial), t.found.swap(t.after);
  return true;
}

// Finds crossings where some are suspected, and moves the surface's points out of them.
void SurfaceContact::Impl::untangle(StepContext&) {
  any_tangled = false;
  for (Surface& s : list) {
    if (!s.self || !s.active || s.suspects.empty()) continue;
    if (!tangles) tangles = std::make_unique<Tangles>(arena);
    Tangles& t = *tangles;
    t.start.resize(s.count);
    for (std::uint32_t i = 0; i < s.count; ++i) t.start[i] = current_position(s.first + i);
    const std::span<const Vec3> points(t.start.data(), t.start.size());
    // where some are suspected, then all of them
    const Aabb bounds = bounds_of(points);
    const bool local = !contains(s.suspects, bounds);
    t.search.find(crossing_mesh(s, points), s.suspects, t.found, s.most_tangles);
    if (local && !t.found.empty()) t.search.find(crossing_mesh(s, points), bounds, t.found, s.most_tangles);
    s.tangles = static_cast<std::uint32_t>(t.found.size());
    if (s.tangles > s.most_tangles) s.self = false;
    if (t.found.empty() || !s.self) continue;
    t.now = t.start, t.trial = t.start;
    Real most = kTrialMove * s.thickness * static_cast<Real>(1 + s.untangle_rings);
    for (std::uint32_t trial = 0; trial < s.untangle_trials && !t.found.empty(); ++trial) {
      try_untangle(s, t, most, trial % 2 == 1);
      if (trial % 2 == 1) most *= kShorter;
    }
    for (std::uint32_t i = 0; i < s.count; ++i)
      if (delta_position[s.first + i].w != 0) delta_position[s.first + i].add(t.now[i] - t.start[i]);
    s.tangles = static_cast<std::uint32_t>(t.found.size());
    // features that cross have no rows in this step
    if (!any_tangled) tangled.assign(surfaces.size(), 0);
    any_tangled = true;
    const CrossingMesh mesh = crossing_mesh(s, {t.now.data(), t.now.size()});
    for (const Crossing& c : t.found) each_point(mesh, c, [&](std::uint32_t i) { tangled[s.first + i] = 1; });
  }
}

}  // namespace feder
