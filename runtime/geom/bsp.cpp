// Built from the surface: a node takes the plane of one of its polygons, that which among a few splits least and parts
// best; polygons in the plane stay, others go before it or behind it, cut ones to both (Fuchs, Kedem & Naylor 1980;
// Naylor, Amanatides & Thibault 1990). Where no polygon is left before a plane, or behind it, that side lies outside,
// or inside. In double; corners nearer than kThick of the size to a plane lie in it. Weak spots: the planes of a convex
// surface part nothing, so its tree is a list; slivers of pieces thinner than kThick of the size vanish.
#include "geom/bsp.h"

#include <algorithm>
#include <cmath>

#include "feder/error.h"

namespace feder {
namespace {

constexpr double kThick = 1e-9;
constexpr std::size_t kTried = 12;  // planes

struct Polygon3 {
  std::uint32_t triangle;
  std::vector<Double3> corners;
};
struct CutPlane {
  Double3 normal{0, 0, 0};
  double offset = 0;
  double height(const Double3& p) const { return dot(normal, p) - offset; }
};

// Before: 1, behind: 2, both: 3, in it: 0.
int sides_of(const Polygon3& p, const CutPlane& plane, double thick) {
  int sides = 0;
  for (const Double3& c : p.corners) {
    const double h = plane.height(c);
    sides |= h > thick ? 1 : h < -thick ? 2 : 0;
  }
  return sides;
}

void cut(const Polygon3& p, const CutPlane& plane, double thick, Polygon3& before, Polygon3& behind) {
  before = {p.triangle, {}}, behind = {p.triangle, {}};
  for (std::size_t i = 0; i < p.corners.size(); ++i) {
    const Double3 &a = p.corners[i], &b = p.corners[(i + 1) % p.corners.size()];
    const double ha = plane.height(a), hb = plane.height(b);
    if (ha > -thick) before.corners.push_back(a);
    if (ha < thick) behind.corners.push_back(a);
    if ((ha > thick && hb < -thick) || (ha < -thick && hb > thick)) {
      const Double3 c = a + ha / (ha - hb) * (b - a);
      before.corners.push_back(c), behind.corners.push_back(c);
    }
  }
}

}  // namespace

Bsp::Bsp(std::span<const Vec3> corners) {
  const std::size_t count = corners.size() / 3;
  if (count > kMostTriangles)
    throw SceneError("bsp: expected at most " + std::to_string(kMostTriangles) + " triangles, got " +
                     std::to_string(count) + ": take index = \"bvh\"");
  Aabb all;
  for (const Vec3& c : corners) all.include(c);
  const double size = count > 0 ? length(wide(all.hi) - wide(all.lo)) : 0, thick = kThick * size;
  std::vector<CutPlane> planes;  // by triangle
  std::vector<Polygon3> start;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Double3 a = wide(corners[3 * i]), b = wide(corners[3 * i + 1]), c = wide(corners[3 * i + 2]);
    CutPlane plane;
    plane.normal = cross(b - a, c - a);
    const double n = length(plane.normal);
    plane.normal = (n > 0 ? 1 / n : 0) * plane.normal, plane.offset = dot(plane.normal, a);
    planes.push_back(plane);
    if (n > 0) start.push_back({i, {a, b, c}});
  }
  struct Task {
    std::vector<Polygon3> polygons;
    std::uint32_t parent;
    int side;
  };
  std::vector<Task> tasks;
  if (!start.empty()) tasks.push_back({std::move(start), kNone, 0});
  while (!tasks.empty()) {
    Task task = std::move(tasks.back());
    tasks.pop_back();
    // the plane
    const std::size_t tried = std::min(kTried, task.polygons.size());
    std::size_t best = 0;
    double least = 1e300;
    for (std::size_t t = 0; t < tried; ++t) {
      const std::size_t k = t * task.polygons.size() / tried;
      double before = 0, behind = 0, both = 0;
      for (const Polygon3& p : task.polygons) {
        const int s = sides_of(p, planes[task.polygons[k].triangle], thick);
        before += s == 1, behind += s == 2, both += s == 3;
      }
      const double cost = 4 * both + std::abs(before - behind);
      if (cost < least) least = cost, best = k;
    }
    const CutPlane plane = planes[task.polygons[best].triangle];
    const auto number = static_cast<std::uint32_t>(nodes_.size());
    if (task.parent != kNone) nodes_[task.parent].child[task.side] = number;
    Node node;
    node.normal = plane.normal, node.offset = plane.offset, node.first = static_cast<std::uint32_t>(pieces_.size());
    std::vector<Polygon3> before, behind;
    for (Polygon3& p : task.polygons) {
      switch (sides_of(p, plane, thick)) {
        case 0:
          pieces_.push_back(
              {p.triangle, static_cast<std::uint32_t>(corners_.size()), static_cast<std::uint32_t>(p.corners.size())});
          corners_.insert(corners_.end(), p.corners.begin(), p.corners.end());
          break;
        case 1: before.push_back(std::move(p)); break;
        case 2: behind.push_back(std::move(p)); break;
        default: {
          Polygon3 f, b;
          cut(p, plane, thick, f, b);
          before.push_back(std::move(f)), behind.push_back(std::move(b)), ++splits_;
        }
      }
    }
    node.count = static_cast<std::uint32_t>(pieces_.size()) - node.first;
    nodes_.push_back(node);
    if (!before.empty()) tasks.push_back({std::move(before), number, 0});
    if (!behind.empty()) tasks.push_back({std::move(behind), number, 1});
  }
}

bool Bsp::inside(const Vec3& p) const {
  const Double3 at = wide(p);
  bool in = false;
  for (std::uint32_t n = nodes_.empty() ? kNone : 0; n != kNone;) {
    in = !front(nodes_[n], at);
    n = nodes_[n].child[in ? 1 : 0];
  }
  return in;
}

std::size_t Bsp::bytes() const {
  return nodes_.size() * sizeof(Node) + pieces_.size() * sizeof(Stored) + corners_.size() * sizeof(Double3);
}

}  // namespace feder
