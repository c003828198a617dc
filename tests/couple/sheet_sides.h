// Which particles have passed a sheet: an oracle by exact crossings of straight paths, independent of the coupling.
#pragma once
#include <cmath>
#include <vector>

#include "feder/cloth.h"
#include "feder/fluid.h"

namespace feder {

// Called after every substep. A particle has passed when its paths met the sheet's triangles an odd number of times;
// ways around the border do not count.
class SheetSides {
 public:
  void follow(const Cloth& cloth, ObjectId sheet, const Fluid& fluid, ObjectId water) {
    cloth.positions(sheet, to_), fluid.positions(water, x_);
    if (triangles_.empty()) cloth.triangles(sheet, triangles_);
    odd_.resize(x_.size(), false);
    for (std::size_t i = 0; i < was_.size() && !from_.empty(); ++i) {
      for (std::size_t t = 0; t + 2 < triangles_.size(); t += 3) {
        const std::uint32_t* v = &triangles_[t];
        if (far_apart(i, v)) continue;
        D a[4], b[4];
        a[0] = wide(was_[i]), b[0] = wide(x_[i]);
        for (int k = 0; k < 3; ++k) a[k + 1] = wide(from_[v[k]]), b[k + 1] = wide(to_[v[k]]);
        if (crossings(a, b) % 2 != 0) odd_[i] = !odd_[i];
      }
    }
    from_ = to_, was_ = x_;
  }
  int passed() const {
    int n = 0;
    for (const bool o : odd_) n += o;
    return n;
  }

 private:
  struct D {
    double x, y, z;
    friend D operator-(const D& a, const D& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  };
  static D wide(const Vec3& p) { return {p[0], p[1], p[2]}; }
  static double dot(const D& a, const D& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  static D cross(const D& a, const D& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }
  static D at(const D& a, const D& b, double t) {
    return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z)};
  }
  bool far_apart(std::size_t i, const std::uint32_t* v) const {
    for (int k = 0; k < 3; ++k) {
      const Real lo = std::min(was_[i][k], x_[i][k]), hi = std::max(was_[i][k], x_[i][k]);
      Real tl = kInfinity, th = -kInfinity;
      for (int j = 0; j < 3; ++j) {
        tl = std::min({tl, from_[v[j]][k], to_[v[j]][k]}), th = std::max({th, from_[v[j]][k], to_[v[j]][k]});
      }
      if (lo > th || hi < tl) return true;
    }
    return false;
  }
  // Six times the volume of the particle and the triangle at t.
  static double volume(const D (&a)[4], const D (&b)[4], double t) {
    const D p = at(a[0], b[0], t), u = at(a[1], b[1], t), v = at(a[2], b[2], t), w = at(a[3], b[3], t);
    return dot(cross(v - u, w - u), p - u);
  }
  static bool inside(const D (&a)[4], const D (&b)[4], double t) {
    const D p = at(a[0], b[0], t), u = at(a[1], b[1], t), v = at(a[2], b[2], t), w = at(a[3], b[3], t);
    const D n = cross(v - u, w - u);
    return dot(n, cross(v - u, p - u)) >= 0 && dot(n, cross(w - v, p - v)) >= 0 && dot(n, cross(u - w, p - w)) >= 0;
  }
  // The volume is a cubic of t: between its extremes it is monotonic.
  static int crossings(const D (&a)[4], const D (&b)[4]) {
    const double f0 = volume(a, b, 0), f1 = volume(a, b, 1), g = volume(a, b, 0.5), m = volume(a, b, -1);
    // c3 t^3 + c2 t^2 + c1 t + f0
    const double p = f1 - f0, q = m - f0, r = g - f0;
    const double c2 = (p + q) / 2, odd = (p - q) / 2, c3 = (odd / 2 - r + c2 / 4) * 8 / 3, c1 = odd - c3;
    double cut[4] = {0, 0, 0, 1};
    int n = 1;
    const double disc = c2 * c2 - 3 * c3 * c1;
    if (disc > 0) {
      const double s = std::sqrt(disc), h = -(c2 + (c2 >= 0 ? s : -s));
      double roots[2] = {h / (3 * c3), c1 / h};
      if (roots[0] > roots[1]) std::swap(roots[0], roots[1]);
      for (const double root : roots)
        if (root > 0 && root < 1) cut[n++] = root;
    }
    cut[n++] = 1;
    int count = 0;
    for (int k = 0; k + 1 < n; ++k) {
      double lo = cut[k], hi = cut[k + 1];
      const bool sign = volume(a, b, lo) < 0;
      if (sign == (volume(a, b, hi) < 0)) continue;
      for (int i = 0; i < 60; ++i) {
        const double mid = (lo + hi) / 2;
        ((volume(a, b, mid) < 0) == sign ? lo : hi) = mid;
      }
      count += inside(a, b, hi);
    }
    return count;
  }

  std::vector<Vec3> from_, to_, was_, x_;
  std::vector<std::uint32_t> triangles_;
  std::vector<bool> odd_;
};

}  // namespace feder
