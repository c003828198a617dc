// Linear and quadratic drag: f = -(linear + quadratic |v|) v. Linear in N s/m, quadratic in N s^2/m^2.
// Sources: Stokes 1851 (linear), Newton 1687 (quadratic). Weak spot: no share of the shape; a plate drags alike from
// all sides.
#include <algorithm>

#include "feder/force.h"

namespace feder {
namespace {

class Drag final : public Force {
 public:
  explicit Drag(const Params& p)
      : linear_(p.real({"linear", "kg/s", {0, 1e12}}, 0)), quadratic_(p.real({"quadratic", "kg/m", {0, 1e12}}, 0)) {}

  void add(const MassPoint* points, std::size_t count, double, Vec3* out) const override {
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3& v = points[i].velocity;
      out[i] -= v * std::min(linear_ + quadratic_ * length(v), points[i].most_drag);
    }
  }

 private:
  Real linear_, quadratic_;
};

}  // namespace

Variant<Force> forces_drag() {
  return variant_of<Force, Drag>("drag", "linear and quadratic drag against the velocity");
}

}  // namespace feder
