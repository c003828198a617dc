// Checks of a net's description before it is made: every number, and the message names its field.
#include <cmath>
#include <cstdio>

#include "springs/impl.h"

namespace feder {
namespace {

constexpr std::size_t kMaxPoints = 1u << 28;
constexpr int kMaxPower = 9;

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", x);
  return text;
}

std::string element(const char* list, std::size_t i) { return std::string(list) + "[" + std::to_string(i + 1) + "]"; }

// SceneError that names the net, the field and what was expected there.
struct Check {
  std::string owner;
  void operator()(bool ok, const std::string& what, const char* expected, double got) const {
    if (!ok) throw SceneError(owner + ": " + what + ": expected " + expected + ", got " + number(got));
  }
  // Of a field of element i of a list; its name is only put together for the message.
  void operator()(bool ok, const char* list, std::size_t i, const char* field, const char* expected, double got) const {
    if (!ok) (*this)(false, element(list, i) + field, expected, got);
  }
};

}  // namespace

void check_spring(const SpringDesc& s, std::size_t points, std::size_t k, const std::string& owner) {
  const Check check{owner};
  const auto need = [&](bool ok, const char* field, const char* expected, double got) {
    check(ok, "springs", k, field, expected, got);
  };
  need(s.i < points, "", "point numbers from 1 to the number of points", static_cast<double>(s.i) + 1);
  need(s.j < points, "", "point numbers from 1 to the number of points", static_cast<double>(s.j) + 1);
  need(s.i != s.j, "", "two different points", static_cast<double>(s.i) + 1);
  need(s.stiffness >= 0 && is_finite(s.stiffness), ".stiffness", "a finite number, 0 or more", s.stiffness);
  need(s.damping >= 0 && is_finite(s.damping), ".damping", "a finite number, 0 or more", s.damping);
  need(is_finite(s.rest_length), ".rest_length", "a finite number", s.rest_length);
  need(s.break_strain > 0, ".break_strain", "a number above 0", s.break_strain);
  need(s.power >= 1 && s.power <= kMaxPower, ".power", "a whole number from 1 to 9", s.power);
}

Real rest_length_of(const SpringDesc& s, const Vec3& a, const Vec3& b, std::size_t k, const std::string& owner) {
  const Real rest = s.rest_length < 0 ? length(b - a) : s.rest_length;
  if (!(rest > 0) && !std::isinf(s.break_strain))
    Check{owner}(false, element("springs", k) + ".rest_length", "a length above 0 where break_strain is given", rest);
  return rest;
}

void check_net(const NetDesc& d, const std::string& owner) {
  const Check need{owner};
  const std::size_t n = d.points.size();
  need(n > 0 && n <= kMaxPoints, "points", "at least one point", static_cast<double>(n));
  need(d.masses.size() == n, "masses", "one mass per point", static_cast<double>(d.masses.size()));
  need(d.velocities.empty() || d.velocities.size() == n, "velocities", "one per point",
       static_cast<double>(d.velocities.size()));
  for (std::size_t i = 0; i < n; ++i) {
    for (int k = 0; k < 3; ++k) {
      need(is_finite(d.points[i][k]), "points", i, "", "finite numbers", d.points[i][k]);
      if (d.velocities.empty()) continue;
      need(is_finite(d.velocities[i][k]), "velocities", i, "", "finite numbers", d.velocities[i][k]);
    }
    need(d.masses[i] > 0 && is_finite(1 / d.masses[i]) && is_finite(d.masses[i]), "masses", i, "",
         "a finite number above 0", d.masses[i]);
  }
  for (std::size_t k = 0; k < d.springs.size(); ++k) check_spring(d.springs[k], n, k, owner);
  need(d.faces.size() % 3 == 0, "faces", "three point numbers each", static_cast<double>(d.faces.size()));
  for (std::size_t k = 0; k < d.faces.size(); ++k)
    need(d.faces[k] < n, "faces", k / 3, "", "numbers of points", static_cast<double>(d.faces[k]) + 1);
  need(d.damping >= 0 && is_finite(d.damping), "damping", "a finite number, 0 or more", d.damping);
  need(d.radius >= 0 && is_finite(d.radius), "radius", "a finite number, 0 or more", d.radius);
  need(d.friction >= 0 && is_finite(d.friction), "friction", "a finite number, 0 or more", d.friction);
  need(d.restitution >= 0 && d.restitution <= 1, "restitution", "a number from 0 to 1", d.restitution);
  need(is_finite(d.gravity_scale), "gravity_scale", "a finite number", d.gravity_scale);
}

}  // namespace feder
