// A ball at high speed against a thin wall, without restitution: it must lie before the wall in the end (rigid.md 5.7).
#include <algorithm>

#include "study/rigid_problem.h"

namespace feder {
namespace {

constexpr double kRadius = 0.1, kWall = 5;

class Bullet final : public RigidProblem {
 public:
  explicit Bullet(const Params& given) {
    ProblemOptions o(given, info_);
    v_ = o.number("speed", 1000, 0.1, 1e5, "m/s");
    wall_ = o.number("thickness", 0.01, 1e-4, 1, "of the wall, m");
    bullet_ = o.flag("bullet", true, "whether the ball is declared a bullet");
    info_.t_end = std::max(1.0 / 6, 2 * kWall / v_);
    info_.x_scale = kWall, info_.v_scale = v_;
    info_.energy_start = info_.energy_scale = 0.5 * v_ * v_;
    gravity_ = 0, point_mass_ = 1, size_ = 2 * kRadius;
    set_reference(ReferenceKind::closed, 16, 1e-16, "stopped by the wall");
    info_.reference.rounding = 8 * static_cast<double>(kEpsilon);
    info_.dense = false;  // nothing to interpolate across an impact
    for (int s = 1; s <= 32; s *= 2) steps_.push_back(static_cast<int>(std::ceil(60 * info_.t_end)) * s);
  }
  void build(World& world, std::vector<ObjectId>& observed) const override {
    BodyDesc wall = ground(0);
    wall.shape = make_box(static_cast<Real>(wall_), 4, 4);
    wall.position = Vec3(static_cast<Real>(kWall + wall_ / 2), 0, 0);
    world.need<Rigid>().add_body(wall);
    BodyDesc d = body(make_sphere(static_cast<Real>(kRadius)), Vec3::Zero(), 1, 0);
    d.velocity = Vec3(static_cast<Real>(v_), 0, 0);
    d.bullet = bullet_;
    observed.push_back(world.need<Rigid>().add_body(d));
  }
  void reference(double t, Observation& out) const override {
    const bool stopped = v_ * t >= kWall - kRadius;
    out.x = {stopped ? kWall - kRadius : v_ * t, 0, 0}, out.v = {stopped ? 0 : v_, 0, 0};
    out.q.clear();
  }

 private:
  double v_, wall_;
  bool bullet_;
};

}  // namespace

Variant<StudyProblem> study_bullet() {
  return {"bullet", "a fast ball against a thin wall",
          [](Arena&, const Params& p) -> std::unique_ptr<StudyProblem> { return std::make_unique<Bullet>(p); }};
}

}  // namespace feder
