// Continuous collision detection of a point and a triangle whose corners all move along straight lines: the times at
// which the four lie in one plane are the roots of a cubic (Provot 1997); at each, the point is inside the triangle or
// not. Triangles that share an edge share its path, so nothing passes between them but by rounding. In doubles.
// tests/geom/test_swept_triangle.cpp.
#pragma once
#include <algorithm>
#include <cmath>
#include <utility>

#include "feder/types.h"

namespace feder {

struct SweptHit {
  double when = 2;          // 0 to 1
  Real weight[3] = {};      // of the corners, there
  bool from_front = false;  // it came from the side that the triangle's normal points to
};

class SweptTriangle {
 public:
  // The point moves from `from` to `to`, the corners from `before` to `after`.
  SweptTriangle(const Vec3& from, const Vec3& to, const Vec3 (&before)[3], const Vec3 (&after)[3]) {
    for (int k = 0; k < 3; ++k) {
      p_[k] = from[k], dp_[k] = static_cast<double>(to[k]) - p_[k];
      for (int j = 0; j < 3; ++j) c_[j][k] = before[j][k], dc_[j][k] = static_cast<double>(after[j][k]) - c_[j][k];
    }
  }
  // The first time that the point meets the triangle, if before hit.when.
  bool first(SweptHit& hit) const {
    const double f0 = volume(0), r = volume(0.5) - f0, p = volume(1) - f0, q = volume(-1) - f0;
    const double c2 = (p + q) / 2, odd = (p - q) / 2, c3 = (odd / 2 + c2 / 4 - r) * 8 / 3, c1 = odd - c3;
    // between its extremes the cubic is monotonic
    double cut[4] = {0, 1, 1, 1};
    int n = 1;
    const double square = c2 * c2 - 3 * c3 * c1;
    if (square > 0) {
      const double h = -(c2 + std::copysign(std::sqrt(square), c2));
      double root[2] = {h / (3 * c3), c1 / h};
      if (root[0] > root[1]) std::swap(root[0], root[1]);
      for (const double t : root)
        if (t > 0 && t < 1) cut[n++] = t;
    }
    cut[n++] = 1;
    for (int k = 0; k + 1 < n; ++k) {
      double lo = cut[k], hi = cut[k + 1];
      const bool front = volume(lo) > 0;
      if (lo >= hit.when) return false;
      if (front == (volume(hi) > 0)) continue;
      for (int i = 0; i < kBisections; ++i) {
        const double middle = (lo + hi) / 2;
        ((volume(middle) > 0) == front ? lo : hi) = middle;
      }
      if (hi >= hit.when || !inside(hi, hit.weight)) continue;
      hit.when = hi, hit.from_front = front;
      return true;
    }
    return false;
  }

 private:
  static constexpr int kBisections = 48;     // to the last bits of a double
  static constexpr double kRounding = 1e-9;  // of weights

  struct Corners {
    double u[3], v[3], p[3], n[3];  // two edges, the point, from the first corner; normal
  };
  Corners at(double t) const {
    Corners k;
    for (int i = 0; i < 3; ++i) {
      const double a = c_[0][i] + t * dc_[0][i];
      k.u[i] = c_[1][i] + t * dc_[1][i] - a, k.v[i] = c_[2][i] + t * dc_[2][i] - a, k.p[i] = p_[i] + t * dp_[i] - a;
    }
    cross_of(k.u, k.v, k.n);
    return k;
  }
  static void cross_of(const double (&a)[3], const double (&b)[3], double (&out)[3]) {
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, l = (i + 2) % 3;
      out[i] = a[j] * b[l] - a[l] * b[j];
    }
  }
  static double dot_of(const double (&a)[3], const double (&b)[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  double volume(double t) const {
    const Corners k = at(t);
    return dot_of(k.n, k.p);
  }
  bool inside(double t, Real (&weight)[3]) const {
    const Corners k = at(t);
    const double nn = dot_of(k.n, k.n);
    if (!(nn > 0)) return false;
    double pv[3], up[3];
    cross_of(k.p, k.v, pv), cross_of(k.u, k.p, up);
    const double w1 = dot_of(k.n, pv) / nn, w2 = dot_of(k.n, up) / nn, w0 = 1 - w1 - w2;
    if (std::min({w0, w1, w2}) < -kRounding) return false;
    weight[0] = static_cast<Real>(w0), weight[1] = static_cast<Real>(w1), weight[2] = static_cast<Real>(w2);
    return true;
  }

  double p_[3], dp_[3], c_[3][3], dc_[3][3];
};

}  // namespace feder
