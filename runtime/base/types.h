// The scalar and the small fixed-size types of the whole project. The only place that names Eigen types.
// SI units, radians, y up, right-handed.
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>

// On 64-bit ARM Eigen's packets would round otherwise than on x86: products fuse multiply and add (intrinsics, which
// -ffp-contract=off does not reach) and floats are also added in pairs, as packets of two, where x86 has only packets
// of four. Neither here; tests/base/test_rounding.cpp holds the bits of products and sums.
#if defined(__aarch64__) && defined(__ARM_FEATURE_FMA)
#pragma push_macro("__ARM_FEATURE_FMA")
#undef __ARM_FEATURE_FMA
#include <Eigen/Core>
#pragma pop_macro("__ARM_FEATURE_FMA")
#else
#include <Eigen/Core>
#endif
#if defined(__aarch64__) && defined(EIGEN_VECTORIZE_NEON)
namespace Eigen::internal {
template <>
struct find_best_packet<float, 3> {
  using type = Packet4f;
};
template <>
struct find_best_packet<float, 9> {
  using type = Packet4f;
};
}  // namespace Eigen::internal
#endif

namespace feder {

#ifdef FEDER_REAL_DOUBLE
using Real = double;
inline constexpr const char* kRealName = "double";
#else
using Real = float;
inline constexpr const char* kRealName = "float";
#endif

using Vec2 = Eigen::Matrix<Real, 2, 1, Eigen::DontAlign>;
using Vec3 = Eigen::Matrix<Real, 3, 1, Eigen::DontAlign>;
using Mat3 = Eigen::Matrix<Real, 3, 3, Eigen::DontAlign>;

// Where float would drown small numbers beside large ones: matrices of stiff systems.
using Vec3d = Eigen::Matrix<double, 3, 1, Eigen::DontAlign>;
using Mat3d = Eigen::Matrix<double, 3, 3, Eigen::DontAlign>;

inline constexpr Real kPi = Real(3.14159265358979323846);
inline constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
inline constexpr Real kEpsilon = std::numeric_limits<Real>::epsilon();
inline constexpr std::uint32_t kNone = 0xffffffffu;  // "no index" everywhere

}  // namespace feder
