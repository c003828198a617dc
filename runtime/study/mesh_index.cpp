// Indices of meshes: boxes that drift along the surface, and a ray down through each. err_end is the share of triangles
// that come up and do not meet the box, err_constraint the share of those missed; force_evals are triangles that came
// up, per query. The truth: all triangles, by separating axes (Akenine-Moeller 2001), in double. Source: Ericson,
// "Real-Time Collision Detection" (2005), 6 and 7. Does not show: contacts, which are the same with any.
#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/double3.h"
#include "base/rng.h"
#include "bounds/volume.h"
#include "feder/shape.h"
#include "study/options.h"

namespace feder {
namespace {

constexpr int kQuerySteps = 16;

bool meet(const Triangle& t, const Aabb& box) {
  Aabb own{t.a, t.a};
  own.include(t.b), own.include(t.c);
  if (!overlaps(own, box)) return false;
  const Double3 lo = wide(box.lo), hi = wide(box.hi), middle = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
  const Double3 p[3] = {wide(t.a) - middle, wide(t.b) - middle, wide(t.c) - middle};
  const auto apart = [&](const Double3& axis) {
    const double a = dot(axis, p[0]), b = dot(axis, p[1]), c = dot(axis, p[2]);
    const double r = std::abs(axis.x) * half.x + std::abs(axis.y) * half.y + std::abs(axis.z) * half.z;
    return std::min({a, b, c}) > r || std::max({a, b, c}) < -r;
  };
  if (apart(cross(p[1] - p[0], p[2] - p[0]))) return false;
  for (int k = 0; k < 3; ++k)
    for (const Double3& side : {Double3{1, 0, 0}, Double3{0, 1, 0}, Double3{0, 0, 1}})
      if (apart(cross(side, p[(k + 1) % 3] - p[k]))) return false;
  return true;
}

class MeshIndexProblem final : public StudyProblem {
 public:
  explicit MeshIndexProblem(const Params& given) {
    ProblemOptions o(given, info_);
    const std::size_t kind =
        o.choice("mesh", "terrain", {"terrain", "helix", "soup"}, "an even ground, a ribbon askew, many sizes");
    const int triangles = o.integer("triangles", 5000, 2, 400000, "about");
    const int queries = o.integer("queries", 100, 1, 100000, "boxes and rays");
    size_ = static_cast<Real>(o.number("size", 0.2, 1e-4, 10, "of a box, m"));
    info_.family = "collision", info_.own_measure = true, info_.dense = false;
    info_.t_end = 1, info_.dof = 3 * queries, info_.x_scale = 10, info_.v_scale = 1;
    make_mesh_of(kind, triangles);
    Rng rng(21);
    for (int k = 0; k < queries; ++k) {
      at_.push_back(points_[rng.next() % points_.size()]);
      const Real z = rng.uniform(-1, 1), y = rng.uniform(Real(-0.1), Real(0.1)), x = rng.uniform(-1, 1);
      velocity_.emplace_back(x, y, z);
    }
    set_reference(ReferenceKind::quad, 15, 1e-7, "separating axes of every triangle and every box");
    info_.reference.resolution = 0.05;  // boxes of triangles and flat volumes meet a little more than those
  }

  std::vector<MethodInfo> methods() const override {
    std::vector<MethodInfo> all{{"boxes", "hierarchy of boxes, made for contacts: the default"}};
    const auto words = [](const std::string& list, auto&& f) {
      for (std::size_t from = 0, to = 0; from < list.size(); from = to + 2) {
        to = std::min(list.find(", ", from), list.size());
        f(list.substr(from, to - from));
      }
    };
    words(mesh_index_names(), [&](const std::string& index) {
      if (index != "bvh") all.push_back({index, "index = \"" + index + "\""});
    });
    for (const VolumeKind& volume : bounding_volumes())
      for (const TreeBuild& build : tree_builds())
        if (volume.name != std::string("hull"))
          all.push_back({std::string(volume.name) + "." + build.name, "index = \"bvh\", of that volume and build"});
    return all;
  }
  std::vector<RunSpec> ladder(const MethodInfo& method) const override {
    std::vector<RunSpec> all;
    for (const char* leaf : {"8", "4", "1"}) {
      RunSpec spec;
      spec.method = method.name, spec.steps = kQuerySteps, spec.settings = {{"leaf", leaf}};
      if (method.name != "boxes" || all.empty()) all.push_back(spec);
    }
    return all;
  }
  void reference(double t, Observation& out) const override {
    out = {};
    for (std::size_t i = 0; i < at_.size(); ++i)
      for (int k = 0; k < 3; ++k)
        out.x.push_back(static_cast<double>(at_[i][k]) + t * static_cast<double>(velocity_[i][k])),
            out.v.push_back(static_cast<double>(velocity_[i][k]));
  }
  std::unique_ptr<StudyRun> start(const RunSpec& spec) const override;

  Aabb box(std::size_t i, double t) const {
    const Vec3 p = at_[i] + static_cast<Real>(t) * velocity_[i], half = Vec3::Constant(size_ / 2);
    return {p - half, p + half};
  }
  std::size_t queries() const { return at_.size(); }
  // Triangles (in the order of a mesh's storage, which is that of any index) that meet each box at time t.
  const std::vector<std::vector<std::uint32_t>>& truth(const Shape& mesh, double t) const {
    for (const auto& [time, lists] : known_)
      if (time == t) return lists;
    std::vector<std::vector<std::uint32_t>> out(queries());
    for (std::size_t q = 0; q < queries(); ++q)
      for (std::uint32_t i = 0; i < triangles_.size() / 3; ++i)
        if (meet(mesh.triangle(i), box(q, t))) out[q].push_back(i);
    return known_.emplace_back(t, std::move(out)).second;
  }

 private:
  void add(const Vec3& a, const Vec3& b, const Vec3& c) {
    for (const Vec3& p : {a, b, c})
      triangles_.push_back(static_cast<std::uint32_t>(points_.size())), points_.push_back(p);
  }
  void make_mesh_of(std::size_t kind, int triangles) {
    Rng rng(4);
    if (kind == 0) {
      const int side = std::max(1, static_cast<int>(std::sqrt(triangles / 2.0)));
      const auto at = [&](int i, int k) {
        const Real x = Real(10) * Real(i) / Real(side), z = Real(10) * Real(k) / Real(side);
        return Vec3(x, Real(0.4) * std::sin(2 * x) * std::cos(3 * z), z);
      };
      for (int i = 0; i < side; ++i)
        for (int k = 0; k < side; ++k)
          add(at(i, k), at(i, k + 1), at(i + 1, k)), add(at(i + 1, k), at(i, k + 1), at(i + 1, k + 1));
    }
    if (kind == 1) {
      const auto edge = [&](int k, bool outer) {
        const double t = k * 126.0 / triangles, r = outer ? 5 : 4;
        return Vec3(static_cast<Real>(r * std::cos(t)), static_cast<Real>(0.12 * t + (outer ? 0.8 : 0)),
                    static_cast<Real>(r * std::sin(t)));
      };
      for (int k = 0; 2 * k < triangles; ++k)
        add(edge(k, false), edge(k, true), edge(k + 1, false)),
            add(edge(k, true), edge(k + 1, true), edge(k + 1, false));
    }
    if (kind == 2)
      for (int i = 0; i < triangles; ++i) {
        const auto any = [&](Real s) {  // arguments of a call come in any order
          const Real z = rng.uniform(-s, s), y = rng.uniform(-s, s), x = rng.uniform(-s, s);
          return Vec3(x, y, z);
        };
        const Real size = static_cast<Real>(std::pow(10.0, -2 + 2.5 * rng.unit() * rng.unit()));
        const Vec3 at = any(5), c = at + any(size), b = at + any(size), a = at + any(size);
        add(a, b, c);
      }
  }

  friend class MeshIndexRun;
  Real size_ = 0;
  std::vector<Vec3> points_, at_, velocity_;
  std::vector<std::uint32_t> triangles_;
  mutable std::vector<std::pair<double, std::vector<std::vector<std::uint32_t>>>> known_;
};

class MeshIndexRun final : public StudyRun {
 public:
  MeshIndexRun(const MeshIndexProblem& problem, const RunSpec& spec)
      : problem_(problem), h_(problem.info().t_end / spec.steps) {
    MeshIndex choice;
    if (spec.method != "boxes") {
      const std::size_t dot = spec.method.find('.');
      choice.index = dot == std::string::npos ? spec.method : "bvh";
      if (dot != std::string::npos)
        choice.volume = spec.method.substr(0, dot), choice.build = spec.method.substr(dot + 1);
      for (const auto& [name, value] : spec.settings)
        if (name == "leaf") std::from_chars(value.data(), value.data() + value.size(), choice.leaf);
    }
    mesh_ = make_shape("mesh", {.points = problem.points_, .triangles = problem.triangles_, .mesh_index = choice});
  }
  void step() override {
    t_ += h_, ++count_.steps;
    found_.assign(problem_.queries(), {});
    for (std::size_t q = 0; q < problem_.queries(); ++q) {
      const Aabb box = problem_.box(q, t_);
      mesh_->triangles_in(
          box, [](void* to, std::uint32_t i) { static_cast<std::vector<std::uint32_t>*>(to)->push_back(i); },
          &found_[q]);
      came_up_ += found_[q].size();
      RayHit hit;
      hits_ += mesh_->raycast(box.hi, Vec3(0, -3, 0), hit);
    }
    times_.push_back(t_);
    count_.force_evals = static_cast<std::int64_t>(came_up_ / problem_.queries());
  }
  void observe(Observation& out) override { problem_.reference(t_, out); }
  Invariants invariants() override {
    Invariants i;
    if (count_.steps == 0) return i;
    std::size_t missed = 0, all = 0;
    const auto& truth = problem_.truth(*mesh_, t_);
    for (std::size_t q = 0; q < truth.size(); ++q)
      for (const std::uint32_t k : truth[q]) {
        missed += !std::binary_search(found_[q].begin(), found_[q].end(), k), ++all;
      }
    i.constraint = all == 0 ? 0 : static_cast<double>(missed) / static_cast<double>(all);
    return i;
  }
  StudyCounters counters() const override { return count_; }
  bool measures_itself() const override { return true; }
  double own_error() const override {
    std::size_t needed = 0;
    for (const double t : times_)
      for (const auto& list : problem_.truth(*mesh_, t)) needed += list.size();
    return came_up_ == 0 ? 0 : 1 - std::min(1.0, static_cast<double>(needed) / static_cast<double>(came_up_));
  }

 private:
  const MeshIndexProblem& problem_;
  double h_, t_ = 0;
  ShapePtr mesh_;
  std::vector<std::vector<std::uint32_t>> found_;
  std::vector<double> times_;
  std::size_t hits_ = 0, came_up_ = 0;
  StudyCounters count_;
};

std::unique_ptr<StudyRun> MeshIndexProblem::start(const RunSpec& spec) const {
  return std::make_unique<MeshIndexRun>(*this, spec);
}

}  // namespace

Variant<StudyProblem> study_mesh_index() {
  return variant_of<StudyProblem, MeshIndexProblem>("mesh_index", "triangles in boxes and along rays, by every index");
}

}  // namespace feder
