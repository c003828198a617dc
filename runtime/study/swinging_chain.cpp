// Ten links of 0.1 m and 0.1 kg, the last mass R times that, level at rest, swinging for a second.
// Stiff by its springs, long in its motion; errors are those of the end point.
// Reference: extrapolation (reference.h). Does not show: long times, which are chaotic.
#include "study/net_problem.h"

namespace feder {
namespace {

class SwingingChain final : public NetProblem {
 public:
  explicit SwingingChain(const Params& given) {
    ProblemOptions o(given, info_);
    const int n = o.integer("links", 10, 1, 50, "of 0.1 m");
    const double k = o.number("stiffness", 1e6, 1, 1e9, "N/m");
    const double ratio = o.number("ratio", 1, 1e-3, 1e6, "R, of the last mass to the others, which are 0.1 kg");
    info_.t_end = o.number("t_end", 1, 1e-3, 2, "s");
    model_.gravity = 9.81;
    model_.add(0, 0, 0, 0.1, true);
    for (int i = 1; i <= n; ++i) {
      const std::uint32_t p = model_.add(0.1 * i, 0, 0, i == n ? 0.1 * ratio : 0.1);
      model_.springs.push_back({p - 1, p, k, 0.1});
    }
    model_.observed = {static_cast<std::uint32_t>(n)};
    measure_model();
    const double length = 0.1 * n;
    info_.v_scale = std::sqrt(2 * 9.81 * length);
    info_.energy_scale = 9.81 * 0.1 * (0.05 * n * (n - 1) + ratio * length);  // the fall of all masses to below
    set_reference(ReferenceKind::quad, 11, 1e-12, "extrapolation of order 20 in long double");
    // links of 0.1 m are known to a rounding of their ends at up to 1 m; the stretch takes it times k
    info_.reference.rounding = static_cast<double>(kEpsilon) * 10 * n;
    steps_ = {60, 190, 600, 1900, 6000, 19000, 60000};
    if (info_.frequency * info_.t_end > 2e5) steps_.push_back(190000);
    implicit_steps_ = {60, 120, 240, 600, 1200, 2400, 6000};
    use_extrapolation();
  }
};

}  // namespace

Variant<StudyProblem> study_swinging_chain() {
  return variant_of<StudyProblem, SwingingChain>(
      "swinging_chain", "ten stiff links swinging from the level, with an end as heavy as wanted");
}

}  // namespace feder
