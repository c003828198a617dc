// n boxes on each other that should just stand: drift, energy and penetration are the errors.
#include "study/rigid_problem.h"

namespace feder {
namespace {

class Stack final : public RigidProblem {
 public:
  explicit Stack(const Params& given) {
    ProblemOptions o(given, info_);
    n_ = o.integer("boxes", 10, 1, 40, "of 1 m and 1 kg");
    top_ = o.number("top_mass", 1, 1e-3, 1e4, "of the last box, kg");
    info_.t_end = o.number("t_end", 4, 1e-3, 600, "s");
    info_.dof = 6 * n_;
    info_.v_scale = std::sqrt(9.81);
    info_.energy_start = 0;
    for (int i = 0; i < n_; ++i) info_.energy_start += gravity_ * (i + 0.5) * (i + 1 == n_ ? top_ : 1);
    info_.energy_scale = gravity_ * (n_ - 1 + top_);
    set_reference(ReferenceKind::closed, 16, 1e-16, "at rest");
    info_.reference.rounding = static_cast<double>(kEpsilon) * n_;
    for (const int rate : {30, 60, 120, 240}) steps_.push_back(static_cast<int>(std::ceil(rate * info_.t_end)));
  }
  void build(World& world, std::vector<ObjectId>& observed) const override {
    world.need<Rigid>().add_body(ground(0.6));
    for (int i = 0; i < n_; ++i)
      observed.push_back(world.need<Rigid>().add_body(
          body(make_box(1, 1, 1), Vec3(0, static_cast<Real>(i + 0.5), 0), i + 1 == n_ ? top_ : 1, 0.6)));
  }
  void reference(double, Observation& out) const override {
    out.x.clear(), out.q.clear();
    for (int i = 0; i < n_; ++i) out.x.insert(out.x.end(), {0, i + 0.5, 0});
    out.v.assign(out.x.size(), 0);
  }

 private:
  int n_;
  double top_;
};

}  // namespace

Variant<StudyProblem> study_stack() {
  return {"stack", "boxes on each other, the last as heavy as wanted: they should stand still",
          [](Arena&, const Params& p) -> std::unique_ptr<StudyProblem> { return std::make_unique<Stack>(p); }};
}

}  // namespace feder
