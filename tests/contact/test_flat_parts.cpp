// Parts of flat sheets (contact/flat_parts.h) against brute force: whatever may come near is found, and what is left
// out keeps half of the distance that it has at rest.
#include <array>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "contact/flat_parts.h"
#include "support/catch.h"

using namespace feder;

namespace {

struct Patch {
  std::vector<Vec3> rest;
  std::vector<std::uint32_t> triangles, edges;  // ends and triangles of an edge: four numbers each
  Surface surface;

  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) { triangles.insert(triangles.end(), {a, b, c}); }
  void finish() {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> known;
    edges.clear();
    for (std::size_t k = 0; k < triangles.size(); ++k) {
      const std::uint32_t p = triangles[k], q = triangles[k - k % 3 + (k + 1) % 3];
      const auto [at, fresh] = known.insert({{std::min(p, q), std::max(p, q)}, edges.size()});
      const auto triangle = static_cast<std::uint32_t>(k / 3);
      if (fresh)
        edges.insert(edges.end(), {std::min(p, q), std::max(p, q), triangle, kNone});
      else
        edges[at->second + 3] = triangle;
    }
    surface.count = surface.total = static_cast<std::uint32_t>(rest.size());
    surface.triangles = triangles, surface.rest = rest.data();
    surface.edges = {edges.data(), 4, static_cast<std::uint32_t>(edges.size() / 4)};
    surface.borders = edges.data() + 3;
    ++surface.version;
  }
};

// n x n cells of 1 cm; without the cells for which `out` is true.
template <class Out>
Patch sheet_without(std::uint32_t n, Out&& out) {
  Patch p;
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= n; ++i) p.rest.push_back(Vec3(Real(0.01) * Real(i), 0, Real(0.01) * Real(j)));
  const std::uint32_t row = n + 1;
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      if (out(i, j)) continue;
      const std::uint32_t a = i + row * j;
      p.add(a, a + row, a + 1), p.add(a + 1, a + row, a + row + 1);
    }
  p.finish();
  return p;
}

Real to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 u = b - a;
  const Real s = std::clamp(dot(Vec3(p - a), u) / dot(u, u), Real(0), Real(1));
  return length(Vec3(p - a - s * u));
}

Real to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = normalized_or(cross(Vec3(b - a), Vec3(c - a)), Vec3(0, 1, 0));
  const auto inside = [&](const Vec3& x, const Vec3& y) { return dot(cross(Vec3(y - x), Vec3(p - x)), n) >= 0; };
  if (inside(a, b) && inside(b, c) && inside(c, a)) return std::abs(dot(n, Vec3(p - a)));
  return std::min({to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a)});
}

Real between(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a, v = d - c, r = c - a;
  const Real uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), det = uu * vv - uv * uv;
  if (det > Real(1e-6) * uu * vv) {
    const Real s = (dot(r, u) * vv - dot(r, v) * uv) / det, t = (dot(r, u) * uv - dot(r, v) * uu) / det;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) return length(Vec3(r + t * v - s * u));
  }
  return std::min({to_segment(a, c, d), to_segment(b, c, d), to_segment(c, a, b), to_segment(d, a, b)});
}

// All pairs of features against what was found, at three moments of a motion that deviates as far as it may. Returns
// how many were left out.
int check(const Patch& p, const std::vector<Vec3>& x, const std::vector<Vec3>& v, Real allowed, Real margin) {
  const Real time = Real(0.01);
  const std::vector<Real> deviation(x.size(), allowed);
  std::mt19937 random(3);
  std::vector<Vec3> off(x.size());
  for (Vec3& o : off) {
    for (int k = 0; k < 3; ++k) o[k] = static_cast<Real>(random() % 65536) / 32768 - 1;
    o = allowed * normalized_or(o, Vec3(0, 1, 0));
  }
  Arena arena("test");
  FlatParts parts(arena);
  parts.build(p.surface);
  REQUIRE(parts.flat());
  JobPool jobs;
  parts.measure({x.data(), v.data(), deviation.data(), time}, jobs);
  std::set<std::array<std::uint32_t, 5>> found;
  int twice = 0;
  if (!parts.decide(kInfinity))
    parts.find_pairs(margin, [&](const std::uint32_t(&k)[4], bool edges) {
      twice += !found.insert({k[0], k[1], k[2], k[3], std::uint32_t(edges)}).second;
    });
  int left = 0, lost = 0, near = 0;
  const auto test = [&](const std::uint32_t(&k)[4], bool edges) {
    for (std::size_t i = 0; i < (edges ? 2u : 1u); ++i)
      for (std::size_t j = edges ? 2 : 1; j < 4; ++j)
        if (k[i] == k[j]) return;
    if (found.count({k[0], k[1], k[2], k[3], std::uint32_t(edges)})) return;
    if (edges && found.count({k[2], k[3], k[0], k[1], 1})) return;
    ++left;
    const auto distance = [&](auto&& at) {
      return edges ? between(at(k[0]), at(k[1]), at(k[2]), at(k[3]))
                   : to_triangle(at(k[0]), at(k[1]), at(k[2]), at(k[3]));
    };
    const Real rest = distance([&](std::uint32_t i) { return p.rest[i]; });
    for (const Real t : {Real(0), time / 2, time}) {
      const Real d = distance([&](std::uint32_t i) { return Vec3(x[i] + t * v[i] + (t / time) * off[i]); });
      near += d < margin;
      lost += d < margin && !(rest > 0 && d >= Real(0.499) * rest);
    }
  };
  const auto& e = p.edges;
  for (std::size_t a = 0; a < e.size(); a += 4)
    for (std::size_t b = a + 4; b < e.size(); b += 4) test({e[a], e[a + 1], e[b], e[b + 1]}, true);
  for (std::uint32_t i = 0; i < p.rest.size(); ++i)
    for (std::size_t t = 0; t < p.triangles.size(); t += 3)
      test({i, p.triangles[t], p.triangles[t + 1], p.triangles[t + 2]}, false);
  CAPTURE(left, near, found.size());
  CHECK(lost == 0);
  CHECK(twice == 0);
  return left;
}

}  // namespace

TEST_CASE("parts of flat sheets leave out nothing that comes near", "[contact]") {
  std::mt19937 random(5);
  const auto number = [&](Real a, Real b) { return a + (b - a) * static_cast<Real>(random() % 65536) / 65536; };
  const auto none = [](std::uint32_t, std::uint32_t) { return false; };
  const Patch whole = sheet_without(14, none);
  const Patch holed =
      sheet_without(14, [](std::uint32_t i, std::uint32_t j) { return i > 4 && i < 9 && j > 4 && j < 9; });
  for (const Patch* p : {&whole, &holed})
    for (int kind = 0; kind < 6; ++kind) {
      CAPTURE(p == &holed, kind);
      std::vector<Vec3> x = p->rest, v(x.size(), Vec3::Zero());
      const Real radius = kind == 1 ? Real(0.1) : kind == 2 ? Real(0.02) : Real(0.008);
      for (std::size_t i = 0; i < x.size(); ++i) {
        const Real s = p->rest[i][0], fall = number(-1, 1);
        if (kind >= 1 && kind <= 3)
          x[i][0] = radius * std::sin(s / radius), x[i][1] = radius * (1 - std::cos(s / radius));
        if (kind == 3) x[i] += s * Vec3(0, Real(0.05), 0);
        if (kind == 4) x[i][1] += Real(0.01) * fall;
        if (kind == 5)
          for (int k = 0; k < 3; ++k) x[i][k] = number(0, Real(0.05));
        v[i] = Vec3(Real(0.3) * number(-1, 1), 5 - s, 20);
      }
      const int left = check(*p, x, v, Real(2e-4), Real(0.004));
      check(*p, x, v, Real(1e-3), Real(0.002)), check(*p, x, v, 0, Real(0.012));
      if (kind < 2 && p == &whole) CHECK(left > 100000);  // it does rule out
    }
}

TEST_CASE("a window of a sheet with a slit, and rest shapes that are not flat, have no certificate", "[contact]") {
  Patch slit = sheet_without(12, [](std::uint32_t, std::uint32_t) { return false; });
  // the lower half hangs on a row of points of its own
  const std::uint32_t row = 13, middle = 6 * row;
  const auto more = static_cast<std::uint32_t>(slit.rest.size());
  for (std::uint32_t i = 0; i < row; ++i) slit.rest.push_back(slit.rest[middle + i]);
  for (std::size_t t = 0; t < slit.triangles.size(); t += 3) {
    std::uint32_t* k = &slit.triangles[t];
    if (std::max({k[0], k[1], k[2]}) >= middle + row)
      for (int c = 0; c < 3; ++c)
        if (k[c] >= middle && k[c] < middle + row) k[c] += more - middle;
  }
  slit.finish();
  std::vector<Vec3> x = slit.rest, v(x.size(), Vec3::Zero());
  check(slit, x, v, Real(1e-4), Real(0.004));
  Arena arena("test");
  FlatParts parts(arena);
  parts.build(slit.surface);
  const std::vector<Real> still(x.size(), 0);
  JobPool jobs;
  parts.measure({x.data(), v.data(), still.data(), Real(0.01)}, jobs);
  CHECK_FALSE(parts.decide(kInfinity));

  Patch bent = sheet_without(8, [](std::uint32_t, std::uint32_t) { return false; });
  bent.rest[20][1] = Real(0.02);
  bent.finish();
  FlatParts others(arena);
  others.build(bent.surface);
  CHECK_FALSE(others.flat());
}
