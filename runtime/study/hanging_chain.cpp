// Ten springs of k = 1e8 with nine masses of 1 kg and one of 1e6 kg below, let go unstretched. It
// bounces about its equilibrium in ten modes; top tension and stretch there are known.
// Source of the modes: Rayleigh, "The Theory of Sound" (1877), IV. Does not show: swinging, as all moves along the
// chain.
#include "study/net_problem.h"

namespace feder {
namespace {

constexpr double kGravity = 9.81;

class HangingChain final : public NetProblem {
 public:
  explicit HangingChain(const Params& given) {
    ProblemOptions o(given, info_);
    const int n = o.integer("links", 10, 1, 100, "springs, of 1 m");
    const double k = o.number("stiffness", 1e8, 1, 1e12, "N/m");
    const double ratio = o.number("ratio", 1e6, 1e-3, 1e9, "of the last mass to the others, which are 1 kg");
    info_.t_end = o.number("t_end", 2, 1e-3, 100, "s");
    model_.gravity = kGravity;
    model_.add(0, 0, 0, 1, true);
    for (int i = 1; i <= n; ++i) {
      const std::uint32_t p = model_.add(0, -i, 0, i == n ? ratio : 1);
      model_.springs.push_back({p - 1, p, k, 1});
      model_.observed.push_back(p);
    }
    // equilibrium: each spring carries the weight below it
    std::vector<double> rest;
    double sag = 0;
    for (int i = 1; i <= n; ++i) {
      sag += (ratio + (n - i)) * kGravity / k;
      rest.push_back(-i - sag);
    }
    use_modes(1, rest);
    measure_model();
    info_.x_scale = sag;
    info_.v_scale = sag * static_cast<double>(modes().frequencies()[0]);
    info_.energy_scale = std::max(std::fabs(info_.energy_start), ratio * kGravity * sag);
    set_reference(ReferenceKind::closed, 14, 1e-15 * (1 + info_.v_scale * info_.t_end / sag), "ten eigenmodes");
    // both ends of a link are rounded at their distance from the top, and the stiffness makes forces of it
    info_.reference.rounding *= 4 * n / sag;
    for (const int s : {20, 60, 200, 600, 2000, 6000}) implicit_steps_.push_back(s);
    steps_ = {20, 600};
    const double limit = info_.frequency * info_.t_end / 2;
    for (const double part : {1.1, 2.2, 4.4, 8.8, 17.6}) steps_.push_back(static_cast<int>(part * limit));
  }
};

}  // namespace

Variant<StudyProblem> study_hanging_chain() {
  return variant_of<StudyProblem, HangingChain>("hanging_chain",
                                                "a very stiff chain with a very heavy end, let go unstretched");
}

}  // namespace feder
