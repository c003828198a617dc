// The inside of closed surfaces by their binary space partition against the winding number, and the order from back to
// front against rays.
#include <cmath>
#include <map>

#include "base/rng.h"
#include "feder/error.h"
#include "geom/bsp.h"
#include "geom/closest.h"
#include "geom/winding.h"
#include "support/catch.h"

using namespace feder;

namespace {

// Quads of a closed surface by two angles; `of`(u, v) in turns.
template <class F>
std::vector<Vec3> wrapped(int m, int n, F&& of) {
  std::vector<Vec3> list;
  const auto at = [&](int i, int k) { return of(double(i % m) / m, double(k % n) / n); };
  for (int i = 0; i < m; ++i)
    for (int k = 0; k < n; ++k) {
      const Vec3 a = at(i, k), b = at(i + 1, k), c = at(i + 1, k + 1), d = at(i, k + 1);
      for (const Vec3& p : {a, b, c, a, c, d}) list.push_back(p);
    }
  return list;
}

std::vector<Vec3> torus(int m, int n, double bump) {
  return wrapped(m, n, [=](double u, double v) {
    const double s = 2 * 3.14159265358979323846 * u, t = 2 * 3.14159265358979323846 * v;
    const double small = 0.3 * (1 + bump * std::sin(5 * s) * std::cos(3 * t)), r = 1 + small * std::cos(t);
    return Vec3(static_cast<Real>(r * std::cos(s)), static_cast<Real>(small * std::sin(t)),
                static_cast<Real>(-r * std::sin(s)));
  });
}

void add_box(std::vector<Vec3>& list, const Vec3& lo, const Vec3& hi) {
  static const int kFaces[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  for (const auto& face : kFaces)
    for (const int corner : face)
      list.push_back(Vec3(corner & 1 ? hi[0] : lo[0], corner & 2 ? hi[1] : lo[1], corner & 4 ? hi[2] : lo[2]));
}

std::vector<Vec3> solid(const std::string& kind) {
  std::vector<Vec3> list;
  if (kind == "box") add_box(list, Vec3(-1, -1, -1), Vec3(1, 1, 1));
  if (kind == "torus") list = torus(24, 12, 0);
  if (kind == "bumpy") list = torus(30, 16, 0.4);
  if (kind == "boxes")  // apart, and with walls in one plane
    for (int i = -2; i < 3; ++i)
      add_box(list, Vec3(Real(i) * Real(0.5), -1, 0), Vec3(Real(i) * Real(0.5) + Real(0.3), 1, Real(0.5)));
  return list;
}

}  // namespace

TEST_CASE("winding numbers count how often a surface goes round a point", "[geom][bsp]") {
  std::vector<Vec3> box = solid("box");
  CHECK(winding_number(box, Vec3(Real(0.3), 0, Real(-0.2))) == Approx(1));
  CHECK(winding_number(box, Vec3(3, 0, 0)) == Approx(0).margin(1e-9));
  box.resize(30);  // one face is missing: a sixth
  CHECK(winding_number(box, Vec3(0, 0, 0)) == Approx(5.0 / 6));
}

TEST_CASE("a partition knows the inside as the winding number does", "[geom][bsp]") {
  const std::string kind = GENERATE("box", "torus", "bumpy", "boxes");
  const std::vector<Vec3> corners = solid(kind);
  const Bsp tree(corners);
  Rng rng(3);
  const int points = kAsserts ? 2000 : 25000;  // 100,000 of four solids
  int wrong = 0, in = 0;
  for (int k = 0; k < points; ++k) {
    const Vec3 p(rng.uniform(Real(-1.5), Real(1.5)), rng.uniform(Real(-1.1), Real(1.1)),
                 rng.uniform(Real(-1.5), Real(1.5)));
    const bool expected = winding_number(corners, p) > 0.5;
    in += expected;
    if (tree.inside(p) == expected) continue;
    Real nearest = 1;
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
      nearest = std::min(nearest, length(Vec3(p - closest_on_triangle(p, corners[i], corners[i + 1], corners[i + 2]))));
    wrong += nearest > Real(1e-6);
  }
  CAPTURE(kind, tree.nodes(), tree.pieces(), tree.splits());
  CHECK(wrong == 0);
  CHECK(in > points / 50);
}

TEST_CASE("no piece hides one that comes later in the order from back to front", "[geom][bsp]") {
  const std::string kind = GENERATE("torus", "bumpy", "boxes");
  const std::vector<Vec3> corners = solid(kind);
  const Bsp tree(corners);
  Rng rng(4);
  for (int round = 0; round < 5; ++round) {
    const Vec3 eye(rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(-3, 3));
    struct Seen {
      std::vector<Double3> corners;
    };
    std::vector<Seen> order;
    tree.back_to_front(eye, [&](const Bsp::Piece& p) { order.push_back({{p.corners.begin(), p.corners.end()}}); });
    REQUIRE(order.size() == tree.pieces());
    // the middle of a piece is in front of every earlier one that the ray to it meets, and of no later one
    const auto meets = [&](const Seen& piece, const Double3& from, const Double3& ray, double& t) {
      const Double3 n = cross(piece.corners[1] - piece.corners[0], piece.corners[2] - piece.corners[0]);
      const double by = dot(n, ray);
      if (std::abs(by) < 1e-12) return false;
      t = dot(n, piece.corners[0] - from) / by;
      const Double3 at = from + t * ray;
      for (std::size_t i = 0; i < piece.corners.size(); ++i) {
        const Double3 &a = piece.corners[i], &b = piece.corners[(i + 1) % piece.corners.size()];
        if (dot(n, cross(b - a, at - a)) < 1e-9 * dot(n, n)) return false;
      }
      return true;
    };
    const Double3 from = wide(eye);
    int hidden = 0, compared = 0;
    for (std::size_t k = 0; k < order.size(); ++k) {
      Double3 middle{0, 0, 0};
      for (const Double3& c : order[k].corners)
        middle = middle + 1.0 / static_cast<double>(order[k].corners.size()) * c;
      for (std::size_t j = 0; j < order.size(); ++j) {
        double t = 0;
        if (j == k || !meets(order[j], from, middle - from, t) || t < 1e-6) continue;
        ++compared;
        hidden += (t < 1 - 1e-6 && j < k) || (t > 1 + 1e-6 && j > k);
      }
    }
    CAPTURE(kind, round, compared);
    CHECK(hidden == 0);
    CHECK(compared > 20);
  }
}

TEST_CASE("a partition of nothing, and of too much", "[geom][bsp]") {
  const Bsp none({});
  CHECK_FALSE(none.inside(Vec3(0, 0, 0)));
  CHECK(none.pieces() == 0);
  const std::vector<Vec3> many(3 * (Bsp::kMostTriangles + 1), Vec3(0, 0, 0));
  CHECK_THROWS_WITH(Bsp(many), Catch::Contains("bvh"));
}
