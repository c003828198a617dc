// A disc on a weightless axle, its foot held by a ball joint, let go tilted and spinning: it precesses and nods
// (rigid.md 5.4). Errors are those of the disc's centre; the joint's error is the constraint.
#include "study/rigid_problem.h"
#include "study/top.h"

namespace feder {
namespace {

constexpr double kRadius = 0.5, kThickness = 0.1, kDistance = 0.5;  // m; the mass is 1 kg

class HeavyTop final : public RigidProblem {
 public:
  explicit HeavyTop(const Params& given) {
    ProblemOptions o(given, info_);
    tilt_ = o.number("tilt", 0.5235987755982988, 0, 3.14, "of the axis from the vertical, rad");
    spin_ = o.number("spin", 50, -1e3, 1e3, "about the axis, rad/s");
    info_.t_end = o.number("t_end", 2, 1e-3, 1e3, "s");
    const double about_axis = 0.5 * kRadius * kRadius;
    const double across = (3 * kRadius * kRadius + kThickness * kThickness) / 12 + kDistance * kDistance;
    info_.dof = 3;
    info_.x_scale = kDistance;
    info_.v_scale = std::sqrt(2 * gravity_ * kDistance);
    info_.energy_start = 0.5 * about_axis * spin_ * spin_ + gravity_ * kDistance * std::cos(tilt_);
    info_.energy_scale = std::max(0.5 * about_axis * spin_ * spin_, gravity_ * kDistance);
    info_.frequency = about_axis * std::fabs(spin_) / across;
    size_ = kDistance;
    set_reference(ReferenceKind::quad, 14, 1e-14, "Euler's equations, extrapolation of order 20 in long double");
    info_.reference.rounding *= 100;
    for (int s = 1; s <= 64; s *= 2) steps_.push_back(static_cast<int>(std::ceil(60 * info_.t_end)) * s);
    exact_ = std::make_unique<OdeReference>(TopEquation{{across, about_axis, across}, gravity_ * kDistance, 1}, start(),
                                            info_.t_end, kStudySamples);
  }

  void build(World& world, std::vector<ObjectId>& observed) const override {
    Rigid& rigid = world.need<Rigid>();
    const double c = std::cos(tilt_), s = std::sin(tilt_);
    const Vec3 axis(static_cast<Real>(-s), static_cast<Real>(c), 0);
    BodyDesc d = body(make_cylinder(static_cast<Real>(kRadius), static_cast<Real>(kThickness)),
                      axis * static_cast<Real>(kDistance), 1, 0);
    d.rotation = from_axis_angle(Vec3(0, 0, 1), static_cast<Real>(tilt_));
    d.angular_velocity = axis * static_cast<Real>(spin_);
    observed.push_back(rigid.add_body(d));
    JointDesc joint;
    joint.type = "ball";
    joint.a = observed.back();
    rigid.add_joint(joint);
  }
  double constraint(World& world) const override {
    return static_cast<double>(world.need<Rigid>().max_joint_error()) / kDistance;
  }

  void reference(double t, Observation& out) const override {
    const std::vector<Wide>& y = exact_->at(t);
    Wide axis[3], e[3], w[3] = {0, 0, 0};
    axis_of(&y[3], 1, axis);
    for (int k = 0; k < 3; ++k) {
      axis_of(&y[3], k, e);
      for (int i = 0; i < 3; ++i) w[i] += y[static_cast<std::size_t>(k)] * e[i];
    }
    out.x.clear(), out.v.clear(), out.q.clear();
    for (int i = 0; i < 3; ++i) {
      const int a = (i + 1) % 3, b = (i + 2) % 3;
      out.x.push_back(static_cast<double>(axis[i]) * kDistance);
      out.v.push_back(static_cast<double>(w[a] * axis[b] - w[b] * axis[a]) * kDistance);
    }
  }

 private:
  std::vector<Wide> start() const {
    const Wide half = static_cast<Wide>(tilt_) / 2;
    return {0, spin_, 0, 0, 0, std::sin(half), std::cos(half)};
  }

  double tilt_, spin_;
  std::unique_ptr<OdeReference> exact_;
};

}  // namespace

Variant<StudyProblem> study_heavy_top() {
  return {"heavy_top", "a spinning disc on a foot: precession and nutation through a ball joint",
          [](Arena&, const Params& p) -> std::unique_ptr<StudyProblem> { return std::make_unique<HeavyTop>(p); }};
}

}  // namespace feder
