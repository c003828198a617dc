// Central attraction: acceleration strength s^power d/s towards `position`, with d the vector to it and
// s = sqrt(|d|^2 + softening^2) (Plummer softening; 0 by default: the pure law). power -2 is Newtonian gravity with
// strength = G M, power 1 a spring per mass. Without softening a point exactly at the centre feels nothing.
// Potential m strength s^(power+1)/(power+1), or m strength ln s for power -1.
// With `between` every pair of the points attracts instead, by the force strength m_a m_b s^power (power -2: Newton's
// law with strength = G), equal and opposite to the last bit; the cost grows with the square of the points.
// Powers are computed here and not by the C library, whose last digit differs between machines: whole and half
// powers by multiplication of square roots, others by exp(p ln s) in double.
// Sources: Newton 1687; Plummer 1911. Weak spot: without softening, close encounters need arbitrarily short steps.
#include "base/functions.h"
#include "feder/force.h"

namespace feder {
namespace {

double power_of(double s, double p) {
  const double twice = 2 * p;
  if (twice != std::floor(twice) || std::fabs(twice) > 64) return exponential(p * natural_log(s));
  double result = 1, base = std::sqrt(s);
  for (int n = static_cast<int>(std::fabs(twice)); n > 0; n /= 2, base *= base)
    if (n % 2 == 1) result *= base;
  return twice < 0 ? 1 / result : result;
}

class Attractor final : public Force {
 public:
  explicit Attractor(const Params& p)
      : position_(p.vector({"position", "m"}, Vec3(0, 0, 0))), strength_(p.number({"strength", "N", kAny}, 1)),
        power_(p.number({"power", "", {-16, 16}}, -2)), softening_(p.number({"softening", "m", {0, 1e9}}, 0)),
        between_(p.flag({"between"}, false)) {}

  void add(const MassPoint* points, std::size_t count, double, Vec3* out) const override {
    if (between_) return add_pairs(points, count, out);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 d = position_ - points[i].position;
      const double s = softened(d);
      if (!(s > 0)) continue;
      const Real scale = static_cast<Real>(static_cast<double>(points[i].mass) * strength_ * power_of(s, power_ - 1));
      out[i] += scale * d;
    }
  }
  double potential(const MassPoint* points, std::size_t count) const override {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double mass = static_cast<double>(points[i].mass) * strength_;
      if (!between_) sum += mass * per_mass(softened(position_ - points[i].position));
      for (std::size_t j = i + 1; between_ && j < count; ++j)
        sum += mass * static_cast<double>(points[j].mass) * per_mass(softened(points[j].position - points[i].position));
    }
    return sum;
  }
  // d(s^(p-1) d)/dx = -s^(p-1) 1 - (p-1) s^(p-3) d d^T
  bool derivative(const MassPoint* points, std::size_t count, double, bool by_velocity, Mat3* out) const override {
    if (by_velocity) return true;
    for (std::size_t i = 0; i < count; ++i) {
      if (!between_) add_derivative(position_ - points[i].position, static_cast<double>(points[i].mass), out[i]);
      for (std::size_t j = i + 1; between_ && j < count; ++j) {
        const double masses = static_cast<double>(points[i].mass) * static_cast<double>(points[j].mass);
        const Vec3 d = points[j].position - points[i].position;
        add_derivative(d, masses, out[i]), add_derivative(d, masses, out[j]);
      }
    }
    return true;
  }
  bool depends_on_velocity() const override { return false; }

 private:
  double softened(const Vec3& d) const {
    const double x = d[0], y = d[1], z = d[2];
    return std::sqrt(x * x + y * y + z * z + softening_ * softening_);
  }

  double per_mass(double s) const {
    if (!(s > 0)) return 0;
    return power_ == -1 ? natural_log(s) : power_of(s, power_ + 1) / (power_ + 1);
  }
  void add_derivative(const Vec3& d, double mass, Mat3& out) const {
    const double s = softened(d);
    if (!(s > 0)) return;
    const double across = mass * strength_ * power_of(s, power_ - 1), along = (power_ - 1) * across / (s * s);
    out -= static_cast<Real>(along) * d * d.transpose();
    out.diagonal().array() -= static_cast<Real>(across);
  }
  void add_pairs(const MassPoint* points, std::size_t count, Vec3* out) const {
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = i + 1; j < count; ++j) {
        const Vec3 d = points[j].position - points[i].position;
        const double s = softened(d);
        if (!(s > 0)) continue;
        const double masses = static_cast<double>(points[i].mass) * static_cast<double>(points[j].mass);
        const Vec3 f = static_cast<Real>(masses * strength_ * power_of(s, power_ - 1)) * d;
        out[i] += f;
        out[j] -= f;
      }
  }

  Vec3 position_;    // m
  double strength_;  // m/s^2 at s = 1 m; between points N/kg^2 there
  double power_;
  double softening_;  // m
  bool between_;
};

}  // namespace

Variant<Force> forces_attractor() {
  return variant_of<Force, Attractor>(
      "attractor", "acceleration strength r^power towards position, or between the points of a net; softening in m");
}

}  // namespace feder
