// Buoyancy in a liquid below the plane y = height: the lift of the displaced volume and a linear drag against the
// liquid, both scaled by the immersed share. The body counts as a ball of its volume V, so the share is that of a
// ball's cap at depth s above its lowest point: q(s) = s^2 (3r - s)/(4 r^3), 0 <= s <= 2r.
// V: option `volume`, else the object's own, else mass / object_density. Potential: rho g V times the integral of q.
// Weak spot: lift acts on the centre of mass, so a floating box does not right itself.
#include <algorithm>

#include "feder/force.h"

namespace feder {
namespace {

// Cube root by Newton's method from a power of two: the same bits everywhere.
double cube_root(double x) {
  if (!(x > 0)) return 0;
  int e = 0;
  std::frexp(x, &e);
  double y = std::ldexp(1.0, (e + 2) / 3);
  for (int k = 0; k < 8; ++k) y -= (y - x / (y * y)) / 3;
  return y;
}

class Buoyancy final : public Force {
 public:
  explicit Buoyancy(const Params& p)
      : height_(p.number({"height", "m"}, 0)), density_(p.number({"density", "kg/m3", {0, 1e6}}, 1000)),
        gravity_(p.number({"gravity", "m/s2", {0, 1e6}}, 9.81)),
        volume_(p.number({"volume", "m3", {0, 1e12}}, kAbsent)),
        object_density_(p.number({"object_density", "kg/m3", {1e-6, 1e6}}, 500)),
        drag_(p.real({"drag", "kg/s", {0, 1e12}}, 0)), flow_(p.vector({"velocity", "m/s"}, Vec3(0, 0, 0))) {}

  void add(const MassPoint* points, std::size_t count, double, Vec3* out) const override {
    for (std::size_t i = 0; i < count; ++i) {
      const double v = volume(points[i]), r = radius(v), s = depth(points[i], r);
      const double share = immersed(s, r);
      out[i][1] += static_cast<Real>(density_ * gravity_ * v * share);
      out[i] -= std::min(drag_ * static_cast<Real>(share), points[i].most_drag) * (points[i].velocity - flow_);
    }
  }
  double potential(const MassPoint* points, std::size_t count) const override {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double v = volume(points[i]), r = radius(v), s = depth(points[i], r);
      if (!(s > 0)) continue;
      const double rise = s < 2 * r ? s * s * s * (r - s / 4) / (4 * r * r * r) : s - r;  // integral of q
      sum += density_ * gravity_ * v * rise;
    }
    return sum;
  }

 private:
  double volume(const MassPoint& p) const {
    if (volume_ >= 0) return volume_;
    return p.volume > 0 ? static_cast<double>(p.volume) : static_cast<double>(p.mass) / object_density_;
  }
  static double radius(double volume) { return cube_root(volume * 0.238732414637843); }  // 3/(4 pi)
  double depth(const MassPoint& p, double r) const { return height_ - static_cast<double>(p.position[1]) + r; }
  static double immersed(double s, double r) {
    if (!(s > 0)) return 0;
    return s < 2 * r ? s * s * (3 * r - s) / (4 * r * r * r) : 1;
  }

  double height_;          // m
  double density_;         // of the liquid, kg/m^3
  double gravity_;         // m/s^2, downwards
  double volume_;          // m^3; NaN: by object
  double object_density_;  // kg/m^3
  Real drag_;              // N s/m when fully immersed
  Vec3 flow_;              // velocity of the liquid, m/s
};

}  // namespace

Variant<Force> forces_buoyancy() {
  return variant_of<Force, Buoyancy>(
      "buoyancy", "lift and drag below a plane: height, density, gravity, volume, object_density, drag, velocity");
}

}  // namespace feder
