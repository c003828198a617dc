// Central attraction: acceleration strength s^power d/s towards `position`, with d the vector to it and
// s = sqrt(|d|^2 + softening^2) (Plummer softening; 0 by default: the pure law). power -2 is Newtonian gravity with
// strength = G M, power 1 a spring per mass. Without softening a point exactly at the centre feels nothing.
// Potential m strength s^(power+1)/(power+1), or m strength ln s for power -1.
// Powers are computed here and not by the C library, whose last digit differs between machines: whole and half
// powers by multiplication and square root, others by exp(p ln s) in double.
#include "forces/force.h"

namespace feder {
namespace {

// ln x = e ln 2 + 2 atanh((m-1)/(m+1)) with x = m 2^e, m in [sqrt(1/2), sqrt 2).
double natural_log(double x) {
  int e = 0;
  double m = std::frexp(x, &e);
  if (m < 0.70710678118654752) m *= 2, --e;
  const double z = (m - 1) / (m + 1), zz = z * z;
  double sum = 0;
  for (int k = 23; k >= 1; k -= 2) sum = sum * zz + 1.0 / k;  // |z| < 0.172: the next term is below 1e-18
  return e * 0.69314718055994531 + 2 * z * sum;
}

double exponential(double x) {
  const double n = std::floor(x / 0.69314718055994531 + 0.5);
  const double r = x - n * 0.69314718055994531;  // |r| < 0.35
  double sum = 1;
  for (int k = 16; k >= 1; --k) sum = 1 + sum * r / k;
  return std::ldexp(sum, static_cast<int>(n));
}

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
      : position_(p.vector("position", Vec3(0, 0, 0))), strength_(p.number("strength", 1, -1e30, 1e30)),
        power_(p.number("power", -2, -16, 16)), softening_(p.number("softening", 0, 0, 1e9)) {}

  void add(const MassPoint* points, std::size_t count, double, Vec3* out) const override {
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
      const double s = softened(position_ - points[i].position);
      if (!(s > 0)) continue;
      const double u = power_ == -1 ? natural_log(s) : power_of(s, power_ + 1) / (power_ + 1);
      sum += static_cast<double>(points[i].mass) * strength_ * u;
    }
    return sum;
  }
  bool depends_on_velocity() const override { return false; }

 private:
  double softened(const Vec3& d) const {
    const double x = d[0], y = d[1], z = d[2];
    return std::sqrt(x * x + y * y + z * z + softening_ * softening_);
  }

  Vec3 position_;     // m
  double strength_;   // m/s^2 at s = 1 m
  double power_;
  double softening_;  // m
};

}  // namespace

Variant<Force> forces_attractor() {
  return {"attractor", "acceleration strength r^power towards position; softening in m",
          [](Arena&, const Params& p) -> std::unique_ptr<Force> { return std::make_unique<Attractor>(p); }};
}

}  // namespace feder
