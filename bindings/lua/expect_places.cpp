// Expectations of where the points of objects are: boxes, heights, places; angle, stretch, volume.
#include <algorithm>
#include <cmath>

#include "lua/buffer.h"
#include "lua/expect_objects.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

double distance(const double* a, const double* b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

struct Box {
  double min[3], max[3];
  bool has(const double* p) const {
    bool inside = true;
    for (int k = 0; k < 3; ++k) inside = inside && p[k] >= min[k] && p[k] <= max[k];  // false for NaN
    return inside;
  }
  std::string text() const { return point_text(min) + " to " + point_text(max); }
};

// {min, max}, the corners in either order
Box box_argument(lua_State* L, int index) {
  if (lua_type(L, index) != LUA_TTABLE) fail_here(L, "expected a box {min, max}, got " + describe(L, index));
  if (lua_rawlen(L, index) != 2) fail_here(L, "expected a box {min, max}: two points {x, y, z}");
  Box box;
  each_entry(L, index, [&](lua_Integer n) {
    const Vec3 v = check_vector(L, -1, function_name(L));
    for (int k = 0; k < 3; ++k) (n == 1 ? box.min : box.max)[k] = static_cast<double>(v[k]);
  });
  for (int k = 0; k < 3; ++k)
    if (box.min[k] > box.max[k]) std::swap(box.min[k], box.max[k]);
  return box;
}

// All points of every object must pass; `wanted` says what is tested.
int expect_of_points(lua_State* L, double within, const std::string& wanted,
                     const std::function<bool(const double* point)>& passes) {
  return expect_of_objects(L, Wait::within, within, wanted, "", [&](std::size_t, Offender& offender) {
    const Points points = points_of(L, -1);
    for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
      if (passes(&points[i])) continue;
      offender.actual =
          (points.size() > 3 ? "point " + std::to_string(i / 3 + 1) + " at " : "") + point_text(&points[i]);
      return false;
    }
    return true;
  });
}

// (object, {min, max}, [within])
int expect_inside(lua_State* L) {
  const Box box = box_argument(L, 2);
  return expect_of_points(L, time_argument(L, 3, 0), "inside " + box.text(),
                          [&](const double* p) { return box.has(p); });
}

// (object, height, [within])
template <bool kAbove>
int expect_beyond(lua_State* L) {
  const double height = check_number(L, 2, function_name(L));
  const std::string wanted = std::string(kAbove ? "above y = " : "below y = ") + print_number(height);
  return expect_of_points(L, time_argument(L, 3, 0), wanted,
                          [&](const double* p) { return kAbove ? p[1] > height : p[1] < height; });
}

// (object, {min, max}, n | {least, most}, [within]): points of all objects together
int expect_particles_in(lua_State* L) {
  const Box box = box_argument(L, 2);
  const CountRange range = count_argument(L, 3);
  WorldRecord& record = tested_objects(L);
  std::int64_t count = 0;
  const bool holds = wait_until(L, record, time_argument(L, 4, 0), [&] {
    count = 0;
    each_entry(L, 1, [&](lua_Integer) {
      check_object(L, -1, record, function_name(L));
      const Points points = points_of(L, -1);
      for (std::size_t i = 0; i + 2 < points.size(); i += 3) count += box.has(&points[i]);
    });
    return range.has(count);
  });
  return push(L, expected(L, holds, failure_of("particles in " + box.text(), range.text(), std::to_string(count))));
}

// Numbers: (value, wanted, tolerance)
int expect_near_number(lua_State* L, double tolerance) {
  const double value = lua_tonumber(L, 1), wanted = check_number(L, 2, function_name(L));
  CheckFailure f{.expected = print_number(wanted),
                 .actual = print_number(value),
                 .tolerance = print_number(tolerance),
                 .delta = print_number(std::abs(value - wanted))};
  f.message = "expected " + f.expected + " within " + f.tolerance + ", got " + f.actual;
  return push(L, expected(L, std::abs(value - wanted) <= tolerance, f));
}

// (object, {x, y, z}, tolerance, [within]): the centre of its points
int expect_near(lua_State* L) {
  const double tolerance = check_number(L, 3, function_name(L), kNotNegative);
  if (lua_type(L, 1) == LUA_TNUMBER) return expect_near_number(L, tolerance);
  const Vec3 v = check_vector(L, 2, function_name(L));
  const double wanted[] = {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
  return expect_of_objects(L, Wait::within, time_argument(L, 4, 0), "at " + point_text(wanted),
                           print_number(tolerance) + " m", [&](std::size_t, Offender& offender) {
                             const Points points = points_of(L, -1);
                             double center[3] = {0, 0, 0};
                             for (std::size_t i = 0; i < points.size(); ++i) center[i % 3] += points[i];
                             for (double& x : center) x /= std::max(1.0, static_cast<double>(points.size()) / 3);
                             offender.delta = print_number(distance(center, wanted)) + " m";
                             offender.actual = point_text(center) + ", " + offender.delta + " away";
                             return !points.empty() && distance(center, wanted) <= tolerance;
                           });
}

// A number of the object on top of the stack.
using Measure = double (*)(lua_State* L);

double number_of(lua_State* L, const char* method, const char* needs) {
  if (!has_method(L, -1, method)) fail_here(L, std::string("expected ") + needs + ", got " + describe(L, -1));
  const int n = call_method_of(L, -1, method);
  const double x = lua_tonumber(L, -n);
  lua_pop(L, n);
  return x;
}

// Of a body's own y axis from the vertical, of a hinge since it was made.
double angle_of(lua_State* L) {
  if (!has_method(L, -1, "rotation")) return number_of(L, "angle", "a body or a hinge");
  const int n = call_method_of(L, -1, "rotation");
  const double x = lua_tonumber(L, -n), z = lua_tonumber(L, -n + 2);
  lua_pop(L, n);
  return std::acos(std::clamp(1 - 2 * (x * x + z * z), -1.0, 1.0));
}

double strain_of(lua_State* L) { return number_of(L, "strain", "a cloth or a net"); }

// What the triangles of a closed cloth hold, as tetrahedra with the origin; of others by their method.
double volume_of(lua_State* L) {
  if (!has_method(L, -1, "triangles")) return number_of(L, "volume", "a fluid or a cloth");
  const Points x = points_of(L, -1);
  call_method_of(L, -1, "triangles");
  const std::span<double> corners = test_buffer(L, -1);
  double sum = 0;
  for (std::size_t t = 0; t + 2 < corners.size(); t += 3) {
    const auto corner = [&](std::size_t k) { return &x.at(3 * static_cast<std::size_t>(corners[t + k] - 1)); };
    const double *p = corner(0), *q = corner(1), *r = corner(2);
    sum += p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) + p[2] * (q[0] * r[1] - q[1] * r[0]);
  }
  lua_pop(L, 1);
  return std::abs(sum) / 6;
}

// (object, wanted, tolerance, [within])
int expect_measure(lua_State* L, Measure measure, const char* what, const char* unit) {
  const double wanted = check_number(L, 2, function_name(L)),
               tolerance = check_number(L, 3, function_name(L), kNotNegative);
  return expect_of_objects(L, Wait::within, time_argument(L, 4, 0), what + print_number(wanted) + unit,
                           print_number(tolerance) + unit, [&](std::size_t, Offender& offender) {
                             const double now = measure(L);
                             offender.actual = print_number(now) + unit;
                             offender.delta = print_number(std::abs(now - wanted)) + unit;
                             return std::abs(now - wanted) <= tolerance;
                           });
}

int expect_angle(lua_State* L) { return expect_measure(L, angle_of, "an angle of ", " rad"); }
int expect_volume(lua_State* L) {
  return expect_measure(L, volume_of, "a volume of ", tested_objects(L).planar() ? " m2" : " m3");
}

// (object, limit, [during])
int expect_stretch(lua_State* L) {
  const double limit = check_number(L, 2, function_name(L), kNotNegative);
  return expect_of_objects(L, Wait::during, time_argument(L, 3, 0), "a stretch of at most " + print_number(limit), "",
                           [&](std::size_t, Offender& offender) {
                             const double now = strain_of(L);
                             offender.actual = print_number(now);
                             offender.delta = print_number(now - limit);
                             return now <= limit;
                           });
}

const Method kPlaceExpectations[] = {
    {"inside", guard<expect_inside>, "expect.inside(object | {objects}, {min, max}, [within = 0]) -> boolean",
     "all of its points in the box"},
    {"above", guard<expect_beyond<true>>, "expect.above(object | {objects}, height, [within = 0]) -> boolean",
     "all of its points above y = height, m"},
    {"below", guard<expect_beyond<false>>, "expect.below(object | {objects}, height, [within = 0]) -> boolean",
     "all of its points below y = height, m"},
    {"near", guard<expect_near>, "expect.near(object | number, {x, y, z} | number, tolerance, [within = 0]) -> boolean",
     "the centre of its points at a place, or a number at another"},
    {"angle", guard<expect_angle>, "expect.angle(object | {objects}, radians, tolerance, [within = 0]) -> boolean",
     "of a hinge since it was made, or of a body's own y axis from the vertical"},
    {"stretch", guard<expect_stretch>, "expect.stretch(object | {objects}, limit, [during = 0]) -> boolean",
     "largest strain of the edges of a cloth, or of the springs of a net"},
    {"volume", guard<expect_volume>, "expect.volume(object | {objects}, wanted, tolerance, [within = 0]) -> boolean",
     "of a fluid, or of what a closed cloth holds, m3"},
    {"particles_in", guard<expect_particles_in>,
     "expect.particles_in(object | {objects}, {min, max}, n | {least, most}, [within = 0]) -> boolean",
     "so many particles, vertices or points of all of them together in the box"},
};

}  // namespace

std::span<const Method> place_expectations() { return kPlaceExpectations; }

}  // namespace feder::lua
