// Voronoi marching against GJK, separating planes and closed forms; steps of poses that turn; input at its limits.
#include <algorithm>

#include "base/rng.h"
#include "geom/features.h"
#include "geom/hull.h"
#include "narrow/narrow_phase.h"
#include "poses.h"
#include "support/catch.h"

using namespace feder;

namespace {

constexpr bool kDouble = sizeof(Real) == 8;

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
  int queries = 0, handed_on = 0, overlaps = 0, most = 0;
  long steps = 0;
  double error = 0;  // of the distance, by the size
  int wrong = 0;     // one of both says overlap, the other a distance above 1e-6 of the size
};

double size_of(const Shape& a, const Shape& b) { return std::max(a.extent(Vec3::Zero()), b.extent(Vec3::Zero())); }

void ask(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, PairCache& cache, Tally& tally) {
  CoreDistance d;
  REQUIRE(voronoi()->distance(a, pa, b, pb, cache, d));
  const ClosestResult truth = closest_points(a, pa, b, pb);
  const double size = size_of(a, b), mine = d.overlap ? 0 : d.distance - double(a.radius() + b.radius());
  ++tally.queries, tally.steps += d.steps, tally.handed_on += d.handed_on, tally.overlaps += d.overlap;
  tally.most = std::max(tally.most, d.steps);
  const double error = std::abs(std::max(mine, 0.0) - double(truth.distance)) / size;
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
                     << t.handed_on);
  std::printf("%s: %d queries, error %.2e, %d overlaps, mean steps %.3f, most %d, handed on %d, wrong %d\n", what,
              t.queries, t.error, t.overlaps, double(t.steps) / t.queries, t.most, t.handed_on, t.wrong);
}

}  // namespace

TEST_CASE("marching finds the distance of 100000 pairs of hulls", "[narrow][voronoi]") {
  Rng rng(71);
  std::vector<ShapePtr> hulls;
  for (int i = 0; i < 200; ++i) hulls.push_back(random_hull(rng, 4 + static_cast<int>(rng.next() % 60), 1));
  Tally t;
  int bent = 0;
  for (const ShapePtr& h : hulls) bent += static_cast<const Hull&>(*h).features().view().bent;
  for (int i = 0; i < 100000; ++i) {
    const Shape &a = *hulls[rng.next() % hulls.size()], &b = *hulls[rng.next() % hulls.size()];
    const Pose pa{random_direction(rng), random_rotation(rng)};
    PairCache cache;
    ask(a, pa, b, near_pose(rng, a, b, pa, rng.uniform(Real(0.3), 3)), cache, t);
  }
  std::printf("bent %d\n", bent);
  report("hulls", t);
}
