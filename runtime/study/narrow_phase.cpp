// Narrow phases on pairs of convex shapes that turn about their centres: the ladder varies by how much in a query, as
// what is kept between queries pays where that is little. err_end is the worst error of a distance (of a depth, where a
// method has one and cores overlap), by the size; err_constraint the share of pairs of which it is wrong whether they
// overlap (there must be none); force_evals are steps per pair: support points of GJK and EPA, feature pairs of
// marching; rejected counts pairs that went to GJK. The truth: all features against all. Source: Ericson, "Real-Time
// Collision Detection" (2005), 5.2.1 and 9. Does not show: contact points, the same patch for all.
#include "narrow/narrow_phase.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "base/rng.h"
#include "feder/error.h"
#include "geom/hull.h"
#include "geom/hull_features.h"
#include "geom/polygon.h"
#include "narrow/gjk.h"
#include "study/options.h"

namespace feder {
namespace {

constexpr int kQueries = 32;        // per pair
constexpr int kNarrowShapes = 16;   // that pairs are made of
constexpr double kTouching = 1e-6;  // of the size: nearer ones may be called either
constexpr double kBeyond = std::numeric_limits<double>::infinity();

// What a method says, or what is true: a distance, or the depth below 0.
struct Said {
  double gap = 0;
  bool overlap = false;
  bool has_depth = false;
};

double segments_apart(const Double3& p0, const Double3& p1, const Double3& q0, const Double3& q1) {
  const Double3 u = p1 - p0, v = q1 - q0, w = p0 - q0;
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), uw = dot(u, w), vw = dot(v, w);
  const auto unit = [](double x) { return std::min(std::max(x, 0.0), 1.0); };
  const double area = uu * vv - uv * uv;
  double best = kBeyond;
  const auto take = [&](double s, double t) { best = std::min(best, length(w + s * u - t * v)); };
  if (area > 1e-12 * uu * vv) {
    const double s = (uv * vw - vv * uw) / area, t = (uu * vw - uv * uw) / area;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) take(s, t);
  }
  // from each end to the other segment
  take(0, unit(vw / vv)), take(1, unit((uv + vw) / vv)), take(unit(-uw / uu), 0), take(unit((uv - uw) / uu), 1);
  return best;
}

// A polytope in the frame of the first one.
struct Placed {
  const Features& f;
  std::vector<Double3> corners, normals;
  std::vector<double> offsets;
  Placed(const Features& features, const ConvexPair* pair) : f(features) {
    for (const Double3& p : f.vertices) corners.push_back(pair ? pair->from_b(p) : p);
    for (const FeatureFace& face : f.faces) {
      normals.push_back(pair ? pair->from_b(face.normal) - pair->offset : face.normal);
      offsets.push_back(face.offset + (pair ? dot(normals.back(), pair->offset) : 0));
    }
  }
  const Double3& tail(EdgeUse use) const { return corners[use & 1 ? f.edges[use >> 1].head : f.edges[use >> 1].tail]; }
  const Double3& head(EdgeUse use) const { return corners[f.far_end(use)]; }
};

struct WidestGap {
  double gap = -kBeyond;
  Double3 axis{0, 0, 0};  // unit, from a to b
};

// The largest gap over all axes that can separate: normals of faces, and, where none of them does, of the faces that
// two edges have in common in the difference of both (their arcs on the sphere of normals cross: Gregorius, GDC 2013).
WidestGap widest_gap(const Placed& a, const Placed& b) {
  WidestGap best;
  const auto take = [&](double gap, const Double3& axis) {
    if (gap > best.gap) best = {gap, axis};
  };
  const auto faces = [&](const Placed& own, const Placed& other, double sign) {
    for (std::size_t k = 0; k < own.normals.size(); ++k) {
      double low = kBeyond;
      for (const Double3& p : other.corners) low = std::min(low, dot(own.normals[k], p));
      take(low - own.offsets[k], sign * own.normals[k]);
    }
  };
  faces(a, b, 1), faces(b, a, -1);
  if (best.gap > 0) return best;
  for (const FeatureEdge& e : a.f.edges) {
    const Double3 &n = a.normals[e.left], &m = a.normals[e.right], mn = cross(m, n), &p = a.corners[e.tail];
    for (const FeatureEdge& g : b.f.edges) {
      const Double3 c = -b.normals[g.left], d = -b.normals[g.right], dc = cross(d, c);
      const double first = dot(c, mn), second = dot(d, mn), third = dot(n, dc), fourth = dot(m, dc);
      if (!(first * second < 0 && third * fourth < 0 && first * fourth > 0)) continue;
      const Double3 axis = cross(a.corners[e.head] - p, b.corners[g.head] - b.corners[g.tail]);
      const double len = length(axis), sign = dot(axis, n + m) < 0 ? -1 : 1;  // outward of a
      if (len > 0) take(sign / len * dot(axis, b.corners[g.tail] - p), (sign / len) * axis);
    }
  }
  return best;
}

// Of all corners, edges and faces. An axis that separates says which edges are too far from all of the other one.
double nearest_features(const Placed& a, const Placed& b, const Double3& axis) {
  double best = kBeyond, end_of_a = -kBeyond, start_of_b = kBeyond;
  for (const Double3& p : a.corners)
    for (const Double3& q : b.corners) best = std::min(best, dot(q - p, q - p));
  best = std::sqrt(best);
  for (const Double3& p : a.corners) end_of_a = std::max(end_of_a, dot(axis, p));
  for (const Double3& p : b.corners) start_of_b = std::min(start_of_b, dot(axis, p));
  const auto corners_to_faces = [&](const Placed& own, const Placed& other) {
    for (std::size_t k = 0; k < own.normals.size(); ++k)
      for (const Double3& p : other.corners) {
        const double height = dot(own.normals[k], p) - own.offsets[k];
        if (!(height > 0 && height < best)) continue;
        bool over = true;
        for (const EdgeUse use : own.f.loop(own.f.faces[k]))
          over = over && dot(cross(own.normals[k], own.head(use) - own.tail(use)), p - own.tail(use)) >= 0;
        if (over) best = height;
      }
  };
  corners_to_faces(a, b), corners_to_faces(b, a);
  for (const FeatureEdge& e : a.f.edges) {
    const Double3 &p = a.corners[e.tail], &q = a.corners[e.head];
    if (start_of_b - std::max(dot(axis, p), dot(axis, q)) >= best) continue;
    for (const FeatureEdge& g : b.f.edges) {
      const Double3 &r = b.corners[g.tail], &s = b.corners[g.head];
      if (std::min(dot(axis, r), dot(axis, s)) - end_of_a < best) best = std::min(best, segments_apart(p, q, r, s));
    }
  }
  return best;
}

// The same shape, with its support points counted.
class CountedShape final : public Shape {
 public:
  explicit CountedShape(const Shape& of) : Shape(of.kind_id(), true, of.radius()), of_(of) {}
  Aabb bounds(const Pose& pose) const override { return of_.bounds(pose); }
  MassProperties mass(Real density) const override { return of_.mass(density); }
  Real extent(const Vec3& center) const override { return of_.extent(center); }
  bool raycast(const Vec3& origin, const Vec3& ray, RayHit& hit) const override {
    return of_.raycast(origin, ray, hit);
  }
  Real distance(const Vec3& p, Real limit, Vec3& normal) const override { return of_.distance(p, limit, normal); }
  Vec3 support(const Vec3& d) const override { return ++supports, of_.support(d); }
  int face(const Vec3& d, Vec3* points) const override { return of_.face(d, points); }
  mutable std::int64_t supports = 0;

 private:
  const Shape& of_;
};

class NarrowPhaseProblem final : public StudyProblem {
 public:
  explicit NarrowPhaseProblem(const Params& given) {
    ProblemOptions o(given, info_);
    shape_ = static_cast<Made>(o.choice("shape", "hull", {"hull", "box", "polygon"}, "sat: boxes; epa: not polygons"));
    const int vertices = o.integer("vertices", 32, 4, kMaxHullCorners, "of a hull, or a polygon, which has at most 32");
    if (shape_ == Made::polygon && vertices > kMaxFacePoints)
      throw SceneError("vertices: expected at most " + std::to_string(kMaxFacePoints) + " of a polygon, got " +
                       std::to_string(vertices));
    const int pairs = o.integer("pairs", 100, 1, 100000, "of shapes, each of size 1 at most");
    const double distance = o.number("distance", 0.1, 0, 1000, "between them, by the size");
    const double overlapping = o.number("overlapping", 0.2, 0, 1, "share of pairs that begin in each other");
    info_.family = "collision", info_.own_measure = true, info_.dense = false;
    info_.t_end = 1, info_.dof = 3 * pairs, info_.x_scale = 1 + distance, info_.v_scale = 1;
    Rng rng(43);
    for (int i = 0; i < kNarrowShapes; ++i) make_one(rng, vertices);
    for (int i = 0; i < pairs; ++i) {
      Pair p;
      p.a = rng.next() % shapes_.size(), p.b = rng.next() % shapes_.size();
      p.axis_a = axis(rng), p.axis_b = axis(rng), p.start_a = turn(rng), p.start_b = turn(rng);
      const Vec3 d = direction(rng);
      const Shape &a = *shapes_[p.a], &b = *shapes_[p.b];
      const Real wide = dot(d, rotate(p.start_a, a.support(rotate_inverse(p.start_a, d)))) -
                        dot(d, rotate(p.start_b, b.support(rotate_inverse(p.start_b, -d))));
      const bool inside = rng.unit() < overlapping;
      p.at = d * (inside ? Real(0.8) * wide : wide + static_cast<Real>(distance));
      pairs_.push_back(p);
    }
    set_reference(ReferenceKind::quad, 15, 1e-7, "all features of one against all of the other");
    info_.reference.resolution = 0.05;  // the test of boxes prefers faces to axes of a little less depth
  }

  std::vector<MethodInfo> methods() const override {
    std::vector<MethodInfo> all;
    if (shape_ == Made::box) all.push_back({"sat", "separating axes of two boxes: overlap and depth"});
    all.push_back({"gjk", "distance by support points, from the last normal"});
    if (shape_ != Made::polygon) all.push_back({"epa", "gjk, then the depth of overlaps"});
    for (const NarrowMethod& m : narrow_methods()) all.push_back({m.name, m.summary});
    return all;
  }
  std::vector<RunSpec> ladder(const MethodInfo& method) const override {
    std::vector<RunSpec> all;
    for (const char* turn : {"1", "0.1", "0.01", "0.001"}) {
      RunSpec spec;
      spec.method = method.name, spec.steps = kQueries, spec.settings = {{"turn", turn}};
      all.push_back(spec);
    }
    return all;
  }
  void reference(double, Observation& out) const override {  // where the second ones are
    out = {};
    for (const Pair& p : pairs_)
      for (int k = 0; k < 3; ++k) out.x.push_back(static_cast<double>(p.at[k])), out.v.push_back(0);
  }
  std::unique_ptr<StudyRun> start(const RunSpec& spec) const override;

  struct Pair {
    std::size_t a = 0, b = 0;  // in shapes()
    Vec3 axis_a, axis_b, at;
    Quat start_a, start_b;
  };
  std::span<const Pair> pairs() const { return pairs_; }
  bool flat() const { return shape_ == Made::polygon; }
  const std::vector<ShapePtr>& shapes() const { return shapes_; }
  void place(const Pair& p, double turn, int step, Pose& a, Pose& b) const {
    const Real angle = static_cast<Real>(turn * step);
    a = {Vec3::Zero(), from_axis_angle(p.axis_a, angle) * p.start_a};
    b = {p.at, from_axis_angle(p.axis_b, angle) * p.start_b};
  }
  const std::vector<double>& truth(double turn, int step) const {
    for (const Known& k : known_)
      if (k.turn == turn && k.step == step) return k.gaps;
    std::vector<double> gaps;
    for (const Pair& p : pairs_) {
      Pose pose_a, pose_b;
      place(p, turn, step, pose_a, pose_b);
      gaps.push_back(shape_ == Made::polygon ? flat_gap(p, pose_a, pose_b) : solid_gap(p, pose_a, pose_b));
    }
    return known_.emplace_back(Known{turn, step, std::move(gaps)}).gaps;
  }
  double size(const Pair& p) const {
    return static_cast<double>(std::max(shapes_[p.a]->extent(Vec3::Zero()), shapes_[p.b]->extent(Vec3::Zero())));
  }

 private:
  struct Known {
    double turn;
    int step;
    std::vector<double> gaps;
  };
  enum class Made : std::uint8_t { hull, box, polygon };
  Vec3 direction(Rng& rng) const {
    for (;;) {
      const Real z = shape_ == Made::polygon ? Real(0) : rng.uniform(-1, 1), y = rng.uniform(-1, 1),
                 x = rng.uniform(-1, 1);
      const Vec3 v(x, y, z);
      if (dot(v, v) > Real(0.01) && dot(v, v) <= 1) return v / length(v);
    }
  }
  Vec3 axis(Rng& rng) const { return shape_ == Made::polygon ? Vec3(0, 0, 1) : direction(rng); }
  Quat turn(Rng& rng) const {
    const Vec3 about = axis(rng);
    return from_axis_angle(about, rng.uniform(-kPi, kPi));
  }
  double solid_gap(const Pair& p, const Pose& pose_a, const Pose& pose_b) const {
    const Convex first(*shapes_[p.a]), second(*shapes_[p.b]);
    const ConvexPair pair(first, pose_a, second, pose_b);
    const Placed a(features(p.a), nullptr), b(features(p.b), &pair);
    const WidestGap widest = widest_gap(a, b);
    return widest.gap > 0 ? nearest_features(a, b, widest.axis) : widest.gap;
  }
  // Separating axes of all edges; apart, each corner to each edge.
  double flat_gap(const Pair& p, const Pose& pose_a, const Pose& pose_b) const {
    const Convex first(*shapes_[p.a]), second(*shapes_[p.b]);
    const ConvexPair pair(first, pose_a, second, pose_b);
    std::vector<Double3> outline[2];
    for (const Vec2& q : static_cast<const Polygon&>(*shapes_[p.a]).points())
      outline[0].push_back({double(q[0]), double(q[1]), 0});
    for (const Vec2& q : static_cast<const Polygon&>(*shapes_[p.b]).points())
      outline[1].push_back(pair.from_b({double(q[0]), double(q[1]), 0}));
    double widest = -kBeyond, nearest = kBeyond;
    for (std::size_t s = 0; s < 2; ++s)
      for (std::size_t i = 0; i < outline[s].size(); ++i) {
        const Double3 &tail = outline[s][i], d = outline[s][(i + 1) % outline[s].size()] - tail;
        const double len = length(d);
        double low = kBeyond;
        for (const Double3& q : outline[1 - s]) {
          const double along = std::min(std::max(dot(q - tail, d) / (len * len), 0.0), 1.0);
          nearest = std::min(nearest, length(q - tail - along * d));
          low = std::min(low, (d.y * (q.x - tail.x) - d.x * (q.y - tail.y)) / len);
        }
        widest = std::max(widest, low);
      }
    return widest > 0 ? nearest : widest;
  }
  const Features& features(std::size_t shape) const {
    return static_cast<const Hull&>(*hulls_[shape]).features().view();
  }
  // A box has the features of the hull of its corners.
  void make_one(Rng& rng, int vertices) {
    std::vector<Vec3> points;
    if (shape_ == Made::polygon) {
      std::vector<Vec2> outline;
      for (int k = 0; k < vertices; ++k) outline.push_back(direction(rng).head<2>() / 2);
      return shapes_.push_back(make_polygon(outline));
    }
    if (shape_ == Made::box) {
      const Real z = rng.uniform(Real(0.2), 1), y = rng.uniform(Real(0.2), 1), x = rng.uniform(Real(0.2), 1);
      shapes_.push_back(make_box(x, y, z));
      for (int k = 0; k < 8; ++k) points.emplace_back((k & 1 ? x : -x) / 2, (k & 2 ? y : -y) / 2, (k & 4 ? z : -z) / 2);
    }
    // merged faces that are not flat have no one distance to be right about
    for (int tries = 0; tries < 10000 && points.empty(); ++tries) {
      for (int k = 0; k < vertices; ++k) points.push_back(direction(rng) / 2);
      if (static_cast<const Hull&>(*make_hull(points)).features().view().bent) points.clear();
    }
    if (points.empty())
      throw SceneError("vertices: found no hull of " + std::to_string(vertices) + " with flat faces; try fewer");
    hulls_.push_back(make_hull(points));
    if (shape_ == Made::hull) shapes_.push_back(hulls_.back());
  }

  Made shape_ = Made::hull;
  std::vector<ShapePtr> shapes_;
  std::vector<ShapePtr> hulls_;  // whose features are theirs
  std::vector<Pair> pairs_;
  mutable std::vector<Known> known_;
};

class NarrowPhaseRun final : public StudyRun {
 public:
  NarrowPhaseRun(const NarrowPhaseProblem& problem, const RunSpec& spec)
      : problem_(problem), method_(spec.method), h_(problem.info().t_end / spec.steps) {
    for (const auto& [name, value] : spec.settings)
      if (name == "turn") std::from_chars(value.data(), value.data() + value.size(), turn_);
    for (const NarrowMethod& m : narrow_methods())
      if (method_ == m.name) marching_ = &m;
    for (const ShapePtr& s : problem.shapes()) {
      counted_.push_back(std::make_unique<CountedShape>(*s));
      if (!marching_) continue;
      marching_->prepare(*s), kept_ += marching_->bytes(*s);
    }
    const std::size_t n = problem.pairs().size();
    caches_.resize(n), normals_.resize(n);
    for (std::size_t i = 0; i < n; ++i) normals_[i] = wide(problem.pairs()[i].at);
    // all poses and answers now, so that no step has to make them
    places_.resize(n * (static_cast<std::size_t>(spec.steps) + 1)), said_.resize(places_.size());
    for (int k = 0; k <= spec.steps; ++k)
      for (std::size_t i = 0; i < n; ++i) {
        auto& [a, b] = places_[static_cast<std::size_t>(k) * n + i];
        problem.place(problem.pairs()[i], turn_, k, a, b);
      }
    query(0);
    asked_ = 0, count_ = {};
  }
  void step() override {
    ++count_.steps;
    query(static_cast<std::size_t>(count_.steps));
    count_.force_evals = asked_ / static_cast<std::int64_t>(caches_.size());
  }
  void observe(Observation& out) override { problem_.reference(h_ * static_cast<double>(count_.steps), out); }
  Invariants invariants() override {
    Invariants i;
    if (count_.steps == 0) return i;
    const std::vector<double>& truth = problem_.truth(turn_, static_cast<int>(count_.steps));
    int wrong = 0;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      const bool clear = std::fabs(truth[k]) > kTouching * problem_.size(problem_.pairs()[k]);
      wrong += clear && at(static_cast<int>(count_.steps), k).overlap != (truth[k] < 0);
    }
    i.constraint = static_cast<double>(wrong) / static_cast<double>(truth.size());
    return i;
  }
  StudyCounters counters() const override { return count_; }
  std::size_t bytes() const override {
    return kept_ + caches_.size() * (marching_ || method_ == "sat" ? sizeof(PairCache) : sizeof(Double3));
  }
  bool measures_itself() const override { return true; }
  double own_error() const override {
    double worst = 0;
    for (int s = 1; s <= static_cast<int>(count_.steps); ++s) {
      const std::vector<double>& truth = problem_.truth(turn_, s);
      for (std::size_t k = 0; k < truth.size(); ++k) {
        const Said& said = at(s, k);
        const bool measured = said.overlap ? said.has_depth && truth[k] < 0 : method_ != "sat" && truth[k] > 0;
        if (measured) worst = std::max(worst, std::fabs(said.gap - truth[k]) / problem_.size(problem_.pairs()[k]));
      }
    }
    return worst;
  }

 private:
  const Said& at(int step, std::size_t pair) const {
    return said_[static_cast<std::size_t>(step) * caches_.size() + pair];
  }
  void query(std::size_t step) {
    const std::size_t n = caches_.size();
    for (std::size_t i = 0; i < n; ++i) {
      const NarrowPhaseProblem::Pair& p = problem_.pairs()[i];
      const auto& [pose_a, pose_b] = places_[step * n + i];
      const Shape &a = *problem_.shapes()[p.a], &b = *problem_.shapes()[p.b];
      Said& said = said_[step * n + i];
      if (marching_)
        march(a, pose_a, b, pose_b, caches_[i], said);
      else if (method_ == "sat")
        axes(a, pose_a, b, pose_b, caches_[i], said);
      else
        supports(p, pose_a, pose_b, normals_[i], said);
    }
  }
  void march(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, PairCache& cache, Said& said) {
    CoreDistance d;
    marching_->distance(a, pose_a, b, pose_b, cache, d);
    said = {d.distance, d.overlap, false};
    asked_ += d.steps, count_.rejected += d.handed_on;
  }
  void axes(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, PairCache& cache, Said& said) {
    Manifold found[kMaxManifolds];
    const int count = by_axes_.collide(a, pose_a, b, pose_b, 0, cache, found);
    Real deepest = kInfinity;
    for (int k = 0; k < count; ++k)
      for (int l = 0; l < found[k].count; ++l) deepest = std::min(deepest, found[k].points[l].separation);
    said = {static_cast<double>(deepest), count > 0 && deepest <= 0, true};
    ++asked_;
  }
  void supports(const NarrowPhaseProblem::Pair& p, const Pose& pose_a, const Pose& pose_b, Double3& normal,
                Said& said) {
    const CountedShape &a = *counted_[p.a], &b = *counted_[p.b];
    const std::int64_t before = a.supports;
    ConvexPair pair(Convex(a), pose_a, Convex(b), pose_b);
    if (problem_.flat()) pair.offset.z = 0;
    Gap gap;
    Simplex simplex;
    const bool apart = gjk_distance(pair, -normal, kBeyond, simplex, gap);
    if (!apart && method_ == "epa") gap = epa_depth(pair, simplex);
    if (apart || method_ == "epa") normal = gap.normal;
    said = {gap.distance, !apart, method_ == "epa"};
    asked_ += (a.supports - before) / (p.a == p.b ? 2 : 1);
  }

  const NarrowPhaseProblem& problem_;
  const std::string method_;
  double h_, turn_ = 0;
  const NarrowMethod* marching_ = nullptr;
  const NarrowPhase by_axes_{"auto"};
  std::vector<std::unique_ptr<CountedShape>> counted_;
  std::vector<PairCache> caches_;
  std::vector<Double3> normals_;  // that gjk starts from
  std::vector<std::pair<Pose, Pose>> places_;
  std::vector<Said> said_;
  std::size_t kept_ = 0;
  std::int64_t asked_ = 0;
  StudyCounters count_;
};

std::unique_ptr<StudyRun> NarrowPhaseProblem::start(const RunSpec& spec) const {
  return std::make_unique<NarrowPhaseRun>(*this, spec);
}

}  // namespace

Variant<StudyProblem> study_narrow_phase() {
  return variant_of<StudyProblem, NarrowPhaseProblem>("narrow_phase", "convex pairs that turn, by every narrow phase");
}

}  // namespace feder
