// Vectors of what is drawn: single precision in every build, laid out as drivers and files take them.
#pragma once
#include <algorithm>

#include "feder/types.h"

namespace feder::view {

struct Float3 {
  float x = 0, y = 0, z = 0;
  float& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
  float operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
  friend bool operator==(const Float3&, const Float3&) = default;
};

using feder::cross;  // of Vec3, beside those of Float3
using feder::dot;
using feder::length;

inline Float3 operator+(Float3 a, Float3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Float3 operator-(Float3 a, Float3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Float3 operator*(float s, Float3 a) { return {s * a.x, s * a.y, s * a.z}; }
inline Float3 operator/(Float3 a, float s) { return {a.x / s, a.y / s, a.z / s}; }
inline float dot(Float3 a, Float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline float length(Float3 a) { return std::sqrt(dot(a, a)); }
inline Float3 cross(Float3 a, Float3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Float3 min(Float3 a, Float3 b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
inline Float3 max(Float3 a, Float3 b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

inline Float3 to_float3(const Vec3& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}
inline Vec3 to_vec3(Float3 v) { return vec3(Real(v.x), Real(v.y), Real(v.z)); }

}  // namespace feder::view
