// The pair 5(4) of Dormand & Prince 1980. Kept between calls: the slopes of the last attempt. Weak spot: explicit, so
// stiff forces decide its steps.
#include "integrate/dormand_prince.h"

#include <cmath>

namespace feder {
namespace {

constexpr int kStages = 7;  // the last is the slope at the end, the first of the next step
constexpr double kNodes[] = {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1, 1};
// clang-format off
constexpr double kCoupling[] = {
    0, 0, 0, 0, 0, 0, 0,
    1.0 / 5, 0, 0, 0, 0, 0, 0,
    3.0 / 40, 9.0 / 40, 0, 0, 0, 0, 0,
    44.0 / 45, -56.0 / 15, 32.0 / 9, 0, 0, 0, 0,
    19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729, 0, 0, 0,
    9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656, 0, 0,
    35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84, 0};
// clang-format on
constexpr const double* kWeights = kCoupling + 6 * kStages;
constexpr double kError[] = {71.0 / 57600, 0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40};

}  // namespace

DormandPrince::DormandPrince(Arena& a) : stages_(a, {kStages, kNodes, kCoupling, kWeights}) {}

void DormandPrince::start(ForceField& field, double t, std::span<const Vec3> x, std::span<const Vec3> low,
                          std::span<const Vec3> v, IntegratorStats& stats) {
  stages_.evaluate(field, t, 0, x, low, v, 0, 1, stats);
}

double DormandPrince::attempt(ForceField& field, double t, Real h, std::span<const Vec3> x, std::span<const Vec3> low,
                              std::span<const Vec3> v, double absolute, double relative, IntegratorStats& stats) {
  stages_.evaluate(field, t, h, x, low, v, 1, kStages, stats);
  const std::span<const Real> inv_mass = field.inv_mass();
  const std::span<const Vec3> x1 = end_x(), v1 = end_v();
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (inv_mass[i] == 0) continue;
    Vec3d ex = Vec3d::Zero(), ev = Vec3d::Zero();
    for (int s = 0; s < kStages; ++s) {
      ex += kError[s] * stages_.slope_x(s)[i].cast<double>();
      ev += kError[s] * stages_.slope_v(s)[i].cast<double>();
    }
    const auto size = [](const Vec3& a, const Vec3& b) {
      return std::sqrt(std::max(a.cast<double>().squaredNorm(), b.cast<double>().squaredNorm()));
    };
    const double sx = absolute + relative * size(x[i], x1[i]), sv = absolute + relative * size(v[i], v1[i]);
    sum += ex.squaredNorm() / (sx * sx) + ev.squaredNorm() / (sv * sv);
    count += 2;
  }
  return count == 0 ? 0 : static_cast<double>(std::fabs(h)) * std::sqrt(sum / static_cast<double>(count));
}

void DormandPrince::accept() {
  const std::span<Vec3> x0 = stages_.slope_x(0), v0 = stages_.slope_v(0), x6 = stages_.slope_x(6),
                        v6 = stages_.slope_v(6);
  std::copy(x6.begin(), x6.end(), x0.begin());
  std::copy(v6.begin(), v6.end(), v0.begin());
}

}  // namespace feder
