// Error norms and lines through points. Weak spot: an angle is the largest of all bodies, so one that spins freely
// decides it.
#include "study/norms.h"

#include <algorithm>

namespace feder {

double rms_distance(std::span<const double> a, std::span<const double> b) {
  if (a.size() != b.size() || a.empty()) return NAN;
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / (static_cast<double>(a.size()) / 3));
}

double largest_angle(std::span<const double> q, std::span<const double> reference) {
  if (q.size() != reference.size() || q.empty()) return NAN;
  double worst = 0;
  for (std::size_t i = 0; i < q.size(); i += 4) {
    // by the sine half: acos loses half of the digits near 1
    const double *a = &q[i], *b = &reference[i];
    const double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    const double x = a[3] * b[0] - a[0] * b[3] - a[1] * b[2] + a[2] * b[1];
    const double y = a[3] * b[1] - a[1] * b[3] - a[2] * b[0] + a[0] * b[2];
    const double z = a[3] * b[2] - a[2] * b[3] - a[0] * b[1] + a[1] * b[0];
    worst = std::max(worst, 2 * std::atan2(std::sqrt(x * x + y * y + z * z), std::fabs(cosine)));
  }
  return worst;
}

double correct_digits(const Observation& run, const Observation& reference, double x_scale, double v_scale) {
  double digits = 17;
  const auto compare = [&](std::span<const double> a, std::span<const double> b, double scale) {
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double error = std::fabs(a[i] - b[i]) / scale / (1 + std::fabs(b[i]) / scale);
      if (error > 0) digits = std::min(digits, -std::log10(error));
      if (std::isnan(error)) digits = NAN;
    }
  };
  if (run.x.size() != reference.x.size() || run.v.size() != reference.v.size()) return NAN;
  compare(run.x, reference.x, x_scale);
  compare(run.v, reference.v, v_scale);
  return digits;
}

void interpolate(double t0, const Observation& a, double t1, const Observation& b, double t, Observation& out) {
  const double h = t1 - t0, s = (t - t0) / h, r = 1 - s;
  const double h00 = (1 + 2 * s) * r * r, h10 = s * r * r, h01 = s * s * (3 - 2 * s), h11 = -s * s * r;
  const double d00 = -6 * s * r, d10 = r * (1 - 3 * s), d11 = s * (3 * s - 2);
  out.x.resize(a.x.size()), out.v.resize(a.v.size());
  for (std::size_t i = 0; i < a.x.size(); ++i) {
    out.x[i] = h00 * a.x[i] + h * h10 * a.v[i] + h01 * b.x[i] + h * h11 * b.v[i];
    out.v[i] = d00 * (a.x[i] - b.x[i]) / h + d10 * a.v[i] + d11 * b.v[i];
  }
  out.q = s < 0.5 ? a.q : b.q;
}

Line fit_line(std::span<const double> x, std::span<const double> y) {
  const std::size_t n = x.size();
  if (n < 2 || y.size() != n) return {};
  double mx = 0, my = 0;
  for (std::size_t i = 0; i < n; ++i) mx += x[i], my += y[i];
  mx /= static_cast<double>(n), my /= static_cast<double>(n);
  double xx = 0, xy = 0, left = 0;
  for (std::size_t i = 0; i < n; ++i) xx += (x[i] - mx) * (x[i] - mx), xy += (x[i] - mx) * (y[i] - my);
  if (xx == 0) return {};
  Line line{xy / xx, my - xy / xx * mx, 0};
  for (std::size_t i = 0; i < n; ++i) {
    const double d = y[i] - line.slope * x[i] - line.intercept;
    left += d * d;
  }
  line.rms = std::sqrt(left / static_cast<double>(n));
  return line;
}

}  // namespace feder
