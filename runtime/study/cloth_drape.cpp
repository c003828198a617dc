// A square sheet falls on a ball and drapes over it. No closed form: folds buckle, and have many equilibria, so only
// the height of the sheet's middle is compared (as good as its potential energy), against the same run with many small
// steps. What two finer runs of the first solver, and one of the others, differ by is the uncertainty.
#include <algorithm>

#include "cloth/solver.h"
#include "rigid/rigid.h"
#include "study/cloth_problem.h"

namespace feder {
namespace {

constexpr double kSize = 1, kBall = 0.25;  // m: side, radius

class Drape final : public ClothProblem {
 public:
  explicit Drape(const Params& given) {
    ProblemOptions o(given, info_);
    const int n = o.integer("cells", 12, 4, 60, "along a side of 1 m");
    const double stretch = o.number("stiffness", 1000, 1, 1e6, "N/m, stretch; shear is a tenth of it");
    const double bend = o.number("bend", 0, 0, 1, "N m; solvers differ in what they make of it");
    friction_ = o.number("friction", 0.5, 0, 2, "of the sheet on the ball");
    info_.t_end = o.number("t_end", 2, 0.5, 60, "s");
    desc_.nx = desc_.ny = static_cast<std::uint32_t>(n + 1);
    desc_.size[0] = desc_.size[1] = static_cast<Real>(kSize);
    desc_.stretch = static_cast<Real>(stretch), desc_.bend = static_cast<Real>(bend);
    desc_.friction = static_cast<Real>(friction_);
    desc_.damping = Real(0.02), desc_.self_collision = false;
    desc_.pose.position = Vec3(0, static_cast<Real>(kStart), 0);
    substeps_ = {2, 4, 8, 16, 32};
    info_.dof = 3 * (n + 1) * (n + 1);
    info_.dense = false, info_.own_measure = true;
    info_.x_scale = kSize, info_.v_scale = std::sqrt(kGravity * kSize);
    set_reference(ReferenceKind::self, 0, 0, kSource);
  }
  void add_bodies(World& w) const override {
    BodyDesc ball;
    ball.type = BodyType::fixed;
    ball.shape = make_sphere(static_cast<Real>(kBall));
    ball.friction_static = ball.friction_dynamic = static_cast<Real>(friction_);
    w.need<Rigid>().add_body(ball);
  }
  void observe(const Cloth& cloth, ObjectId id, Observation& out) const override {
    double sum = 0;
    const std::size_t n = cloth.vertex_count(id);
    for (std::size_t i = 0; i < n; ++i) sum += static_cast<double>(cloth.point(id, i)[1]);
    out.x = {0, sum / static_cast<double>(n), 0};
    out.v.clear(), out.q.clear();
  }
  void reference(double t, Observation& out) const override {
    refine();
    const double place = std::clamp(t / info_.t_end, 0.0, 1.0) * static_cast<double>(heights_.size());
    const auto k = std::min(static_cast<std::size_t>(place), heights_.size() - 1);
    const double s = place - static_cast<double>(k), before = k > 0 ? heights_[k - 1] : kStart;
    out.x = {0, (1 - s) * before + s * heights_[k], 0};
    out.v.clear(), out.q.clear();
  }
  double own_error(const std::vector<double>& heights) const override {
    refine();
    return std::fabs(late(heights) - late(heights_)) / kSize;
  }

 private:
  static constexpr double kStart = kBall + 0.05;  // m
  static constexpr int kFine = 128;               // substeps of the reference
  static constexpr const char* kSource =
      "mean height over the last quarter, by the side; self-refined with 4 times the substeps of the finest run, "
      "against "
      "half as many and another solver";

  // Mean over the last quarter: it swings.
  static double late(const std::vector<double>& heights) {
    const std::size_t first = heights.size() * 3 / 4;
    double sum = 0;
    for (std::size_t k = first; k < heights.size(); ++k) sum += heights[k];
    return sum / static_cast<double>(heights.size() - first);
  }
  std::vector<double> run(const std::string& method, int substeps) const {
    const int steps = static_cast<int>(std::ceil(kRate * info_.t_end));
    const auto fine = start({method, steps, 0, 0, substeps, {}});
    std::vector<double> heights;
    Observation seen;
    for (int k = 0; k < steps; ++k) {
      fine->step();
      fine->observe(seen);
      heights.push_back(seen.x[1]);
    }
    return heights;
  }
  void refine() const {
    if (!heights_.empty()) return;
    heights_ = run(methods().front().name, kFine);
    double apart = std::fabs(late(heights_) - late(run(methods().front().name, kFine / 2)));
    for (const MethodInfo& m : methods())
      if (m.name != methods().front().name) apart = std::max(apart, std::fabs(late(heights_) - late(run(m.name, 4))));
    ReferenceInfo& r = info_.reference;
    r.uncertainty = apart / kSize;
    r.digits = std::max(0, static_cast<int>(-std::log10(std::max(r.uncertainty, 1e-16))));
  }

  double friction_ = 0;
  mutable std::vector<double> heights_;  // of the reference, after each step
};

}  // namespace

Variant<StudyProblem> study_drape() {
  return {"drape", "a sheet falls on a ball and drapes over it",
          [](Arena&, const Params& p) -> std::unique_ptr<StudyProblem> { return std::make_unique<Drape>(p); }};
}

}  // namespace feder
