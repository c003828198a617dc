// The narrow phase "voronoi": boxes and hulls, and polygons in the plane, by marching (march.cpp). Between calls a pair
// keeps its closest features, from which the next march starts, the last normal, coarsely, and how often it was handed
// on. Overlap has no closest features: GJK and EPA (in the plane, separating axes) give its depth; a march that comes
// to a pair twice goes to GJK. Then the patch where two faces look at each other, as for all convex shapes. Sources:
// Mirtich 1998, Lin & Canny 1991. Weak spot: shapes in contact overlap a little, and pay for both.
#include <typeinfo>

#include "geom/box.h"
#include "geom/hull.h"
#include "geom/polygon.h"
#include "narrow/march.h"
#include "narrow/narrow_phase.h"
#include "narrow/patch.h"
#include "narrow/polygon_axes.h"

namespace feder {
namespace {

// --- what a pair keeps: word[0] = valid | handed on (7 bits) | features (24), word[1] = valid | normal (3 x 10).

constexpr std::uint32_t kKnown = 1u << 31, kNormalKnown = 1u << 30, kFeatureBits = 0xffffff, kHandedOn = 0x7f;
constexpr double kNormalSteps = 1023;

// Other tests of the pairs of a world set the highest bit of word[1], or none.
std::uint32_t handed_on(const PairCache& cache) {
  const bool own = cache.word[0] & kKnown && cache.word[1] >> 30 == 1;
  return own ? cache.word[0] >> 24 & kHandedOn : 0;
}

void keep(const March& m, const Double3& normal, PairCache& cache) {
  const bool gave_up = m.end == MarchEnd::repeat || m.end == MarchEnd::bent;
  const std::uint32_t count = std::min(handed_on(cache) + (gave_up ? 1u : 0u), kHandedOn);
  cache.word[0] = kKnown | count << 24 | (m.features.packed() & kFeatureBits);
  const auto bits = [](double x) { return static_cast<std::uint32_t>((x + 1) * 0.5 * kNormalSteps + 0.5) & 0x3ff; };
  cache.word[1] = kNormalKnown | bits(normal.x) | bits(normal.y) << 10 | bits(normal.z) << 20;
}

// A direction from b to a.
Double3 kept_start(const PairCache& cache, const ConvexPair& pair) {
  if (!(cache.word[1] & kNormalKnown)) return -pair.offset;
  const auto value = [&](int shift) { return 1 - 2 * double(cache.word[1] >> shift & 0x3ff) / kNormalSteps; };
  return {value(0), value(10), value(20)};
}

// --- the features of a shape

// Those of a box are those of a cube, but for its corners and planes.
const FeatureGraph& cube_features() {
  static const FeatureGraph graph = [] {
    std::vector<Double3> corners;
    corners.reserve(8);
    for (int i = 0; i < 8; ++i) corners.push_back({i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0});
    std::vector<HullFace> faces;
    for (std::uint16_t k = 0; k < 6; ++k) faces.push_back({Vec3::Zero(), 0, static_cast<std::uint16_t>(4 * k), 4});
    const std::uint16_t loops[24] = {0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6};
    return FeatureGraph(std::move(corners), faces, loops);
  }();
  return graph;
}

class ShapeFeatures {
 public:
  explicit ShapeFeatures(const Shape& shape) {
    if (typeid(shape) == typeid(Hull))
      all_ = static_cast<const Hull&>(shape).features().view();
    else if (typeid(shape) == typeid(Box))
      set_box(static_cast<const Box&>(shape).half());
  }
  const Features& all() const { return all_; }
  bool known() const { return !all_.vertices.empty(); }

 private:
  void set_box(const Vec3& half) {
    const Double3 h = wide(half);
    for (int i = 0; i < 8; ++i) corners_[i] = {i & 1 ? h.x : -h.x, i & 2 ? h.y : -h.y, i & 4 ? h.z : -h.z};
    all_ = cube_features().view();
    for (std::size_t k = 0; k < 6; ++k) faces_[k] = all_.faces[k], faces_[k].offset = k < 2 ? h.x : (k < 4 ? h.y : h.z);
    all_.vertices = corners_, all_.faces = faces_;
    all_.reach = std::max({h.x, h.y, h.z}), all_.size = 2 * length(h);
  }
  Features all_;
  Double3 corners_[8];
  FeatureFace faces_[6];
};

March march_from(const ConvexPair& pair, const ShapeFeatures& a, const ShapeFeatures& b, const PairCache& cache) {
  if (!a.known() || !b.known()) return {};
  FeaturePair start = FeaturePair::unpacked(cache.word[0]);
  if (!(cache.word[0] & kKnown) || !within(a.all(), start.a) || !within(b.all(), start.b))
    start = first_features(pair, a.all(), b.all());
  return march(pair, a.all(), b.all(), start);
}

March march_from(const ConvexPair& pair, const Polygon& a, const Polygon& b, const PairCache& cache) {
  FeaturePair start = FeaturePair::unpacked(cache.word[0]);
  if (!(cache.word[0] & kKnown) || !within(a, start.a) || !within(b, start.b))
    start = {{Feature::vertex, 0}, {Feature::vertex, 0}};
  return march(pair, a, b, start);
}

// --- the tests

int solids(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache& cache,
           Manifold* out) {
  const ConvexPair pair(Convex(a), pose_a, Convex(b), pose_b);
  const double enough = double(margin) + a.radius() + b.radius();
  const March m = march_from(pair, ShapeFeatures(a), ShapeFeatures(b), cache);
  Gap gap = m.gap;
  const bool near =
      m.end == MarchEnd::apart ? gap.distance <= enough : core_gap(pair, kept_start(cache, pair), enough, gap);
  keep(m, gap.normal, cache);
  return near ? gap_manifold(pair, gap, margin, pose_a, *out) : 0;
}

int outlines(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache& cache,
             Manifold* out) {
  const auto &pa = static_cast<const Polygon&>(a), &pb = static_cast<const Polygon&>(b);
  ConvexPair pair(Convex(a), pose_a, Convex(b), pose_b);
  pair.offset.z = 0;
  const double enough = double(margin) + a.radius() + b.radius();
  const March m = march_from(pair, pa, pb, cache);
  Gap gap = m.gap;
  Simplex simplex;
  const auto gjk = [&] { return gjk_distance(pair, -pair.offset, enough, simplex, gap); };
  if (m.end == MarchEnd::overlap || (m.end == MarchEnd::repeat && !gjk())) gap = polygon_overlap(pair, pa, pb);
  keep(m, gap.normal, cache);
  return gap.distance <= enough ? gap_manifold(pair, gap, margin, pose_a, *out) : 0;
}

bool core_distance(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, PairCache& cache,
                   CoreDistance& out) {
  ConvexPair pair(Convex(a), pose_a, Convex(b), pose_b);
  March m;
  if (typeid(a) == typeid(Polygon) && typeid(b) == typeid(Polygon)) {
    pair.offset.z = 0;
    m = march_from(pair, static_cast<const Polygon&>(a), static_cast<const Polygon&>(b), cache);
  } else {
    const ShapeFeatures fa(a), fb(b);
    if (!fa.known() || !fb.known()) return false;
    m = march_from(pair, fa, fb, cache);
  }
  const bool repeat = m.end == MarchEnd::repeat;
  out = {m.end == MarchEnd::overlap, m.gap.distance, m.steps, repeat, repeat || m.end == MarchEnd::bent};
  if (out.handed_on) {
    Simplex simplex;
    out.overlap = !gjk_distance(pair, -pair.offset, std::numeric_limits<double>::infinity(), simplex, m.gap);
    out.distance = m.gap.distance;
  }
  keep(m, m.gap.normal, cache);
  return true;
}

void prepare(const Shape& shape) {
  if (typeid(shape) == typeid(Hull)) static_cast<const Hull&>(shape).features();
  if (typeid(shape) == typeid(Box)) cube_features();
}

std::size_t bytes(const Shape& shape) {
  return typeid(shape) == typeid(Hull) ? static_cast<const Hull&>(shape).features().bytes() : 0;
}

}  // namespace

NarrowMethod narrow_voronoi() {
  return {"voronoi",
          "marching through Voronoi regions: boxes, hulls, polygons",
          {{"box", "box", solids}, {"box", "hull", solids}, {"hull", "hull", solids}, {"polygon", "polygon", outlines}},
          prepare,
          core_distance,
          bytes,
          handed_on};
}

}  // namespace feder
