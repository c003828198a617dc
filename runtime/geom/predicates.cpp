#include "geom/predicates.h"

#include <algorithm>
#include <cmath>

#include "feder/error.h"

namespace feder {
namespace {

constexpr double kRounding = 0x1p-53;
constexpr double kVolumeError = (7 + 56 * kRounding) * kRounding;  // Shewchuk 1997, section 4.3, bound A of orient3d
constexpr double kAxisError = 64 * kRounding;  // of a product of three differences, with room to spare

// a + b = sum + error, without loss (Knuth).
double two_sum(double a, double b, double& error) {
  const double sum = a + b, part = sum - a;
  error = (a - (sum - part)) + (b - part);
  return sum;
}

// a b = product + error, without loss (Dekker).
double two_product(double a, double b, double& error) {
  const auto split = [](double x, double& lo) {
    const double c = 134217729 * x, hi = c - (c - x);  // 2^27 + 1
    lo = x - hi;
    return hi;
  };
  double a_lo, b_lo;
  const double product = a * b, a_hi = split(a, a_lo), b_hi = split(b, b_lo);
  error = a_lo * b_lo - (((product - a_hi * b_hi) - a_lo * b_hi) - a_hi * b_lo);
  return product;
}

// An exact number: doubles that do not overlap, by growing size.
template <int kMost>
struct ExactSum {
  double part[kMost];
  int count = 0;
  void add(double x) {
    int kept = 0;
    for (int k = 0; k < count; ++k) {
      double error;
      x = two_sum(x, part[k], error);
      if (error != 0) part[kept++] = error;
    }
    if (x != 0) part[kept++] = x;
    count = kept;
    FEDER_ASSERT(count <= kMost);
  }
  // plus a times b
  template <int kA, int kB>
  void add_product(const ExactSum<kA>& a, const ExactSum<kB>& b, double sign) {
    for (int i = 0; i < a.count; ++i)
      for (int j = 0; j < b.count; ++j) {
        double error;
        const double product = two_product(sign * a.part[i], b.part[j], error);
        add(error), add(product);
      }
  }
  int sign() const { return count == 0 ? 0 : part[count - 1] > 0 ? 1 : -1; }
};

// Differences from `a`, by row, and their determinant.
struct Rows {
  double u[3][3];
  Rows(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const Vec3* end[3] = {&b, &c, &d};
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) u[i][k] = static_cast<double>((*end[i])[k]) - static_cast<double>(a[k]);
  }
  double determinant(double& size) const {
    double sum = 0;
    size = 0;
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3, m = (k + 2) % 3;
      const double x = u[1][l] * u[2][m], y = u[1][m] * u[2][l];
      sum += u[0][k] * (x - y), size += std::fabs(u[0][k]) * (std::fabs(x) + std::fabs(y));
    }
    return sum;
  }
};

int exact_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  ExactSum<2> u[3][3];
  const Vec3* end[3] = {&b, &c, &d};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) u[i][k].add(-static_cast<double>(a[k])), u[i][k].add(static_cast<double>((*end[i])[k]));
  ExactSum<192> sum;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    ExactSum<16> minor;
    minor.add_product(u[1][l], u[2][m], 1), minor.add_product(u[1][m], u[2][l], -1);
    sum.add_product(u[0][k], minor, 1);
  }
  return sum.sign();
}

// 2: the filter does not know.
int filtered_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  double size = 0;
  const double value = Rows(a, b, c, d).determinant(size);
  if (value > kVolumeError * size) return 1;
  if (value < -kVolumeError * size) return -1;
  return size > 0 ? 2 : 0;
}

struct Point3 {
  double at[3];
};
Point3 difference(const Vec3& a, const Vec3& b) {
  Point3 d;
  for (int k = 0; k < 3; ++k) d.at[k] = static_cast<double>(a[k]) - static_cast<double>(b[k]);
  return d;
}
Point3 normal_to(const Point3& a, const Point3& b) {
  return {{a.at[1] * b.at[2] - a.at[2] * b.at[1], a.at[2] * b.at[0] - a.at[0] * b.at[2],
           a.at[0] * b.at[1] - a.at[1] * b.at[0]}};
}
double along(const Point3& a, const Point3& b) { return a.at[0] * b.at[0] + a.at[1] * b.at[1] + a.at[2] * b.at[2]; }
double size_of(const Point3& a) { return std::max({std::fabs(a.at[0]), std::fabs(a.at[1]), std::fabs(a.at[2])}); }

// Certainly apart in the plane of the triangle, across one of its sides: spares flat sheets the exact arithmetic.
bool apart_in_plane(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3* v[3] = {&a, &b, &c};
  const Point3 n = normal_to(difference(b, a), difference(c, a));
  for (int k = 0; k < 3; ++k) {
    const Vec3 &from = *v[k], &to = *v[(k + 1) % 3];
    const Point3 out = normal_to(difference(to, from), n), at_p = difference(p, from), at_q = difference(q, from);
    const Point3 third = difference(*v[(k + 2) % 3], from);
    const double error = kAxisError * 3 * size_of(out) * std::max({size_of(at_p), size_of(at_q), size_of(third)});
    // the axis itself is rounded: it need not be the side's normal, the third corner speaks for the triangle
    const double edge = along(out, difference(to, from)), far = std::max({along(out, third), edge, 0.0});
    if (std::min(along(out, at_p), along(out, at_q)) > far + error) return true;
  }
  return false;
}

bool finite_points(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return is_finite(a) && is_finite(b) && is_finite(c) && is_finite(d);
}

}  // namespace

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  if (!finite_points(a, b, c, d)) return 0;
  const int sign = filtered_orientation(a, b, c, d);
  return sign == 2 ? exact_orientation(a, b, c, d) : sign;
}

bool passes_through(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  if (!finite_points(a, b, c, p) || !is_finite(q)) return false;
  int above = filtered_orientation(a, b, c, p), below = filtered_orientation(a, b, c, q);
  if (above == below && above != 2) return false;
  if (above == 2 || below == 2) {
    if (apart_in_plane(p, q, a, b, c)) return false;
    if (above == 2) above = exact_orientation(a, b, c, p);
    if (above == 0) return false;
    if (below == 2) below = exact_orientation(a, b, c, q);
  }
  if (above * below != -1) return false;
  const int u = orientation(p, q, a, b);
  return u != 0 && orientation(p, q, b, c) == u && orientation(p, q, c, a) == u;
}

}  // namespace feder
