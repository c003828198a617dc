// A straight chain of equal masses and springs that swings along itself in one eigenmode (Lagrange, Mechanique
// analitique, 1788). Each mode tests frequency and damping of its own; linear as long as no spring is squeezed to
// nothing.
// Does not show: bending or large motion.
#include "study/net_problem.h"

namespace feder {
namespace {

class Chain final : public NetProblem {
 public:
  explicit Chain(const Params& given) {
    ProblemOptions o(given, info_);
    const int n = o.integer("points", 10, 1, 100, "free points");
    const double k = o.number("stiffness", 100, 1e-3, 1e12, "N/m");
    const double m = o.number("mass", 1, 1e-6, 1e6, "kg");
    const std::size_t ends =
        o.choice("ends", "fixed_fixed", {"fixed_fixed", "fixed_free", "free_free"}, "of the chain");
    const int mode = o.integer("mode", 1, 1, 100, "1: the slowest that swings");
    const double periods = o.number("periods", 2, 0.01, 1e4, "of the mode");
    const bool left = ends != 2, right = ends == 0;
    if (left) model_.add(0, 0, 0, m, true);
    std::vector<double> rest;
    for (int i = 0; i < n; ++i) {
      rest.push_back(i + (left ? 1 : 0));
      model_.observed.push_back(model_.add(rest.back(), 0, 0, m));
    }
    if (right) model_.add(n + 1, 0, 0, m, true);
    for (std::uint32_t i = 0; i + 1 < model_.mass.size(); ++i) model_.springs.push_back({i, i + 1, k, 1});
    if (model_.springs.empty()) throw SceneError("points: a free chain expects 2 or more, got 1");
    use_modes(0, rest);
    const std::size_t at = static_cast<std::size_t>(mode) - (ends == 2 ? 0 : 1);
    if (at >= modes().frequencies().size())
      throw SceneError("mode: expected a number from 1 to " + std::to_string(n - (ends == 2 ? 1 : 0)) + ", got " +
                       std::to_string(mode));
    const std::vector<double> shape = modes().shape(at);
    const double w = static_cast<double>(modes().frequencies()[at]), amplitude = 0.1;
    for (std::size_t i = 0; i < model_.observed.size(); ++i) model_.x[3 * model_.observed[i]] += amplitude * shape[i];
    use_modes(0, rest);
    info_.t_end = periods * 6.283185307179586 / w;
    measure_model();
    info_.x_scale = amplitude, info_.v_scale = amplitude * w;
    info_.energy_scale = info_.energy_start;
    info_.conserves_momentum = ends == 2;
    set_reference(ReferenceKind::closed, 15, 1e-15 * (1 + w * info_.t_end), "eigenmode, frequency by Jacobi's method");
    // positions are rounded at their own size, the mode is a tenth of a link
    info_.reference.rounding *= (n + 1) / amplitude;
    for (double s = std::ceil(8 * periods); s < 4000 * periods; s *= 2) steps_.push_back(static_cast<int>(s));
  }
};

}  // namespace

Variant<StudyProblem> study_chain() {
  return variant_of<StudyProblem, Chain>("chain", "eigenmodes of a straight chain, fixed or free at its ends");
}

}  // namespace feder
