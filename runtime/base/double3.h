// Three doubles, for geometry in double whatever Real is: quickhull, GJK and EPA subtract nearly equal areas.
#pragma once
#include <cmath>

#include "feder/types.h"

namespace feder {

struct Double3 {
  double x, y, z;  // no defaults: EPA keeps hundreds of these on the stack
};

inline Double3 wide(const Vec3& v) { return {double(v[0]), double(v[1]), double(v[2])}; }
inline Vec3 narrow(const Double3& v) { return Vec3(Real(v.x), Real(v.y), Real(v.z)); }
inline Double3 operator+(const Double3& a, const Double3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Double3 operator-(const Double3& a, const Double3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Double3 operator-(const Double3& a) { return {-a.x, -a.y, -a.z}; }
inline Double3 operator*(double s, const Double3& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Double3& a, const Double3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Double3 cross(const Double3& a, const Double3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const Double3& a) { return std::sqrt(dot(a, a)); }

}  // namespace feder
