// A spring from each point to a place in the world: f = -(stiffness (r - rest_length) + damping r') n.
// At r = 0 with a rest length the direction is undefined: x is used.
// Source: Hooke 1678. Weak spot: that direction, which a point passing the anchor sees turn over.
#include "feder/force.h"

namespace feder {
namespace {

class AnchorSpring final : public Force {
 public:
  explicit AnchorSpring(const Params& p)
      : position_(p.vector({"position", "m"}, Vec3(0, 0, 0))), stiffness_(p.real({"stiffness", "N/m", {0, 1e15}}, 100)),
        damping_(p.real({"damping", "N s/m", {0, 1e12}}, 0)), rest_length_(p.real({"rest_length", "m", {0, 1e9}}, 0)) {}

  void add(const MassPoint* points, std::size_t count, double, Vec3* out) const override {
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 d = points[i].position - position_;
      const Real r = length(d);
      const Vec3 n = normalized_or(d, Vec3(1, 0, 0));
      out[i] -= (stiffness_ * (r - rest_length_) + damping_ * dot(points[i].velocity, n)) * n;
    }
  }
  bool derivative(const MassPoint* points, std::size_t count, double, bool by_velocity, Mat3* out) const override {
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 d = points[i].position - position_;
      const Real r = length(d);
      const Vec3 n = normalized_or(d, Vec3(1, 0, 0));
      if (by_velocity) {
        out[i] -= damping_ * n * n.transpose();
        continue;
      }
      const Real across = rest_length_ == 0 ? stiffness_ : r > 0 ? stiffness_ * (1 - rest_length_ / r) : Real(0);
      out[i] -= (stiffness_ - across) * n * n.transpose();
      out[i].diagonal().array() -= across;
    }
    return true;
  }
  double potential(const MassPoint* points, std::size_t count) const override {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double stretch = static_cast<double>(length(points[i].position - position_) - rest_length_);
      sum += 0.5 * static_cast<double>(stiffness_) * stretch * stretch;
    }
    return sum;
  }

 private:
  Vec3 position_;     // m
  Real stiffness_;    // N/m
  Real damping_;      // N s/m
  Real rest_length_;  // m
};

}  // namespace

Variant<Force> forces_spring() {
  return variant_of<Force, AnchorSpring>("spring",
                                         "a spring to a place in the world: position, stiffness, damping, rest_length");
}

}  // namespace feder
