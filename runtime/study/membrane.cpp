// A square net under tension, its edge pinned, that swings across itself in mode (p, q) (Lagrange, Mechanique
// analitique, 1788). Springs of rest length zero and stiffness T/a make the tension, so the motion is linear at any
// amplitude:
//   w_pq^2 = (4 T/(m a)) (sin^2(p pi/(2(N+1))) + sin^2(q pi/(2(N+1))))
// Does not show: stretch, as its springs have no length.
#include "study/net_problem.h"

namespace feder {
namespace {

class Membrane final : public NetProblem {
 public:
  explicit Membrane(const Params& given) {
    ProblemOptions o(given, info_);
    const int n = o.integer("points", 9, 1, 40, "free points along a side");
    const double tension = o.number("tension", 10, 1e-6, 1e9, "per spring, N");
    const double a = o.number("spacing", 0.1, 1e-4, 100, "m");
    const double m = o.number("mass", 0.01, 1e-9, 1e6, "of a point, kg");
    const int p = o.integer("p", 1, 1, n, "half waves along x");
    const int q = o.integer("q", 1, 1, n, "half waves along y");
    const double periods = o.number("periods", 2, 0.01, 1e4, "of the mode");
    const double unit = 3.14159265358979323846 / (n + 1);
    const auto half = [&](int k) { return std::pow(std::sin(k * unit / 2), 2); };
    frequency_ = std::sqrt(4 * tension / (m * a) * (half(p) + half(q)));
    const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(j * (n + 2) + i); };
    for (int j = 0; j <= n + 1; ++j)
      for (int i = 0; i <= n + 1; ++i) {
        const bool edge = i == 0 || j == 0 || i == n + 1 || j == n + 1;
        const double z = edge ? 0 : std::sin(p * i * unit) * std::sin(q * j * unit);
        const std::uint32_t point = model_.add(i * a, j * a, a * z, m, edge);
        if (!edge) model_.observed.push_back(point);
      }
    for (int j = 1; j <= n + 1; ++j)
      for (int i = 1; i <= n + 1; ++i) {
        if (j <= n) model_.springs.push_back({at(i - 1, j), at(i, j), tension / a, 0});
        if (i <= n) model_.springs.push_back({at(i, j - 1), at(i, j), tension / a, 0});
      }
    measure_model();
    info_.t_end = periods * 6.283185307179586 / frequency_;
    info_.x_scale = a, info_.v_scale = a * frequency_;
    info_.energy_scale = info_.energy_start;
    set_reference(ReferenceKind::closed, 15, 1e-15 * (1 + frequency_ * info_.t_end), "eigenmode");
    info_.reference.rounding *= n + 1;
    for (double s = std::ceil(8 * periods); s < 1000 * periods; s *= 2) steps_.push_back(static_cast<int>(s));
  }

  void reference(double t, Observation& out) const override {
    const double c = std::cos(frequency_ * t), s = -frequency_ * std::sin(frequency_ * t);
    out.x.clear(), out.v.clear(), out.q.clear();
    for (const std::uint32_t i : model_.observed) {
      out.x.insert(out.x.end(), {model_.x[3 * i], model_.x[3 * i + 1], model_.x[3 * i + 2] * c});
      out.v.insert(out.v.end(), {0, 0, model_.x[3 * i + 2] * s});
    }
  }

 private:
  double frequency_;
};

}  // namespace

Variant<StudyProblem> study_membrane() {
  return variant_of<StudyProblem, Membrane>("membrane", "eigenmodes of a square net under tension");
}

}  // namespace feder
