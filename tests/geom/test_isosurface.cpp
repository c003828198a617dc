// Isosurfaces: closed for all cases, of second order for smooth fields, the same by blocks as on the whole grid.
#include <algorithm>
#include <set>

#include "base/rng.h"
#include "geom/isosurface.h"
#include "support/catch.h"

using namespace feder;

namespace {

struct IsoField {
  IsoGrid grid;
  std::vector<Real> values;

  std::size_t at(int x, int y, int z) const {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(grid.n[0]) *
               (static_cast<std::size_t>(y) + static_cast<std::size_t>(grid.n[1]) * static_cast<std::size_t>(z));
  }
  bool rim(int x, int y, int z) const {
    return x == 0 || y == 0 || z == 0 || x == grid.n[0] - 1 || y == grid.n[1] - 1 || z == grid.n[2] - 1;
  }
  IsoMesh mesh(Real level = 0, bool with_normals = true) const {
    IsoMesh out;
    IsoSurface().extract(grid, values, level, with_normals, out);
    return out;
  }
  // What a sampler of blocks writes.
  void operator()(const IsoBlock& block, Real* out) const {
    for (int z = 0; z < block.count[2]; ++z)
      for (int y = 0; y < block.count[1]; ++y)
        for (int x = 0; x < block.count[0]; ++x)
          out[x + IsoBlock::kRow * y + IsoBlock::kLayer * z] =
              values[at(block.first[0] + x, block.first[1] + y, block.first[2] + z)];
  }
};

// value(x, y, z) of corners.
template <class Value>
IsoField iso_corners(int nx, int ny, int nz, const Value& value) {
  IsoField f{{Vec3::Zero(), 1, {nx, ny, nz}}, {}};
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) f.values.push_back(value(x, y, z));
  return f;
}

// value(point) over the cube of half the edge `half`, off the middle by a part of a cell.
template <class Value>
IsoField iso_cube(int n, Real half, const Value& value) {
  const Real cell = 2 * half / static_cast<Real>(n - 1);
  const Vec3 origin = Vec3::Constant(-half) + cell * vec3(Real(0.13), Real(0.29), Real(-0.21));
  IsoField f = iso_corners(n, n, n, [&](int x, int y, int z) {
    return value(Vec3(origin + cell * vec3(static_cast<Real>(x), static_cast<Real>(y), static_cast<Real>(z))));
  });
  f.grid.origin = origin, f.grid.cell = cell;
  return f;
}

IsoField iso_noise(Rng& rng, int nx, int ny, int nz) {
  IsoField f = iso_corners(nx, ny, nz, [&](int, int, int) { return rng.uniform(-1, 1); });
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x)
        if (f.rim(x, y, z)) f.values[f.at(x, y, z)] = -rng.uniform(Real(0.1), 1);
  return f;
}

Real iso_sphere(const Vec3& p) { return 1 - length(p); }
Real iso_torus(const Vec3& p) {
  const Real around = std::sqrt(p[0] * p[0] + p[2] * p[2]) - Real(0.7);
  return Real(0.3) - std::sqrt(around * around + p[1] * p[1]);
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> iso_edges(const IsoMesh& m, bool reversed) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::size_t t = 0; t < m.triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = m.triangles[t + k], b = m.triangles[t + (k + 1) % 3];
      edges.emplace_back(reversed ? b : a, reversed ? a : b);
    }
  std::sort(edges.begin(), edges.end());
  return edges;
}

// No triangle with two corners the same, no two vertices in one place, no number that is none.
void iso_check_sound(const IsoMesh& m) {
  REQUIRE(m.triangles.size() % 3 == 0);
  std::size_t degenerate = 0, beyond = 0, not_finite = 0;
  for (std::size_t t = 0; t < m.triangles.size(); t += 3) {
    const std::uint32_t a = m.triangles[t], b = m.triangles[t + 1], c = m.triangles[t + 2];
    degenerate += a == b || b == c || c == a;
    beyond += std::max({a, b, c}) >= m.vertices.size();
  }
  std::set<std::array<Real, 3>> places;
  for (const Vec3& p : m.vertices) places.insert({p[0], p[1], p[2]}), not_finite += !is_finite(p);
  for (const Vec3& n : m.normals) not_finite += !is_finite(n);
  CHECK(degenerate == 0);
  CHECK(beyond == 0);
  CHECK(not_finite == 0);
  CHECK(places.size() == m.vertices.size());
}

// Each edge is used once in each direction.
void iso_check_closed(const IsoMesh& m) {
  iso_check_sound(m);
  const auto edges = iso_edges(m, false);
  CHECK(std::adjacent_find(edges.begin(), edges.end()) == edges.end());
  CHECK(edges == iso_edges(m, true));
}

// Each edge is used as often in one direction as in the other.
void iso_check_balanced(const IsoMesh& m) {
  iso_check_sound(m);
  CHECK(iso_edges(m, false) == iso_edges(m, true));
}

int iso_euler(const IsoMesh& m) {
  const auto faces = static_cast<int>(m.triangles.size() / 3);
  const std::set<std::uint32_t> used(m.triangles.begin(), m.triangles.end());
  return static_cast<int>(used.size()) - faces / 2;  // closed: 3/2 edges to a face
}

struct IsoMeasures {
  double area = 0, volume = 0;
};
IsoMeasures iso_measure(const IsoMesh& m) {
  IsoMeasures sum;
  for (std::size_t t = 0; t < m.triangles.size(); t += 3) {
    const Vec3 &a = m.vertices[m.triangles[t]], &b = m.vertices[m.triangles[t + 1]],
               &c = m.vertices[m.triangles[t + 2]];
    const Vec3 n = cross(b - a, c - a);
    sum.area += static_cast<double>(length(n)) / 2;
    sum.volume += static_cast<double>(dot(n, a)) / 6;
  }
  return sum;
}

bool iso_same(const IsoMesh& a, const IsoMesh& b) {
  return a.vertices == b.vertices && a.normals == b.normals && a.triangles == b.triangles;
}

}  // namespace

TEST_CASE("area and volume of an isosurface converge with the square of the cell", "[geom][isosurface]") {
  const double pi = 3.14159265358979, sphere_area = 4 * pi, sphere_volume = 4 * pi / 3;
  const double torus_area = 4 * pi * pi * 0.7 * 0.3, torus_volume = 2 * pi * pi * 0.7 * 0.09;
  const bool torus = GENERATE(false, true);
  double area[2], volume[2];
  const int n[2] = {24, 93};  // cells a fourth as large
  for (int k = 0; k < 2; ++k) {
    const IsoMesh m = iso_cube(n[k], Real(1.3), torus ? iso_torus : iso_sphere).mesh();
    iso_check_closed(m);
    CHECK(iso_euler(m) == (torus ? 0 : 2));
    const IsoMeasures got = iso_measure(m);
    area[k] = std::abs(got.area / (torus ? torus_area : sphere_area) - 1);
    volume[k] = std::abs(got.volume / (torus ? torus_volume : sphere_volume) - 1);
  }
  CAPTURE(torus, area[0], area[1], volume[0], volume[1]);
  CHECK(area[0] < 0.02);
  CHECK(volume[0] < 0.04);
  CHECK(std::log(area[0] / area[1]) / std::log(4) >= 1.8);
  CHECK(std::log(volume[0] / volume[1]) / std::log(4) >= 1.8);
}

TEST_CASE("normals of an isosurface are those of the field", "[geom][isosurface]") {
  double mean[2];  // root of the mean square
  const int n[2] = {21, 81};
  for (int k = 0; k < 2; ++k) {
    const IsoField f = iso_cube(n[k], Real(1.3), iso_sphere);
    const IsoMesh m = f.mesh();
    REQUIRE(m.normals.size() == m.vertices.size());
    double sum = 0;
    Real worst = 0;
    for (std::size_t i = 0; i < m.vertices.size(); ++i) {
      const Real off = length(m.normals[i] - m.vertices[i] / length(m.vertices[i]));
      worst = std::max(worst, off);
      sum += static_cast<double>(off) * static_cast<double>(off);
    }
    mean[k] = std::sqrt(sum / static_cast<double>(m.vertices.size()));
    CHECK(worst < Real(0.01));
    const IsoMesh bare = f.mesh(0, false);
    CHECK(bare.normals.empty());
    CHECK((bare.vertices == m.vertices && bare.triangles == m.triangles));
  }
  CAPTURE(mean[0], mean[1]);
  CHECK(std::log(mean[0] / mean[1]) / std::log(4) >= 1.8);
}

TEST_CASE("all 256 cells close", "[geom][isosurface]") {
  Rng rng(2);
  for (unsigned inside = 0; inside < 256; ++inside) {
    const IsoField f = iso_corners(4, 4, 4, [&](int x, int y, int z) {
      const bool within = x % 3 && y % 3 && z % 3;
      const bool in = within && inside >> ((x - 1) + 2 * (y - 1) + 4 * (z - 1)) & 1;
      return (in ? 1 : -1) * rng.uniform(Real(0.1), 1);
    });
    CAPTURE(inside);
    const IsoMesh m = f.mesh();
    iso_check_closed(m);
    CHECK(m.triangles.empty() == (inside == 0));
    CHECK((iso_measure(m).volume > 0) == (inside != 0));
  }
}

TEST_CASE("isosurfaces of noise are closed", "[geom][isosurface]") {
  Rng rng(3);
  for (int trial = 0; trial < 12; ++trial) {
    const auto size = [&] { return 3 + static_cast<int>(rng.next() % 20); };
    const int nx = size(), ny = size(), nz = size();
    IsoField f = iso_noise(rng, nx, ny, nz);
    CAPTURE(trial, nx, ny, nz);
    const IsoMesh m = f.mesh();
    iso_check_closed(m);
    // one vertex on each edge between inside and outside
    std::size_t cut = 0;
    for (int z = 0; z < nz; ++z)
      for (int y = 0; y < ny; ++y)
        for (int x = 0; x < nx; ++x) {
          const auto in = [&](int i, int j, int k) { return f.values[f.at(i, j, k)] > 0; };
          cut += x + 1 < nx && in(x, y, z) != in(x + 1, y, z);
          cut += y + 1 < ny && in(x, y, z) != in(x, y + 1, z);
          cut += z + 1 < nz && in(x, y, z) != in(x, y, z + 1);
        }
    CHECK(m.vertices.size() == cut);
    // many corners at the level itself, and numbers that are none
    for (Real& v : f.values) v = std::round(2 * v) / 2;
    iso_check_balanced(f.mesh());
    for (Real& v : f.values)
      if (rng.next() % 4 == 0) v = v > 0 ? kInfinity : v < 0 ? -kInfinity : std::numeric_limits<Real>::quiet_NaN();
    iso_check_balanced(f.mesh());
  }
}

TEST_CASE("inside corners across a face stay apart", "[geom][isosurface]") {
  const IsoField f = iso_corners(4, 4, 3, [](int x, int y, int z) {
    return (x == 1 && y == 1 && z == 1) || (x == 2 && y == 2 && z == 1) ? Real(1) : Real(-1);
  });
  const IsoMesh m = f.mesh();
  iso_check_closed(m);
  CHECK(iso_euler(m) == 4);  // two octahedra
  CHECK(m.triangles.size() == 3 * 16);
}

TEST_CASE("the isosurface by blocks is that of the whole grid", "[geom][isosurface]") {
  Rng rng(5);
  IsoSurface surface;
  for (int trial = 0; trial < 4; ++trial) {
    const IsoField f =
        trial == 0 ? iso_cube(50, 3, [](const Vec3& p) { return iso_sphere(p); }) : iso_noise(rng, 9 + trial, 25, 20);
    const IsoMesh whole = f.mesh();
    CAPTURE(trial);
    IsoMesh m;
    surface.extract_sampled(f.grid, f, 0, true, m);
    CHECK(iso_same(m, whole));
    // only blocks that have corners of both kinds
    std::vector<std::uint32_t> blocks;
    for (std::uint32_t b = 0; b < f.grid.block_count(); ++b) {
      const std::uint32_t one[1] = {b};
      surface.extract_blocks(f.grid, one, f, 0, false, m);
      if (!m.vertices.empty()) blocks.push_back(b);
    }
    if (trial == 0) CHECK(blocks.size() < f.grid.block_count() / 2);
    surface.extract_blocks(f.grid, blocks, f, 0, true, m);
    CHECK(iso_same(m, whole));
    // another order: the same triangles in another order
    std::reverse(blocks.begin(), blocks.end());
    surface.extract_blocks(f.grid, blocks, f, 0, true, m);
    iso_check_closed(m);
    CHECK(m.vertices.size() == whole.vertices.size());
    CHECK(m.triangles.size() == whole.triangles.size());
  }
}

TEST_CASE("an isosurface of some blocks opens only where others are missing", "[geom][isosurface]") {
  Rng rng(7);
  const IsoField f = iso_noise(rng, 33, 33, 33);
  std::vector<std::uint32_t> blocks;
  for (std::uint32_t b = 0; b < f.grid.block_count(); ++b)
    if (rng.next() % 2) blocks.push_back(b);
  IsoMesh m;
  IsoSurface().extract_blocks(f.grid, blocks, f, 0, false, m);
  iso_check_sound(m);
  const auto edges = iso_edges(m, false), back = iso_edges(m, true);
  CHECK(std::adjacent_find(edges.begin(), edges.end()) == edges.end());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open;
  std::set_difference(edges.begin(), edges.end(), back.begin(), back.end(), std::back_inserter(open));
  REQUIRE_FALSE(open.empty());
  std::size_t elsewhere = 0;
  for (const auto& [a, b] : open) {
    bool on_face = false;
    for (int k = 0; k < 3; ++k) {
      const Real x = m.vertices[a][k];
      on_face = on_face || (x == m.vertices[b][k] && x == 8 * std::round(x / 8));
    }
    elsewhere += !on_face;
  }
  CHECK(elsewhere == 0);
}

TEST_CASE("the isosurface of a linear field is a plane", "[geom][isosurface]") {
  // through corners: two triangles to a cell, exactly there
  IsoField f = iso_corners(12, 10, 11, [](int, int y, int) { return static_cast<Real>(4 - y); });
  f.grid.origin = vec3(1, 2, 3), f.grid.cell = Real(0.25);
  IsoMesh m = f.mesh();
  iso_check_sound(m);
  CHECK(m.vertices.size() == 12 * 11);
  CHECK(m.triangles.size() == 3 * 2 * 11 * 10);
  CHECK(std::all_of(m.vertices.begin(), m.vertices.end(), [](const Vec3& p) { return p[1] == 3; }));
  CHECK(std::all_of(m.normals.begin(), m.normals.end(), [](const Vec3& n) { return n == Vec3(0, 1, 0); }));
  CHECK(iso_measure(m).area == Approx(11 * 0.25 * 10 * 0.25));
  // between corners
  m = f.mesh(Real(0.5));
  CHECK(std::all_of(m.vertices.begin(), m.vertices.end(), [](const Vec3& p) { return p[1] == Real(2.875); }));
  // askew
  const Vec3 n = normalized_or(vec3(1, -2, Real(0.7)), Vec3::Zero());
  f = iso_cube(30, 1, [&](const Vec3& p) { return Real(0.1) - dot(n, p); });
  m = f.mesh();
  REQUIRE_FALSE(m.vertices.empty());
  Real off = 0, turned = 0;
  for (const Vec3& p : m.vertices) off = std::max(off, std::abs(dot(n, p) - Real(0.1)));
  for (const Vec3& u : m.normals) turned = std::max(turned, length(u - n));
  CHECK(off < 8 * kEpsilon);
  CHECK(turned < 200 * kEpsilon);  // differences of values that are rounded
}

TEST_CASE("fields without a surface give none", "[geom][isosurface]") {
  const Real none = std::numeric_limits<Real>::quiet_NaN();
  const Real value = GENERATE_COPY(Real(-1), Real(0), Real(1), none, kInfinity, -kInfinity);
  const auto constant = [&](int, int, int) { return value; };
  IsoMesh m = iso_cube(5, 1, iso_sphere).mesh();
  REQUIRE_FALSE(m.vertices.empty());
  IsoSurface surface;
  const IsoField f = iso_corners(11, 9, 10, constant);
  surface.extract(f.grid, f.values, 0, true, m);
  CHECK((m.vertices.empty() && m.normals.empty() && m.triangles.empty()));
  const IsoField g = iso_cube(5, 1, iso_sphere);
  surface.extract(g.grid, g.values, none, true, m);
  CHECK(m.triangles.empty());
  surface.extract_blocks(g.grid, {}, g, 0, true, m);
  CHECK(m.triangles.empty());
  for (const int n : {0, 1}) {  // no cells
    const IsoField flat = iso_corners(5, n, 5, constant);
    CHECK(flat.grid.block_count() == 0);
    CHECK(flat.mesh().triangles.empty());
  }
}

TEST_CASE("a value that is none is outside", "[geom][isosurface]") {
  IsoField f = iso_corners(3, 3, 3, [](int, int, int) { return std::numeric_limits<Real>::quiet_NaN(); });
  f.values[f.at(1, 1, 1)] = 1;
  const IsoMesh m = f.mesh();
  iso_check_closed(m);
  CHECK(m.vertices.size() == 6);
  CHECK(iso_measure(m).volume == Approx(1.0 / 6));  // halfway
}

TEST_CASE("equal fields give equal isosurfaces", "[geom][isosurface]") {
  Rng rng(11);
  IsoSurface used;
  IsoMesh m;
  for (int trial = 0; trial < 6; ++trial) {
    const IsoField f = iso_noise(rng, 5 + 6 * trial, 40 - 6 * trial, 18);
    const IsoMesh fresh = f.mesh();
    used.extract(f.grid, f.values, 0, true, m);
    CHECK(iso_same(m, fresh));
    used.extract(f.grid, f.values, 0, true, m);
    CHECK(iso_same(m, fresh));
  }
}
