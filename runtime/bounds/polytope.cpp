// Volume by the divergence theorem: a third of the sum over faces of area times distance from an inner point.
#include "bounds/polytope.h"

#include <cmath>

namespace feder {

double volume_within(const std::vector<HalfSpace>& planes, double size) {
  double sum = 0;
  std::vector<Double3> face, cut;
  for (std::size_t k = 0; k < planes.size(); ++k) {
    const double n2 = dot(planes[k].normal, planes[k].normal);
    if (!(n2 > 0)) continue;
    const Double3 n = 1 / std::sqrt(n2) * planes[k].normal;
    const double at = planes[k].offset / std::sqrt(n2);
    const Double3 other = std::abs(n.x) < 0.7 ? Double3{1, 0, 0} : Double3{0, 1, 0};
    Double3 u = cross(n, other);
    u = 1 / length(u) * u;
    const Double3 v = cross(n, u), c = at * n;
    face = {c + 2 * size * (u + v), c + 2 * size * (v - u), c - 2 * size * (u + v), c + 2 * size * (u - v)};
    for (std::size_t j = 0; j < planes.size() && !face.empty(); ++j) {
      if (j == k) continue;
      const HalfSpace& p = planes[j];
      cut.clear();
      for (std::size_t i = 0; i < face.size(); ++i) {
        const Double3 &a = face[i], &b = face[(i + 1) % face.size()];
        const double da = dot(p.normal, a) - p.offset, db = dot(p.normal, b) - p.offset;
        if (da <= 0) cut.push_back(a);
        if ((da < 0 && db > 0) || (da > 0 && db < 0)) cut.push_back(a + da / (da - db) * (b - a));
      }
      face.swap(cut);
    }
    double area = 0;
    for (std::size_t i = 2; i < face.size(); ++i) area += dot(n, cross(face[i - 1] - face[0], face[i] - face[0])) / 2;
    sum += area * at / 3;
  }
  return sum;
}

}  // namespace feder
