#include "geom/triangle_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "geom/closest.h"
#include "geom/winding.h"

namespace feder {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;
constexpr double kFar = 2.5;  // of a node's reach: farther than this it is a dipole
constexpr int kDeepest = 64;

Real distance_to_box(const Aabb& box, const Vec3& p) {  // squared
  Real sum = 0;
  for (int k = 0; k < 3; ++k) {
    const Real d = std::max(std::max(box.lo[k] - p[k], p[k] - box.hi[k]), Real(0));
    sum += d * d;
  }
  return sum;
}

}  // namespace

TriangleField::TriangleField(std::vector<Vec3> corners) : corners_(std::move(corners)) {
  std::vector<std::uint32_t> order(count());
  std::iota(order.begin(), order.end(), 0u);
  build(order);
  std::vector<Vec3> sorted;
  sorted.reserve(corners_.size());
  for (const std::uint32_t i : order)
    for (std::size_t k = 0; k < 3; ++k) sorted.push_back(corners_[3 * std::size_t(i) + k]);
  corners_ = std::move(sorted);
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    Node& n = nodes_[i];
    std::uint32_t from = n.first, to = n.first + n.count;
    if (n.count == 0) {  // the triangles below are one range
      const Node *left = &nodes_[n.first], *right = &nodes_[n.first + 1];
      while (left->count == 0) left = &nodes_[left->first];
      while (right->count == 0) right = &nodes_[right->first + 1];
      from = left->first, to = right->first + right->count;
    }
    sum(n, from, to);
  }
  box_ = nodes_[0].box;
  measure();
}

void TriangleField::build(std::vector<std::uint32_t>& order) {
  struct Range {
    std::uint32_t node, from, to;
  };
  std::vector<Vec3> middle;
  middle.reserve(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    middle.push_back((corners_[3 * i] + corners_[3 * i + 1] + corners_[3 * i + 2]) / 3);
  nodes_.emplace_back();
  std::vector<Range> open{{0, 0, static_cast<std::uint32_t>(order.size())}};
  while (!open.empty()) {
    const Range r = open.back();
    open.pop_back();
    if (r.to - r.from <= kLeafTriangles) {
      nodes_[r.node].first = r.from, nodes_[r.node].count = r.to - r.from;
      continue;
    }
    Aabb box;
    for (std::uint32_t k = r.from; k < r.to; ++k) box.include(middle[order[k]]);
    int axis = 0;
    const Vec3 side = box.hi - box.lo;
    for (int k = 1; k < 3; ++k)
      if (side[k] > side[axis]) axis = k;
    const std::uint32_t half = (r.from + r.to) / 2;
    std::nth_element(order.begin() + r.from, order.begin() + half, order.begin() + r.to,
                     [&](std::uint32_t i, std::uint32_t j) {
                       return middle[i][axis] != middle[j][axis] ? middle[i][axis] < middle[j][axis] : i < j;
                     });
    const auto child = static_cast<std::uint32_t>(nodes_.size());
    nodes_[r.node].first = child, nodes_[r.node].count = 0;
    nodes_.resize(nodes_.size() + 2);
    open.push_back({child, r.from, half}), open.push_back({child + 1, half, r.to});
  }
}

void TriangleField::sum(Node& n, std::uint32_t from, std::uint32_t to) const {
  Double3 middle{0, 0, 0};
  double area = 0;
  n.across = {0, 0, 0};
  n.box = Aabb{};
  for (std::uint32_t i = from; i < to; ++i) {
    const Vec3* c = &corners_[3 * std::size_t(i)];
    const Double3 a = wide(c[0]), b = wide(c[1]), d = wide(c[2]), across = 0.5 * cross(b - a, d - a);
    const double size = length(across);
    n.across = n.across + across, area += size;
    middle = middle + (size / 3) * (a + b + d);
    for (std::size_t k = 0; k < 3; ++k) n.box.include(c[k]);
  }
  n.middle = area > 0 ? (1 / area) * middle : wide(corners_[3 * std::size_t(from)]);
  n.reach = 0;
  for (std::size_t i = 3 * std::size_t(from); i < 3 * std::size_t(to); ++i)
    n.reach = std::max(n.reach, length(wide(corners_[i]) - n.middle));
}

Real TriangleField::distance_squared(const Vec3& p, std::uint32_t triangle) const {
  const Vec3* c = &corners_[3 * std::size_t(triangle)];
  const Vec3 d = p - closest_on_triangle(p, c[0], c[1], c[2]);
  return dot(d, d);
}

Real TriangleField::nearest(const Vec3& p, Real limit, std::uint32_t& triangle) const {
  triangle = kNone;
  Real best = limit * limit;
  struct Open {
    std::uint32_t node;
    Real near;
  } stack[kDeepest];
  int top = 0;
  stack[top++] = {0, distance_to_box(nodes_[0].box, p)};
  while (top > 0) {
    const Open at = stack[--top];
    if (!(at.near < best)) continue;
    const Node& n = nodes_[at.node];
    for (std::uint32_t i = n.first; i < n.first + n.count; ++i)
      if (const Real d = distance_squared(p, i); d < best) best = d, triangle = i;
    if (n.count > 0) continue;
    Open left{n.first, distance_to_box(nodes_[n.first].box, p)};
    Open right{n.first + 1, distance_to_box(nodes_[n.first + 1].box, p)};
    if (left.near < right.near) std::swap(left, right);
    stack[top++] = left, stack[top++] = right;  // the nearer next
  }
  return best;
}

double TriangleField::winding(const Vec3& p) const {
  const Double3 at = wide(p);
  double turns = 0;
  std::uint32_t stack[kDeepest];
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& n = nodes_[stack[--top]];
    const Double3 to = n.middle - at;
    const double far = length(to);
    if (far > kFar * n.reach) {
      turns += dot(n.across, to) / (far * far * far * (4 * 3.14159265358979323846));
    } else if (n.count > 0) {
      turns += winding_number({&corners_[3 * std::size_t(n.first)], 3 * std::size_t(n.count)}, p);
    } else {
      stack[top++] = n.first + 1, stack[top++] = n.first;
    }
  }
  return turns;
}

Real TriangleField::signed_distance(const Vec3& p) const {
  std::uint32_t triangle;
  const Real d = std::sqrt(nearest(p, kInfinity, triangle));
  return winding(p) > 0.5 ? -d : d;
}

// Volume by tetrahedra about the middle of the box; holes by chains of edges that one triangle alone has.
void TriangleField::measure() {
  const Double3 middle = wide((box_.lo + box_.hi) / 2);
  using Place = std::array<Real, 3>;
  const auto place = [](const Vec3& v) { return Place{v[0], v[1], v[2]}; };
  std::vector<std::pair<Place, Place>> edges, back;
  edges.reserve(corners_.size());
  for (std::size_t i = 0; i < corners_.size(); i += 3) {
    const Double3 a = wide(corners_[i]) - middle, b = wide(corners_[i + 1]) - middle,
                  c = wide(corners_[i + 2]) - middle;
    volume_ += dot(a, cross(b, c)) / 6;
    area_ += length(cross(b - a, c - a)) / 2;
    for (std::size_t k = 0; k < 3; ++k) edges.emplace_back(place(corners_[i + k]), place(corners_[i + (k + 1) % 3]));
  }
  for (const auto& e : edges) back.emplace_back(e.second, e.first);
  std::sort(edges.begin(), edges.end()), std::sort(back.begin(), back.end());
  std::vector<std::pair<Place, Place>> open;  // those that none runs along the other way
  std::set_difference(edges.begin(), edges.end(), back.begin(), back.end(), std::back_inserter(open));
  open_edges_ = open.size();
  std::multimap<Place, Place> next(open.begin(), open.end());
  const auto vector = [&](const Place& p) { return Double3{double(p[0]), double(p[1]), double(p[2])} - middle; };
  while (!next.empty()) {
    const Place start = next.begin()->first;
    Double3 across{0, 0, 0};
    for (auto edge = next.find(start); edge != next.end();) {
      const Place to = edge->second;
      across = across + 0.5 * cross(vector(edge->first), vector(to));
      next.erase(edge);
      edge = to == start ? next.end() : next.find(to);
    }
    open_ += length(across);
  }
}

}  // namespace feder
