// Faces are squares in the planes that all other planes cut. Volume by the divergence theorem: a third of the sum over
// faces of area times distance from an inner point.
#include "bounds/polytope.h"

#include <cmath>

namespace feder {
namespace {

constexpr double kShortest = 1e-6;  // edge, of the size: where many planes meet, rounding makes shorter ones

struct FaceCorner {
  Double3 at;
  std::size_t plane;  // whose plane makes the edge from here to the next one
};
using FaceLoop = std::vector<FaceCorner>;

void cut_face(FaceLoop& face, const HalfSpace& by, std::size_t plane, FaceLoop& cut) {
  cut.clear();
  for (std::size_t i = 0; i < face.size(); ++i) {
    const FaceCorner &a = face[i], &b = face[(i + 1) % face.size()];
    const double da = dot(by.normal, a.at) - by.offset, db = dot(by.normal, b.at) - by.offset;
    if (da <= 0) cut.push_back({a.at, da == 0 && db > 0 ? plane : a.plane});
    if ((da < 0 && db > 0) || (da > 0 && db < 0))
      cut.push_back({a.at + da / (da - db) * (b.at - a.at), da < 0 ? plane : a.plane});
  }
  face.swap(cut);
}

// visit(number of the plane, unit normal, offset, face) while it returns true.
template <class F>
bool each_face(const std::vector<HalfSpace>& planes, double size, F&& visit) {
  FaceLoop face, cut;
  for (std::size_t k = 0; k < planes.size(); ++k) {
    const double n2 = dot(planes[k].normal, planes[k].normal);
    if (!(n2 > 0)) continue;
    const Double3 n = 1 / std::sqrt(n2) * planes[k].normal;
    const double at = planes[k].offset / std::sqrt(n2);
    const Double3 other = std::abs(n.x) < 0.7 ? Double3{1, 0, 0} : Double3{0, 1, 0};
    Double3 u = cross(n, other);
    u = 1 / length(u) * u;
    const Double3 v = cross(n, u), c = at * n;
    face = {{c + 2 * size * (u + v), k},
            {c + 2 * size * (v - u), k},
            {c - 2 * size * (u + v), k},
            {c + 2 * size * (u - v), k}};
    for (std::size_t j = 0; j < planes.size() && !face.empty(); ++j)
      if (j != k) cut_face(face, planes[j], j, cut);
    if (!visit(k, n, at, face)) return false;
  }
  return true;
}

}  // namespace

double volume_within(const std::vector<HalfSpace>& planes, double size) {
  double sum = 0;
  each_face(planes, size, [&](std::size_t, const Double3& n, double at, const FaceLoop& face) {
    double area = 0;
    for (std::size_t i = 2; i < face.size(); ++i)
      area += dot(n, cross(face[i - 1].at - face[0].at, face[i].at - face[0].at)) / 2;
    sum += area * at / 3;
    return true;
  });
  return sum;
}

bool edges_within(const std::vector<HalfSpace>& planes, double size, EdgeVisitor visit) {
  return each_face(planes, size, [&](std::size_t k, const Double3&, double, const FaceLoop& face) {
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Double3 &a = face[i].at, &b = face[(i + 1) % face.size()].at;
      // an edge of two faces is that of the first
      if (face[i].plane <= k || !(length(b - a) > kShortest * size)) continue;
      if (!visit(narrow(a), narrow(b))) return false;
    }
    return true;
  });
}

}  // namespace feder
