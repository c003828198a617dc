// A mass on a stiff spring that swings from the level, E0 = 0. Slow swing and fast stretch in one.
// Source: Vitt and Gorelik 1933. Reference: extrapolation (reference.h). Does not show: damping.
#include "study/net_problem.h"

namespace feder {
namespace {

class SpringPendulum final : public NetProblem {
 public:
  explicit SpringPendulum(const Params& given) {
    ProblemOptions o(given, info_);
    const double k = o.number("stiffness", 1e4, 1, 1e10, "N/m; mass 1 kg, rest length 1 m");
    info_.t_end = o.number("t_end", 2, 0.01, 100, "s");
    model_.gravity = 9.81;
    model_.add(0, 0, 0, 1, true);
    model_.observed = {model_.add(1, 0, 0, 1)};
    model_.springs = {{0, 1, k, 1}};
    measure_model();
    info_.v_scale = std::sqrt(2 * 9.81);
    info_.energy_scale = 9.81;
    set_reference(ReferenceKind::quad, 13, 1e-15 * (1 + info_.frequency * info_.t_end),
                  "extrapolation of order 20 in long double");
    // the stretch of a stiff spring follows its force: its phase, an amplitude of about g/k, is what rounding shifts
    steps_ = {30, 100, 300, 1000};
    for (double s = 3000; s < 40 * info_.frequency * info_.t_end && s < 2e6; s *= 2)
      steps_.push_back(static_cast<int>(s));
    for (int s = 30; s < 60000; s *= 2) implicit_steps_.push_back(s);
    use_extrapolation();
  }
};

}  // namespace

Variant<StudyProblem> study_spring_pendulum() {
  return variant_of<StudyProblem, SpringPendulum>("spring_pendulum",
                                                  "a mass on a stiff spring, swinging from the level");
}

}  // namespace feder
