// Coulomb friction in closed form: numerics.md 2.6. A block on a slope holds when mu >= tan, else slides with
// g (sin - mu cos); a block thrown over the floor stops after v/(mu g); a ball thrown without spin rolls after
// 2 v/(7 mu g) with 5/7 of its speed.
#include <algorithm>

#include "study/rigid_problem.h"

namespace feder {
namespace {

class Incline final : public RigidProblem {
 public:
  explicit Incline(const Params& given) {
    ProblemOptions o(given, info_);
    angle_ = o.number("angle", 30, 0, 80, "degrees") * 3.14159265358979323846 / 180;
    mu_ = o.number("mu", 0.3, 0, 10, "friction");
    info_.t_end = o.number("t_end", 1, 1e-3, 100, "s");
    const double a = acceleration();
    info_.x_scale = std::max(0.1, 0.5 * a * info_.t_end * info_.t_end);
    info_.v_scale = std::max(0.1, a * info_.t_end);
    info_.energy_start = gravity_ * 0.25 * std::cos(angle_);
    info_.energy_scale = gravity_ * info_.x_scale;
    point_mass_ = 1, size_ = 0.5;
    set_reference(ReferenceKind::closed, 15, 1e-15, "g (sin - mu cos)");
    for (int s = 1; s <= 64; s *= 2) steps_.push_back(static_cast<int>(std::ceil(60 * info_.t_end)) * s);
  }
  void build(World& world, std::vector<ObjectId>& observed) const override {
    const auto s = static_cast<Real>(std::sin(angle_)), c = static_cast<Real>(std::cos(angle_));
    world.need<Rigid>().add_body(ground(mu_, Vec3(s, c, 0)));
    BodyDesc d = body(make_box(1, Real(0.5), 1), Vec3(s, c, 0) * Real(0.25), 1, mu_);
    d.rotation = from_axis_angle(Vec3(0, 0, 1), static_cast<Real>(-angle_));
    observed.push_back(world.need<Rigid>().add_body(d));
  }
  void reference(double t, Observation& out) const override {
    const double s = std::sin(angle_), c = std::cos(angle_), a = acceleration(), way = 0.5 * a * t * t;
    out.x = {0.25 * s + way * c, 0.25 * c - way * s, 0};
    out.v = {a * t * c, -a * t * s, 0};
    out.q.clear();
  }

 private:
  double acceleration() const { return std::max(0.0, gravity_ * (std::sin(angle_) - mu_ * std::cos(angle_))); }
  double angle_, mu_;
};

class SlideToRest final : public RigidProblem {
 public:
  explicit SlideToRest(const Params& given) {
    ProblemOptions o(given, info_);
    v_ = o.number("speed", 5, 0.01, 1e3, "m/s at the start");
    mu_ = o.number("mu", 0.5, 1e-3, 10, "friction");
    stop_ = v_ / (mu_ * gravity_);
    info_.t_end = 1.25 * stop_;
    info_.x_scale = 0.5 * v_ * stop_, info_.v_scale = v_;
    info_.energy_start = 0.5 * v_ * v_ + gravity_ * 0.25, info_.energy_scale = 0.5 * v_ * v_;
    point_mass_ = 1, size_ = 0.5;
    has_event_ = true;
    set_reference(ReferenceKind::closed, 15, 1e-15, "v/(mu g)");
    for (int s = 1; s <= 64; s *= 2) steps_.push_back(static_cast<int>(std::ceil(60 * info_.t_end)) * s);
  }
  void build(World& world, std::vector<ObjectId>& observed) const override {
    world.need<Rigid>().add_body(ground(mu_));
    BodyDesc d = body(make_box(1, Real(0.5), 1), Vec3(0, Real(0.25), 0), 1, mu_);
    d.velocity = Vec3(static_cast<Real>(v_), 0, 0);
    observed.push_back(world.need<Rigid>().add_body(d));
  }
  void reference(double t, Observation& out) const override {
    const double s = std::min(t, stop_), a = mu_ * gravity_;
    out.x = {v_ * s - 0.5 * a * s * s, 0.25, 0}, out.v = {v_ - a * s, 0, 0};
    out.q.clear();
  }
  void event(const BodyNow& before, const BodyNow& now, int& count, double& error) const override {
    if (count > 0 || std::fabs(now.v[0]) > 1e-3 * v_) return;
    error = std::fabs(before.t + before.v[0] / (mu_ * gravity_) - stop_);
    count = 1;
  }

 private:
  double v_, mu_, stop_;
};

class Rolling final : public RigidProblem {
 public:
  explicit Rolling(const Params& given) {
    ProblemOptions o(given, info_);
    v_ = o.number("speed", 5, 0.01, 1e3, "m/s at the start, without spin");
    mu_ = o.number("mu", 0.5, 1e-3, 10, "friction");
    r_ = o.number("radius", 0.5, 1e-3, 100, "m");
    rolls_ = 2 * v_ / (7 * mu_ * gravity_);
    info_.t_end = 3 * rolls_;
    info_.x_scale = v_ * info_.t_end, info_.v_scale = v_;
    info_.energy_start = 0.5 * v_ * v_ + gravity_ * r_, info_.energy_scale = 0.5 * v_ * v_;
    size_ = 2 * r_;
    has_event_ = true;
    set_reference(ReferenceKind::closed, 15, 1e-15, "2 v/(7 mu g), then 5/7 v");
    for (int s = 1; s <= 64; s *= 2) steps_.push_back(static_cast<int>(std::ceil(60 * info_.t_end)) * s);
  }
  void build(World& world, std::vector<ObjectId>& observed) const override {
    world.need<Rigid>().add_body(ground(mu_));
    BodyDesc d = body(make_sphere(static_cast<Real>(r_)), Vec3(0, static_cast<Real>(r_), 0), 1, mu_);
    d.velocity = Vec3(static_cast<Real>(v_), 0, 0);
    observed.push_back(world.need<Rigid>().add_body(d));
  }
  void reference(double t, Observation& out) const override {
    const double s = std::min(t, rolls_), a = mu_ * gravity_;
    const double v = v_ - a * s;
    out.x = {v_ * s - 0.5 * a * s * s + v * (t - s), r_, 0}, out.v = {v, 0, 0};
    out.q.clear();
  }
  double reference_energy(double t) const override {
    // spin r w = 5/2 mu g t while it slips
    const double s = std::min(t, rolls_), a = mu_ * gravity_, v = v_ - a * s, rim = 2.5 * a * s;
    return 0.5 * v * v + 0.2 * rim * rim + gravity_ * r_;
  }
  void event(const BodyNow& before, const BodyNow& now, int& count, double& error) const override {
    const auto slip = [&](const BodyNow& b) { return b.v[0] + r_ * b.w[2]; };
    if (count > 0 || std::fabs(slip(now)) > 1e-3 * v_) return;
    error = std::fabs(before.t + slip(before) / (3.5 * mu_ * gravity_) - rolls_);
    count = 1;
  }

 private:
  double v_, mu_, r_, rolls_;
};

}  // namespace

Variant<StudyProblem> study_incline() {
  return {"incline", "a block on a slope that holds or slides",
          [](Arena&, const Params& p) -> std::unique_ptr<StudyProblem> { return std::make_unique<Incline>(p); }};
}

Variant<StudyProblem> study_slide_to_rest() {
  return {"slide_to_rest", "a block thrown over the floor: where and when friction stops it",
          [](Arena&, const Params& p) -> std::unique_ptr<StudyProblem> { return std::make_unique<SlideToRest>(p); }};
}

Variant<StudyProblem> study_rolling() {
  return {"rolling", "a ball thrown without spin: when it rolls, and how fast",
          [](Arena&, const Params& p) -> std::unique_ptr<StudyProblem> { return std::make_unique<Rolling>(p); }};
}

}  // namespace feder
