// A ball dropped from 1 m with restitution e: impacts at t1 (1 + 2e(1 - e^(n-1))/(1 - e)), an infinity of them before
// t1 (1 + e)/(1 - e), then rest: numerics.md 2.6. The event is the time of the first three impacts.
#include <algorithm>

#include "study/rigid_problem.h"

namespace feder {
namespace {

constexpr double kRadius = 0.1;

class BouncingBall final : public RigidProblem {
 public:
  explicit BouncingBall(const Params& given) {
    ProblemOptions o(given, info_);
    e_ = o.number("e", 0.5, 0, 1, "restitution");
    drop_ = o.number("drop", 1, 1e-3, 1e3, "height of the fall, m");
    first_ = std::sqrt(2 * drop_ / gravity_);
    info_.t_end = o.number("t_end", 2 * std::ceil(2 * first_) / 2, 1e-3, 100, "s");
    info_.x_scale = drop_;
    info_.v_scale = gravity_ * first_;
    info_.energy_start = gravity_ * (drop_ + kRadius);
    info_.energy_scale = gravity_ * drop_;
    point_mass_ = 1, size_ = 2 * kRadius;
    has_event_ = true;
    set_reference(ReferenceKind::closed, 15, 1e-15, "sum of the flights");
    for (int s = 1; s <= 64; s *= 2) steps_.push_back(static_cast<int>(std::ceil(60 * info_.t_end)) * s);
  }

  void build(World& world, std::vector<ObjectId>& observed) const override {
    world.need<Rigid>().add_body(ground(0));
    BodyDesc d = body(make_sphere(static_cast<Real>(kRadius)), Vec3(0, static_cast<Real>(drop_ + kRadius), 0), 1, 0);
    d.restitution = static_cast<Real>(e_);
    observed.push_back(world.need<Rigid>().add_body(d));
  }

  void reference(double t, Observation& out) const override {
    double impact = first_, up = 0, y = kRadius, v = 0;  // of the flight: when it began, speed then
    if (t < first_) {
      y += drop_ - 0.5 * gravity_ * t * t, v = -gravity_ * t;
    } else {
      up = e_ * gravity_ * first_;
      // flights below a nanometre count as rest
      while (up * up > 2e-9 * gravity_ && t > impact + 2 * up / gravity_) impact += 2 * up / gravity_, up *= e_;
      const double s = t - impact;
      if (up * up > 2e-9 * gravity_) y += up * s - 0.5 * gravity_ * s * s, v = up - gravity_ * s;
    }
    out.x = {0, y, 0}, out.v = {0, v, 0};
    out.q.clear();
  }

  void event(const BodyNow& before, const BodyNow& now, int& count, double& error) const override {
    const double v = before.v[1];
    if (count >= 3 || !(v < 0) || now.v[1] - v < -0.5 * v) return;
    // the fall from the state before the step to the ground
    const double gap = std::max(0.0, before.x[1] - kRadius);
    const double hit = before.t + (v + std::sqrt(v * v + 2 * gravity_ * gap)) / gravity_;
    const double exact = first_ * (1 + 2 * (e_ < 1 ? e_ * (1 - std::pow(e_, count)) / (1 - e_) : count));
    error = std::isnan(error) ? std::fabs(hit - exact) : std::max(error, std::fabs(hit - exact));
    count = e_ > 0 ? count + 1 : 3;
  }

 private:
  double e_, drop_, first_;
};

}  // namespace

Variant<StudyProblem> study_bouncing_ball() {
  return {"bouncing_ball", "a dropped ball: impact times, heights, and rest after infinitely many bounces",
          [](Arena&, const Params& p) -> std::unique_ptr<StudyProblem> { return std::make_unique<BouncingBall>(p); }};
}

}  // namespace feder
