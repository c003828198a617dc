// All triangles are summed. tan(angle/2) = det(a, b, c) / (|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|), by the
// quadrant.
#include "geom/winding.h"

#include <cmath>

#include "base/double3.h"

namespace feder {

double winding_number(std::span<const Vec3> corners, const Vec3& p) {
  const Double3 at = wide(p);
  double sum = 0;
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    const Double3 a = wide(corners[i]) - at, b = wide(corners[i + 1]) - at, c = wide(corners[i + 2]) - at;
    const double la = length(a), lb = length(b), lc = length(c);
    sum += std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (2 * 3.14159265358979323846);
}

}  // namespace feder
