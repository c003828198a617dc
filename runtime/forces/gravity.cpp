// A uniform field beside the world's gravity: f = m a. Potential -m a.x.
#include "feder/force.h"

namespace feder {
namespace {

class Gravity final : public Force {
 public:
  explicit Gravity(const Params& p) : acceleration_(p.vector({"acceleration", "m/s2"}, Vec3(0, Real(-9.81), 0))) {}

  void add(const MassPoint* points, std::size_t count, double, Vec3* out) const override {
    for (std::size_t i = 0; i < count; ++i) out[i] += points[i].mass * acceleration_;
  }
  double potential(const MassPoint* points, std::size_t count) const override {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i)
      sum -= static_cast<double>(points[i].mass) * static_cast<double>(dot(acceleration_, points[i].position));
    return sum;
  }
  bool depends_on_velocity() const override { return false; }

 private:
  Vec3 acceleration_;  // m/s^2
};

}  // namespace

Variant<Force> forces_gravity() { return variant_of<Force, Gravity>("gravity", "a uniform field: acceleration"); }

}  // namespace feder
