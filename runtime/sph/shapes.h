// The shapes of smoothing kernels over u = r / support, each in two dimensions and three. W(r) = norm / support^D
// value(u); the derivatives are those of value(u): slope(u) = value' / u, second(u) = value'', laplacian(u) =
// value'' + (D - 1) value' / u. Written for one number and for eight lanes alike; all are zero from u = 1 on, so sums
// need no test of distance. Included by files compiled twice: no std, no Eigen.
//  - cubic: Monaghan & Lattanzio 1985, support 2h. wendland: Wendland 1995, C2, no pairing of particles.
//  - poly6, spiky, viscosity: Mueller, Charypar & Gross 2003; their 2D forms follow from the same conditions.
#pragma once
#include "base/simd.h"

namespace feder {
namespace {

using namespace lanes;

[[gnu::always_inline]] inline double positive(double x) { return x > 0 ? x : 0; }
[[gnu::always_inline]] inline Lanes positive(Lanes x) { return max(x, zero_lanes()); }
[[gnu::always_inline]] inline double choose(bool m, double a, double b) { return m ? a : b; }
[[gnu::always_inline]] inline Lanes choose(LaneMask m, Lanes a, Lanes b) { return m ? a : b; }

constexpr double kPiWide = 3.14159265358979323846;
typedef WideReal W;

struct CubicShape {
  static constexpr double kNorm[2] = {40 / (7 * kPiWide), 8 / kPiWide};
  template <class T>
  static T value(T u) {
    const T a = positive(W(1) - u), b = positive(W(1) - W(2) * u);
    return W(2) * (a * a * a) - b * b * b;
  }
  template <class T>
  static T slope(T u) {
    const T a = positive(W(1) - u);
    return choose(u < W(0.5), W(18) * u - W(12), W(-6) * a * a / u);
  }
  template <class T>
  static T second(T u) {
    return W(12) * positive(W(1) - u) - W(24) * positive(W(1) - W(2) * u);
  }
};

struct WendlandShape {
  static constexpr double kNorm[2] = {7 / kPiWide, 21 / (2 * kPiWide)};
  template <class T>
  static T value(T u) {
    const T a = positive(W(1) - u), b = a * a;
    return b * b * (W(1) + W(4) * u);
  }
  template <class T>
  static T slope(T u) {
    const T a = positive(W(1) - u);
    return W(-20) * a * a * a;
  }
  template <class T>
  static T second(T u) {
    const T a = positive(W(1) - u);
    return W(-20) * a * a * (W(1) - W(4) * u);
  }
};

// Its slope vanishes at u = 0: particles in one position are not pushed apart.
struct Poly6Shape {
  static constexpr double kNorm[2] = {4 / kPiWide, 315 / (64 * kPiWide)};
  template <class T>
  static T value(T u) {
    const T a = positive(W(1) - u * u);
    return a * a * a;
  }
  template <class T>
  static T slope(T u) {
    const T a = positive(W(1) - u * u);
    return W(-6) * a * a;
  }
  template <class T>
  static T second(T u) {
    return W(-6) * positive(W(1) - u * u) * (W(1) - W(5) * u * u);
  }
};

// Its slope at u = 0 has a direction but no limit: u is kept above 1e-3 there.
struct SpikyShape {
  static constexpr double kNorm[2] = {10 / kPiWide, 15 / kPiWide};
  template <class T>
  static T value(T u) {
    const T a = positive(W(1) - u);
    return a * a * a;
  }
  template <class T>
  static T slope(T u) {
    const T a = positive(W(1) - u);
    return W(-3) * a * a / choose(u < W(1e-3), u * W(0) + W(1e-3), u);
  }
  template <class T>
  static T second(T u) {
    return W(6) * positive(W(1) - u);
  }
};

// Made for its Laplacian, 1 - u, which is nowhere negative; infinite at u = 0.
struct ViscosityShape {
  static constexpr double kNorm[2] = {40 / kPiWide, 45 / kPiWide};
  template <class T>
  static T laplacian(T u) {
    return positive(W(1) - u);
  }
};

}  // namespace
}  // namespace feder
