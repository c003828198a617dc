// A wall, a spring, 1 kg, a spring, 1e6 kg. Both eigenmodes at once, four decades apart.
// Source: Rayleigh, "The Theory of Sound" (1877), IV. Does not show: non-linear coupling of the modes.
#include "study/net_problem.h"

namespace feder {
namespace {

class TwoMasses final : public NetProblem {
 public:
  explicit TwoMasses(const Params& given) {
    ProblemOptions o(given, info_);
    const double k = o.number("stiffness", 1e4, 1, 1e12, "of both springs, N/m");
    const double ratio = o.number("ratio", 1e6, 1, 1e9, "of the second mass to the first, which is 1 kg");
    info_.t_end = o.number("t_end", 10, 1e-3, 1e4, "s");
    model_.add(0, 0, 0, 1, true);
    const std::uint32_t light = model_.add(1, 0, 0, 1), heavy = model_.add(2, 0, 0, ratio);
    model_.springs = {{0, light, k, 1}, {light, heavy, k, 1}};
    model_.observed = {light, heavy};
    // the heavy one pulled out, the light one where it rests then, and a little off
    model_.x[3 * heavy] += 0.1;
    model_.x[3 * light] += 0.05 + 0.01;
    use_modes(0, {1, 2});
    measure_model();
    info_.x_scale = 0.1;
    info_.v_scale =
        0.01 * static_cast<double>(modes().frequencies()[1]) + 0.1 * static_cast<double>(modes().frequencies()[0]);
    info_.energy_scale = info_.energy_start;
    set_reference(ReferenceKind::closed, 15, 1e-15 * (1 + info_.frequency * info_.t_end), "two eigenmodes");
    for (double s = 20; s < 400 * info_.t_end * info_.frequency && s < 1e6; s *= s < 100 ? 5 : 3)
      steps_.push_back(static_cast<int>(s));
    for (const int s : steps_)
      if (s < 200000) implicit_steps_.push_back(s);
  }
};

}  // namespace

Variant<StudyProblem> study_two_masses() {
  return variant_of<StudyProblem, TwoMasses>("two_masses", "1 kg and 1e6 kg in series: two eigenmodes far apart");
}

}  // namespace feder
