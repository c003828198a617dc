// Wind: drag against the velocity u relative to moving air,
//   f = -(linear + density coefficient area |u| / 2) u,  u = v - wind.
// `area` is used for all points when given; else the object's own cross-section, or kDefaultArea where it has none.
// Gusts scale the wind by 1 + gust (sin(w t) + sin(g w t))/2 with g the golden ratio, so that they never repeat, yet
// depend on the simulated time only. Weak spot: no wind shadow, and the whole field breathes at once.
#include <algorithm>

#include "feder/force.h"

namespace feder {
namespace {

constexpr Real kDefaultArea = Real(0.01);  // m^2: a palm-sized point
constexpr double kGoldenRatio = 1.6180339887498949;

class Wind final : public Force {
 public:
  explicit Wind(const Params& p)
      : velocity_(p.vector({"velocity", "m/s"}, Vec3(0, 0, 0))), linear_(p.real({"linear", "kg/s", {0, 1e12}}, 0)),
        half_density_(static_cast<Real>(0.5 * p.number({"density", "kg/m3", {0, 1e6}}, 1.2) *
                                        p.number({"coefficient", "", {0, 1e6}}, 1))),
        area_(p.real({"area", "m2", {0, 1e9}}, kAbsent)), gust_(p.number({"gust", "", {0, 100}}, 0)),
        gust_speed_(6.283185307179586 * p.number({"gust_hertz", "Hz", {0, 1000}}, 0.5)) {}

  bool on_area() const override { return true; }

  void add(const MassPoint* points, std::size_t count, double time, Vec3* out) const override {
    double scale = 1;
    if (gust_ > 0) {
      const double phase = gust_speed_ * time;
      scale += 0.5 * gust_ * (sin_cos_sin(phase) + sin_cos_sin(kGoldenRatio * phase));
    }
    const Vec3 air = velocity_ * static_cast<Real>(scale);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 u = points[i].velocity - air;
      const Real own = points[i].area > 0 ? points[i].area : kDefaultArea;
      const Real area = area_ >= 0 ? area_ : own;
      out[i] -= std::min(linear_ + half_density_ * area * length(u), points[i].most_drag) * u;
    }
  }

 private:
  Vec3 velocity_;             // of the air, m/s
  Real linear_;               // N s/m
  Real half_density_;         // half the air's density times the drag coefficient, kg/m^3
  Real area_;                 // m^2; NaN: by object
  double gust_, gust_speed_;  // fraction, rad/s
};

}  // namespace

Variant<Force> forces_wind() {
  return variant_of<Force, Wind>(
      "wind", "drag against moving air: velocity, linear, density, coefficient, area, gust, gust_hertz");
}

}  // namespace feder
