// Distance to a set of triangles and the winding number about a point, over one hierarchy of boxes. Sources: nearest
// by branch and bound over boxes; winding number with a dipole for what is far, Barill, Dickson, Schmidt, Levin &
// Jacobson, "Fast Winding Numbers for Soups and Clouds", SIGGRAPH 2018 (first order, beta = 2.5: within .02 of the sum,
// tests/geom/test_triangle_field.cpp).
#pragma once
#include <span>
#include <vector>

#include "base/double3.h"
#include "feder/types.h"

namespace feder {

class TriangleField {
 public:
  // `corners`: three per triangle, counterclockwise from outside; at least one triangle.
  explicit TriangleField(std::vector<Vec3> corners);

  std::size_t count() const { return corners_.size() / 3; }
  const Aabb& box() const { return box_; }
  std::span<const Vec3> corners() const { return corners_; }  // in the order of the hierarchy

  // Distance squared to the nearest triangle, and which that is; `limit` squared and kNone when none is nearer.
  Real nearest(const Vec3& p, Real limit, std::uint32_t& triangle) const;
  Real distance_squared(const Vec3& p, std::uint32_t triangle) const;
  // 1 inside a closed surface, 0 outside.
  double winding(const Vec3& p) const;
  // Negative inside.
  Real signed_distance(const Vec3& p) const;

  double volume() const { return volume_; }   // m3, below 0 when inside out
  double area() const { return area_; }       // m2
  double open_area() const { return open_; }  // m2, of what would close the holes
  std::size_t open_edges() const { return open_edges_; }

 private:
  struct Node {
    Aabb box;
    Double3 middle;              // centre of the triangles' area
    Double3 across;              // sum of the area vectors, m2
    double reach;                // of the triangles from `middle`, m
    std::uint32_t first, count;  // leaf: triangles; else count = 0 and `first` is the first of two children
  };
  void build(std::vector<std::uint32_t>& order);
  void sum(Node& n, std::uint32_t from, std::uint32_t to) const;
  void measure();

  std::vector<Vec3> corners_;
  std::vector<Node> nodes_;
  Aabb box_;
  double volume_ = 0, area_ = 0, open_ = 0;
  std::size_t open_edges_ = 0;
};

}  // namespace feder
