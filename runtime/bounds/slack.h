// What rounding may do to a test of volumes: they are made larger by it, so that no test misses.
#pragma once
#include <limits>

#include "feder/types.h"

namespace feder {

inline constexpr Real kVolumeSlack = 16 * std::numeric_limits<Real>::epsilon();

inline Real slack_of(const Vec3& p) { return kVolumeSlack * (std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2])); }
inline Real loosened(Real size, const Vec3& center) { return size * (1 + kVolumeSlack) + slack_of(center); }

}  // namespace feder
