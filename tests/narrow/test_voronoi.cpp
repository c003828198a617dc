// Voronoi marching against GJK, separating planes and closed forms; steps of poses that turn; input at its limits.
#include <algorithm>

#include "base/rng.h"
#include "feder/error.h"
#include "geom/hull.h"
#include "geom/hull_features.h"
#include "narrow/narrow_phase.h"
#include "poses.h"
#include "support/catch.h"

using namespace feder;

namespace {

// Of the distance, by the size. In float the corner that GJK's support function picks may be off by rounding.
constexpr double kError = sizeof(Real) == 8 ? 1e-9 : 2e-7;

const NarrowMethod* voronoi() {
  for (const NarrowMethod& m : narrow_methods())
    if (std::string(m.name) == "voronoi") return &m;
  return nullptr;
}

// A hull of so many points, on an ellipsoid or throughout a box.
ShapePtr random_hull(Rng& rng, int points, Real size) {
  const bool round = rng.next() % 2;
  const Vec3 axes = vec3(rng.uniform(Real(0.2), 1), rng.uniform(Real(0.2), 1), rng.uniform(Real(0.2), 1)) * size;
  std::vector<Vec3> cloud;
  for (int i = 0; i < points; ++i) {
    const Vec3 p = round ? random_direction(rng) : vec3(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    cloud.push_back(p.cwiseProduct(axes));
  }
  return make_hull(cloud);
}

struct Tally {
  int queries = 0, handed_on = 0, repeats = 0, overlaps = 0, most = 0;
  long steps = 0;
  double error = 0;  // of the distance, by the size or the distance
  int wrong = 0;     // one of both says overlap, the other a distance above 1e-6 of the size
};

double size_of(const Shape& a, const Shape& b) { return std::max(a.extent(Vec3::Zero()), b.extent(Vec3::Zero())); }

void ask(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, PairCache& cache, Tally& tally) {
  CoreDistance d;
  REQUIRE(voronoi()->distance(a, pa, b, pb, cache, d));
  const ClosestResult truth = closest_points(a, pa, b, pb);
  const double size = size_of(a, b), mine = d.overlap ? 0 : d.distance - double(a.radius() + b.radius());
  ++tally.queries, tally.steps += d.steps, tally.handed_on += d.handed_on, tally.repeats += d.repeat,
      tally.overlaps += d.overlap;
  tally.most = std::max(tally.most, d.steps);
  const double error = std::abs(std::max(mine, 0.0) - double(truth.distance)) / std::max(size, mine);
  tally.error = std::max(tally.error, error);
  tally.wrong += error > 1e-5;
}

Pose near_pose(Rng& rng, const Shape& a, const Shape& b, const Pose& pa, Real share) {
  Pose pb{pa.position, random_rotation(rng)};
  const Vec3 d = random_direction(rng);
  pb.position += d * (-gap_along(a, pa, b, pb, d) * share);
  return pb;
}

void report(const char* what, const Tally& t) {
  UNSCOPED_INFO(what << ": " << t.queries << " queries, error " << t.error << " of the size, " << t.overlaps
                     << " overlaps, mean steps " << double(t.steps) / t.queries << ", most " << t.most << ", handed on "
                     << t.handed_on << ", repeats " << t.repeats);
}

}  // namespace

TEST_CASE("marching finds the distance of 100000 pairs of hulls", "[narrow][voronoi]") {
  if (!voronoi()) return;
  Rng rng(71);
  std::vector<ShapePtr> hulls;
  for (int i = 0; i < 200; ++i) hulls.push_back(random_hull(rng, 4 + static_cast<int>(rng.next() % 60), 1));
  Tally t;
  for (int i = 0; i < 100000; ++i) {
    const Shape &a = *hulls[rng.next() % hulls.size()], &b = *hulls[rng.next() % hulls.size()];
    const Pose pa{random_direction(rng), random_rotation(rng)};
    PairCache cache;
    ask(a, pa, b, near_pose(rng, a, b, pa, rng.uniform(Real(0.3), 3)), cache, t);
  }
  report("hulls", t);
  CHECK(t.error < kError);
  CHECK(t.overlaps > 10000);
  CHECK(t.handed_on < 100);
}

TEST_CASE("marching finds the distance of boxes, boxes and hulls, and polygons", "[narrow][voronoi]") {
  if (!voronoi()) return;
  Rng rng(72);
  Tally boxes, mixed, flat;
  for (int i = 0; i < 30000; ++i) {
    const auto side = [&] { return rng.uniform(Real(0.1), 1); };
    const ShapePtr a = make_box(side(), side(), side()), b = make_box(side(), side(), side());
    const Pose pa{random_direction(rng), random_rotation(rng)};
    PairCache cache;
    ask(*a, pa, *b, near_pose(rng, *a, *b, pa, rng.uniform(Real(0.3), 3)), cache, boxes);
    // aligned ones: faces and edges that are parallel, or nearly
    Pose aligned{pa.position, pa.rotation};
    if (i % 2)
      aligned.rotation = pa.rotation * from_axis_angle(random_direction(rng), std::pow(Real(10), rng.uniform(-8, -2)));
    aligned.position += rotate(pa.rotation, vec3(rng.uniform(-1, 1), rng.uniform(-1, 1), Real(1.2)));
    cache = {};
    ask(*a, pa, *b, aligned, cache, boxes);
    if (i % 10) continue;
    const ShapePtr hull = random_hull(rng, 12, 1);
    cache = {};
    ask(*a, pa, *hull, near_pose(rng, *a, *hull, pa, rng.uniform(Real(0.3), 3)), cache, mixed);
    cache = {};
    ask(*hull, pa, *b, near_pose(rng, *hull, *b, pa, rng.uniform(Real(0.3), 3)), cache, mixed);
  }
  for (int i = 0; i < 100000; ++i) {
    const auto outline = [&] {
      std::vector<Vec2> points;
      const int n = 3 + static_cast<int>(rng.next() % 14);
      for (int k = 0; k < n; ++k) {
        const Vec3 d = random_direction(rng, true);
        points.emplace_back(d[0], d[1] * Real(0.5));
      }
      const bool segment = i % 50 == 0;
      if (segment) points.resize(2);
      return make_polygon(points, segment || i % 3 == 0 ? Real(0.1) : Real(0));
    };
    ShapePtr a, b;
    try {
      a = outline(), b = outline();
    } catch (const SceneError&) {
      continue;  // three points in a line
    }
    const Pose pa{random_direction(rng, true), random_rotation(rng, true)};
    Pose pb{pa.position + random_direction(rng, true) * rng.uniform(0, 3), random_rotation(rng, true)};
    if (i % 5 == 0) pb.rotation = pa.rotation;
    PairCache cache;
    ask(*a, pa, *b, pb, cache, flat);
  }
  report("boxes", boxes), report("boxes and hulls", mixed), report("polygons", flat);
  for (const Tally& t : {boxes, mixed, flat}) {
    CHECK(t.error < kError);
    CHECK(t.overlaps > 100);
    CHECK(t.handed_on <= t.queries / 1000);
  }
}

TEST_CASE("marching takes at most three steps where poses turn by .01 rad", "[narrow][voronoi]") {
  if (!voronoi()) return;
  const int points = GENERATE(8, 16, 32, 64, 128, 256);
  Rng rng(73);
  Tally t;
  for (int i = 0; i < 20; ++i) {
    const ShapePtr a = random_hull(rng, points, 1), b = random_hull(rng, points, 1);
    Pose pa{random_direction(rng), random_rotation(rng)}, pb = near_pose(rng, *a, *b, pa, rng.uniform(Real(1.01), 2));
    const Vec3 axis = random_direction(rng), other = random_direction(rng);
    PairCache cache;
    CoreDistance first;
    REQUIRE(voronoi()->distance(*a, pa, *b, pb, cache, first));
    for (int k = 0; k < 500; ++k) {
      pa.rotation = normalized(from_axis_angle(axis, Real(0.01)) * pa.rotation);
      pb.rotation = normalized(from_axis_angle(other, Real(0.01)) * pb.rotation);
      ask(*a, pa, *b, pb, cache, t);
    }
  }
  report("coherent", t);
  CHECK(t.steps <= 3L * t.queries);
  CHECK(t.error < kError);
  CHECK(t.handed_on <= t.queries / 1000);
}

TEST_CASE("marching notices every overlap", "[narrow][voronoi]") {
  if (!voronoi()) return;
  Rng rng(74);
  int overlaps = 0, apart = 0, close = 0;
  for (int i = 0; i < 4000; ++i) {
    const ShapePtr a = random_hull(rng, 6 + i % 9, 1), b = random_hull(rng, 6 + i % 7, 1);
    const auto &ha = static_cast<const Hull&>(*a).data(), &hb = static_cast<const Hull&>(*b).data();
    const Pose pa{random_direction(rng), random_rotation(rng)};
    Pose pb = near_pose(rng, *a, *b, pa, rng.uniform(Real(0.5), Real(1.1)));
    // the largest gap over all axes that may separate: normals of both, and those across an edge of each
    const auto best_gap = [&] {
      std::vector<Vec3> axes, sides[2];
      const auto collect = [&](const HullData& h, const Quat& q, std::vector<Vec3>& edges) {
        for (const HullFace& f : h.faces) {
          axes.push_back(rotate(q, f.normal));
          for (int k = 0; k < f.count; ++k) edges.push_back(rotate(q, h.corner(f, (k + 1) % f.count) - h.corner(f, k)));
        }
      };
      collect(ha, pa.rotation, sides[0]), collect(hb, pb.rotation, sides[1]);
      for (const Vec3& u : sides[0])
        for (const Vec3& v : sides[1]) {
          const Vec3 n = cross(u, v);
          if (length(n) > Real(1e-3) * length(u) * length(v)) axes.push_back(n / length(n));
        }
      Real best = -kInfinity;
      for (const Vec3& n : axes) best = std::max({best, gap_along(*a, pa, *b, pb, n), gap_along(*a, pa, *b, pb, -n)});
      return best;
    };
    if (i % 2) {  // to where they nearly touch
      const ClosestResult c = closest_points(*a, pa, *b, pb);
      if (c.distance > 0) pb.position -= c.normal * (c.distance + rng.uniform(Real(-1e-4), Real(1e-4)));
    }
    const Real gap = best_gap();
    PairCache cache;
    CoreDistance d;
    REQUIRE(voronoi()->distance(*a, pa, *b, pb, cache, d));
    CAPTURE(i, gap, d.distance, d.steps);
    if (gap > Real(2e-6)) {
      CHECK_FALSE(d.overlap);
      ++apart;
    } else if (gap < Real(-2e-6)) {
      CHECK(d.overlap);
      ++overlaps;
    }
    close += std::abs(gap) < Real(1e-3);
  }
  CHECK(overlaps > 1000);
  CHECK(apart > 1000);
  CHECK(close > 500);
}

TEST_CASE("marching ends at degenerate input", "[narrow][voronoi]") {
  if (!voronoi()) return;
  Rng rng(75);
  std::vector<ShapePtr> shapes;
  const auto hull = [&](std::vector<Vec3> points) { shapes.push_back(make_hull(points)); };
  // faces of many coplanar triangles, with points on their edges and twice
  std::vector<Vec3> grid;
  for (int i = 0; i < 5; ++i)
    for (int k = 0; k < 5; ++k)
      for (int l = 0; l < 5; ++l)
        for (int twice = 0; twice < 2; ++twice) grid.push_back(vec3(Real(i), Real(k), Real(l)) / 4);
  hull(grid);
  // a sliver: a thousandth as thick as wide, and a needle
  hull({{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}, {0, Real(2e-3), 0}});
  hull({{0, 0, 0}, {1, 0, 0}, {Real(0.5), Real(1e-3), 0}, {Real(0.5), 0, Real(1e-3)}});
  // nearly coplanar corners, near the limit at which faces are merged
  for (const Real bump : {Real(1e-4), Real(3e-5), Real(1e-5), Real(3e-6)}) {
    std::vector<Vec3> cap;
    for (int i = 0; i < 40; ++i) {
      const Vec3 d = random_direction(rng, true);
      const Real r = std::sqrt(rng.unit() < 0.5 ? Real(1) : Real(rng.unit()));
      cap.push_back(vec3(r * d[0], bump * (1 - r * r), r * d[1]));
    }
    cap.push_back(vec3(0, -1, 0));
    hull(cap);
  }
  // a prism around its own axis, corners in rings
  std::vector<Vec3> prism;
  for (int k = 0; k < 64; ++k) {
    const Real c = std::cos(Real(k) * kPi / 32), s = std::sin(Real(k) * kPi / 32);
    prism.push_back(vec3(c, 1, s)), prism.push_back(vec3(c, -1, s));
  }
  hull(prism);
  shapes.push_back(make_box(1, Real(1e-3), 1)), shapes.push_back(make_box(Real(1e-3), Real(1e-3), Real(1e-3)));
  Tally t;
  for (const ShapePtr& a : shapes)
    for (const ShapePtr& b : shapes)
      for (int i = 0; i < 300; ++i) {
        const Pose pa{Vec3::Zero(), i % 3 ? random_rotation(rng) : Quat()};
        Pose pb = near_pose(rng, *a, *b, pa, rng.uniform(Real(0.8), 2));
        if (i % 3 == 0) pb.rotation = pa.rotation;  // faces and edges exactly parallel
        if (i % 9 == 0) pb.position = vec3(0, Real(i % 2 ? 1 : -1) * Real(1.5), 0);
        PairCache cache;
        const int before = t.handed_on;
        ask(*a, pa, *b, pb, cache, t);
        ask(*a, pa, *b, pb, cache, t);  // from its own answer
        CHECK(static_cast<int>(voronoi()->handed_on(cache)) == t.handed_on - before);
      }
  report("degenerate", t);
  CHECK(t.error < 1e-6);
  CHECK(t.repeats > 0);  // the way out is taken, and rarely
  CHECK(t.repeats <= t.queries / 100);
}

TEST_CASE("marching holds far from the origin and for sizes far apart", "[narrow][voronoi]") {
  if (!voronoi()) return;
  Rng rng(76);
  Tally t;
  for (int i = 0; i < 2000; ++i) {
    // the points of both far from their own frames, in opposite ways
    std::vector<Vec3> a, b;
    const Real far = i % 2 ? 1000 : 0, small = i % 3 ? 1 : Real(1e-3);
    for (int k = 0; k < 20; ++k) a.push_back(random_direction(rng) + vec3(far, 0, 0));
    for (int k = 0; k < 20; ++k) b.push_back(random_direction(rng) * small + vec3(0, far, 0));
    const ShapePtr ha = make_hull(a), hb = make_hull(b);
    const Pose pa{vec3(-far, 0, 0), {}}, pb{vec3(0, -far, 0) + random_direction(rng) * rng.uniform(1, 3), {}};
    PairCache cache;
    ask(*ha, pa, *hb, pb, cache, t);
  }
  report("far", t);
  CHECK(t.error < 1e-6);
  CHECK(t.handed_on <= t.queries / 100);
}

TEST_CASE("what a pair keeps changes the way, not the answer", "[narrow][voronoi]") {
  if (!voronoi()) return;
  Rng rng(77);
  Tally t;
  const Vec2 quad[4] = {{-1, -1}, {Real(1.5), -1}, {1, Real(0.5)}, {-1, 1}};
  const ShapePtr polygon = make_polygon(quad), box = make_box(1, 2, 3);
  for (int i = 0; i < 20000; ++i) {
    const bool planar = i % 4 == 0;
    const ShapePtr a = planar ? polygon : random_hull(rng, 10, 1), b = planar ? polygon : box;
    const Pose pa{random_direction(rng, planar), random_rotation(rng, planar)};
    Pose pb{pa.position + random_direction(rng, planar) * rng.uniform(1, 5), random_rotation(rng, planar)};
    PairCache any;
    any.word[0] = static_cast<std::uint32_t>(rng.next()) | 1u << 31,
    any.word[1] = static_cast<std::uint32_t>(rng.next());
    ask(*a, pa, *b, pb, any, t);
  }
  report("any start", t);
  CHECK(t.error < kError);
  CHECK(t.overlaps > 100);
}

TEST_CASE("a box and a hull of its corners have the same features", "[narrow][voronoi]") {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i) corners.push_back(vec3(i & 1 ? 1 : -1, i & 2 ? 2 : -2, i & 4 ? 3 : -3));
  const ShapePtr hull = make_hull(corners);
  const Features& f = static_cast<const Hull&>(*hull).features().view();
  CHECK(f.vertices.size() == 8);
  CHECK(f.edges.size() == 12);
  CHECK(f.faces.size() == 6);
  CHECK_FALSE(f.bent);
  for (std::size_t v = 0; v < 8; ++v) {
    REQUIRE(f.spokes_of(v).size() == 3);
    for (const EdgeUse use : f.spokes_of(v)) CHECK(length(f.vertices[v] - f.vertices[f.far_end(use)]) >= 2);
  }
  for (const FeatureFace& face : f.faces) {
    REQUIRE(f.loop(face).size() == 4);
    for (const EdgeUse use : f.loop(face)) {
      const FeatureEdge& e = f.edges[use >> 1];
      CHECK(&f.faces[use & 1 ? e.right : e.left] == &face);
      // the sides of a face turn to the left
      CHECK(dot(face.normal, f.vertices[e.tail]) == Approx(face.offset));
    }
  }
  // a hull whose faces do not close has none
  const std::vector<Double3> tetra = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<HullFace> faces = {{Vec3::Zero(), 0, 0, 3}, {Vec3::Zero(), 0, 3, 3}, {Vec3::Zero(), 0, 6, 3}};
  const std::vector<std::uint16_t> loops = {0, 2, 1, 0, 1, 3, 0, 3, 2};
  CHECK(FeatureGraph(tetra, faces, loops).view().vertices.empty());
  std::vector<HullFace> closed = faces;
  closed.push_back({Vec3::Zero(), 0, 9, 3});
  std::vector<std::uint16_t> all = loops;
  all.insert(all.end(), {1, 2, 3});
  CHECK(FeatureGraph(tetra, closed, all).view().edges.size() == 6);
}
