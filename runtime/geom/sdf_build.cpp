// Fields from meshes, shapes, functions and values: checks, layout, distances, and what was lost (the certificate).
// What is no distance is measured anew from the triangles of its surface.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "base/rng.h"
#include "feder/error.h"
#include "geom/sdf.h"
#include "geom/sdf_acquire.h"

namespace feder {
namespace {

constexpr int kPadding = 3;                    // cells around the surface
constexpr Real kDefaultCells = 64;             // along the longest side
constexpr Real kMostUneven = 10000;            // sides of a box
constexpr std::uint64_t kAdaptiveFactor = 16;  // corners that an adaptive field may have more, where they were dense
constexpr double kSlopeSlack = 0.05;
constexpr int kProbes = 2000;
constexpr Real kThin = Real(0.6);    // of a cell: no deeper a cell below the surface, and the wall is thin
constexpr double kThinShare = 0.05;  // of the probes

std::string text(double x) {
  char out[32];
  std::snprintf(out, sizeof out, "%g", x);
  return out;
}
[[noreturn]] void fail_sdf(const std::string& message) {
  for (const char* option : {"spacing", "size", "mesh", "fn", "buffer", "shape", "tolerance"}) {
    const std::size_t length = std::strlen(option);
    if (message.compare(0, length, option) == 0 && message.find_first_of(":[", length) == length)
      throw SceneError("sdf." + message);
  }
  throw SceneError("sdf: " + message);
}

void check_box(const Aabb& box, Real spacing) {
  const Vec3 side = box.hi - box.lo;
  const Real longest = side.maxCoeff(), shortest = side.minCoeff();
  if (!(longest < kInfinity)) fail_sdf("expected a bounded solid; give a box or a mesh in place of a plane");
  if (!(shortest * kMostUneven > longest))
    fail_sdf("its box is " + text(side[0]) + " x " + text(side[1]) + " x " + text(side[2]) +
             " m; expected sides within 10000 of each other" +
             (shortest > 0 ? "; cut it into parts" : "; a flat mesh has no inside"));
  if (!(spacing < shortest))
    fail_sdf("spacing: expected less than the thinnest side (" + text(shortest) + " m), got " + text(spacing) +
             "; a quarter of it or less keeps the form");
}

void check_count(const int (&n)[3], Real spacing, bool adaptive) {
  const double corners = double(n[0]) * n[1] * n[2];
  const double most = double(kMostSdfCorners * (adaptive ? kAdaptiveFactor : 1));
  if (corners <= most) return;
  fail_sdf("expected at most " + text(most) + " cells, got " + text(corners) + "; a spacing of " +
           text(spacing * std::cbrt(corners / most) * 1.02) + " m fits" +
           (adaptive ? "" : ", or adaptive = true with a band of the finest"));
}

// `padding` cells around the box, which is in the middle.
FieldLayout layout_around(const Aabb& box, Real spacing, int padding, bool adaptive) {
  FieldLayout at;
  at.spacing = spacing;
  for (int k = 0; k < 3; ++k) {
    const double cells = std::ceil(double(box.hi[k] - box.lo[k]) / double(spacing)) + 2 * padding;
    if (cells > 1e6) fail_sdf("spacing: " + text(spacing) + " m gives " + text(cells) + " cells along a side");
    at.n[k] = static_cast<int>(cells) + 1;
    at.origin[k] = (box.lo[k] + box.hi[k]) / 2 - spacing * Real(cells / 2);
  }
  check_count(at.n, spacing, adaptive);
  return at;
}

Real chosen_spacing(const Aabb& box, Real spacing) {
  if (!(spacing >= 0) || !is_finite(spacing)) fail_sdf("spacing: expected a number above 0, got " + text(spacing));
  return spacing > 0 ? spacing : (box.hi - box.lo).maxCoeff() / kDefaultCells;
}

// What a field is compared with.
struct Truth {
  std::function<Real(const Vec3&)> distance = {};
  std::vector<Vec3> probes = {}, normals = {};  // on the surface, for thin walls; none: the field's own samples
};

// Largest error within a cell of the surface.
Real certificate(const Sdf& shape, const Truth& truth) {
  Rng rng(11);
  Real worst = 0;
  const auto samples = shape.samples();
  for (int i = 0; i < kProbes; ++i) {
    const Sdf::Sample& s = samples[rng.next() % samples.size()];
    const Real h = shape.field().layout().spacing;
    Vec3 p = s.at + rng.uniform(-h, h) * s.normal;
    for (int k = 0; k < 3; ++k) p[k] += h / 2 * rng.uniform(-1, 1);  // arguments of a call come in any order
    if (std::abs(shape.field().at(p)) > h) continue;
    worst = std::max(worst, std::abs(shape.field().at(p) - truth.distance(p)));
  }
  return worst;
}

double thin_share(const DistanceField& field, const std::vector<Vec3>& at, const std::vector<Vec3>& normals) {
  const Real h = field.layout().spacing;
  std::size_t thin = 0;
  for (std::size_t i = 0; i < at.size(); ++i) thin += field.at(at[i] - h * normals[i]) > -kThin * h;
  return at.empty() ? 0 : double(thin) / double(at.size());
}

ShapePtr finish(DistanceField field, const Truth& truth, std::vector<std::string> warnings) {
  const auto shape = std::make_shared<Sdf>(std::move(field));
  std::vector<Vec3> at = truth.probes, normals = truth.normals;
  if (at.empty())
    for (const Sdf::Sample& s : shape->samples()) at.push_back(s.at), normals.push_back(s.normal);
  const double thin = thin_share(shape->field(), at, normals);
  const Real h = shape->field().layout().spacing;
  if (thin > kThinShare)
    warnings.push_back("walls thinner than 2 cells on " + text(std::round(100 * thin)) +
                       " % of the surface: a spacing of " + text(h / 2) + " m in place of " + text(h) +
                       " keeps them better");
  shape->certify(truth.distance ? certificate(*shape, truth) : Real(-1), std::move(warnings));
  return shape;
}

Real ask_truth(const void* truth, const Vec3& p) { return static_cast<const Truth*>(truth)->distance(p); }

std::vector<float> values_of(const FieldLayout& at, const Truth& truth) {
  return at.values([&](int x, int y, int z) { return truth.distance(at.corner(x, y, z)); });
}

DistanceField sampled(const FieldLayout& at, const SdfDesc& d, const Truth& truth) {
  if (d.adaptive) return DistanceField::adaptive(at, kFineBand * at.spacing, d.tolerance, ask_truth, &truth);
  return DistanceField(at, values_of(at, truth));
}

// --- meshes

std::vector<Vec3> corners_with_area(const SdfDesc& d) {
  if (d.triangles.empty()) fail_sdf("mesh: expected triangles, got none");
  if (d.triangles.size() % 3 != 0)
    fail_sdf("mesh: expected three vertex numbers per triangle, got " + std::to_string(d.triangles.size()));
  std::vector<Vec3> corners;
  for (std::size_t i = 0; i < d.triangles.size(); i += 3) {
    Vec3 c[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = d.triangles[i + k];
      if (v >= d.vertices.size())
        fail_sdf("mesh: triangle " + std::to_string(i / 3 + 1) + " names vertex " + std::to_string(v + 1) +
                 ", but there are " + std::to_string(d.vertices.size()));
      c[k] = d.vertices[v];
      if (!is_finite(c[k])) fail_sdf("mesh: expected finite vertices, but vertex " + std::to_string(v + 1) + " is not");
    }
    if (length(cross(c[1] - c[0], c[2] - c[0])) > 0) corners.insert(corners.end(), c, c + 3);
  }
  if (corners.empty()) fail_sdf("mesh: no triangle has an area");
  return corners;
}

ShapePtr from_triangles(const SdfDesc& d, const TriangleField& mesh) {
  const Real spacing = chosen_spacing(mesh.box(), d.spacing);
  check_box(mesh.box(), spacing);
  std::vector<std::string> warnings;
  const bool closed = mesh.open_edges() == 0;
  if (closed && mesh.volume() < 0)
    fail_sdf("mesh: it is inside out (its volume is " + text(mesh.volume()) +
             " m3); name the corners of its triangles counterclockwise as seen from outside: swap two of each");
  if (!closed)
    warnings.push_back("the mesh is open: " + std::to_string(mesh.open_edges()) +
                       " edges have one triangle, holes of " + text(mesh.open_area()) + " m2 in " + text(mesh.area()) +
                       " m2; inside is where it goes round by more than half: close it");
  const FieldLayout at = layout_around(mesh.box(), spacing, kPadding, d.adaptive);
  Truth truth;
  truth.distance = [&](const Vec3& p) { return mesh.signed_distance(p); };
  const std::span<const Vec3> c = mesh.corners();
  for (std::size_t i = 0; i < c.size(); i += 3) {
    truth.probes.push_back((c[i] + c[i + 1] + c[i + 2]) / 3);
    truth.normals.push_back(normalized_or(cross(c[i + 1] - c[i], c[i + 2] - c[i]), Vec3(0, 1, 0)));
  }
  if (d.adaptive && at.corners() > kMostSdfCorners) return finish(sampled(at, d, truth), truth, std::move(warnings));
  Acquired got = acquire(mesh, at, d.acquire);
  if (got.most_turns > 1.5)
    warnings.push_back("parts of the mesh lie in each other (it goes round " + text(std::round(got.most_turns)) +
                       " times in places): they count as inside once");
  DistanceField dense(at, std::move(got.values));
  return finish(d.adaptive ? thinned(dense, d.tolerance) : std::move(dense), truth, std::move(warnings));
}

// --- functions and values

// Mean of | |slope| - 1 | at the corners of edges that the surface crosses.
double slope_error(const FieldLayout& at, const std::vector<float>& v) {
  double sum = 0;
  std::size_t count = 0;
  for (int z = 1; z + 1 < at.n[2]; ++z)
    for (int y = 1; y + 1 < at.n[1]; ++y)
      for (int x = 1; x + 1 < at.n[0]; ++x) {
        const std::size_t i = at.index(x, y, z);
        bool crossed = false;
        double square = 0;
        for (const std::size_t s : {at.stride(0), at.stride(1), at.stride(2)}) {
          crossed = crossed || (v[i] < 0) != (v[i + s] < 0);
          const double d = (double(v[i + s]) - double(v[i - s])) / (2 * double(at.spacing));
          square += d * d;
        }
        if (crossed) sum += std::abs(std::sqrt(square) - 1), ++count;
      }
  return count ? sum / double(count) : 0;
}

void check_rim(const FieldLayout& at, const std::vector<float>& v) {
  for (int z = 0; z < at.n[2]; ++z)
    for (int y = 0; y < at.n[1]; ++y)
      for (int x = 0; x < at.n[0]; ++x) {
        const bool rim = x == 0 || y == 0 || z == 0 || x + 1 == at.n[0] || y + 1 == at.n[1] || z + 1 == at.n[2];
        if (!rim || !(v[at.index(x, y, z)] < 0)) continue;
        const Vec3 p = at.corner(x, y, z);
        fail_sdf("the solid reaches the rim of its box at (" + text(p[0]) + ", " + text(p[1]) + ", " + text(p[2]) +
                 "); expected values above 0 there: give a larger size");
      }
}

// Triangles of the surface of values on a grid.
TriangleField surface_of(const FieldLayout& at, const std::vector<float>& values) {
  std::vector<Real> flipped;
  flipped.reserve(values.size());
  for (const float v : values) flipped.push_back(-Real(v));
  IsoMesh mesh;
  IsoSurface iso;
  iso.extract({at.origin, at.spacing, {at.n[0], at.n[1], at.n[2]}}, flipped, 0, false, mesh);
  if (mesh.triangles.empty()) fail_sdf("nothing is inside; a field is negative inside");
  std::vector<Vec3> corners;
  for (const std::uint32_t i : mesh.triangles) corners.push_back(mesh.vertices[i]);
  return TriangleField(std::move(corners));
}

}  // namespace

std::vector<float> surface_distances(const FieldLayout& at, const std::vector<float>& values) {
  return rasterised(surface_of(at, values), at);
}

namespace {

// Values that are no distances become such: all of them where the slope at the surface is wrong, else those that miss
// the distance to the surface by more than cells cut off from an edge, and whose own nearest point is not on it (within
// a union, beyond a cut).
constexpr Real kCutOff = Real(0.6), kBeside = Real(0.5);  // cells
void correct(const FieldLayout& at, std::vector<float>& values, Truth& truth) {
  const Real most_off = slope_error(at, values) <= kSlopeSlack ? kCutOff * at.spacing : Real(0);
  const auto surface = std::make_shared<TriangleField>(surface_of(at, values));
  const std::vector<float> measured = rasterised(*surface, at);
  std::size_t changed = 0;
  const auto most = static_cast<float>(most_off);
  const DistanceField as_given(at, values);
  const auto beside = [&](const Vec3& p) {  // does the way along its slope end beside the surface?
    Vec3 slope = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      Vec3 step = Vec3::Zero();
      step[k] = at.spacing;
      slope[k] = as_given.at(p + step) - as_given.at(p - step);
    }
    return std::abs(as_given.at(p - as_given.at(p) * normalized_or(slope, Vec3::Zero()))) > kBeside * at.spacing;
  };
  for (std::size_t i = 0; i < values.size(); ++i) {
    const float exact = std::copysign(measured[i], values[i] < 0 ? -1.0f : 1.0f);  // the sign as it was given
    if (!(std::abs(values[i] - exact) > most)) continue;
    int c[3];
    at.place_of(i, c);
    if (most > 0 && !beside(at.corner(c[0], c[1], c[2]))) continue;
    values[i] = exact, ++changed;
  }
  if (changed == 0) return;
  truth.distance = [given = truth.distance, surface, most_off](const Vec3& p) {
    const Real exact = surface->signed_distance(p);
    if (!given) return exact;
    const Real first = given(p);
    return std::abs(first - exact) > 2 * most_off ? exact : first;  // in a cell that is cut off: as given
  };
}

ShapePtr from_values(const SdfDesc& d, const FieldLayout& at, std::vector<float> values, Truth truth) {
  check_rim(at, values);
  correct(at, values, truth);
  DistanceField dense(at, std::move(values));
  return finish(d.adaptive ? thinned(dense, d.tolerance) : std::move(dense), truth, {});
}

FieldLayout layout_of_size(const SdfDesc& d, const Vec3& middle) {
  for (int k = 0; k < 3; ++k)
    if (!(d.size[k] > 0) || !is_finite(d.size[k]))
      fail_sdf("size: expected the sides of the box in m, got (" + text(d.size[0]) + ", " + text(d.size[1]) + ", " +
               text(d.size[2]) + ")");
  const Aabb box{-d.size / 2, d.size / 2};
  const Real spacing = chosen_spacing(box, d.spacing);
  check_box(box, spacing);
  FieldLayout at;
  at.spacing = spacing;
  for (int k = 0; k < 3; ++k) {
    const double cells = std::round(double(d.size[k]) / double(spacing));
    if (cells > 1e6) fail_sdf("spacing: " + text(spacing) + " m gives " + text(cells) + " cells along a side");
    at.n[k] = std::max(1, static_cast<int>(cells)) + 1;
    at.origin[k] = middle[k] - spacing * Real(at.n[k] - 1) / 2;
  }
  check_count(at.n, spacing, false);
  return at;
}

ShapePtr from_function(const SdfDesc& d, const Vec3& middle) {
  const FieldLayout at = layout_of_size(d, middle);
  Truth truth;
  truth.distance = [&](const Vec3& p) {
    const double v = d.function(double(p[0] - middle[0]), double(p[1] - middle[1]), double(p[2] - middle[2]));
    if (!std::isfinite(v))
      fail_sdf("fn: expected a finite number at (" + text(p[0]) + ", " + text(p[1]) + ", " + text(p[2]) + "), got " +
               text(v));
    return Real(v);
  };
  return from_values(d, at, values_of(at, truth), truth);
}

ShapePtr from_given(const SdfDesc& d) {
  const FieldLayout at = layout_of_size(d, Vec3::Zero());
  if (d.values.size() != at.corners())
    fail_sdf("buffer: expected " + std::to_string(at.n[0]) + " x " + std::to_string(at.n[1]) + " x " +
             std::to_string(at.n[2]) + " = " + std::to_string(at.corners()) +
             " numbers (size/spacing + 1 along each side, x fastest), got " + std::to_string(d.values.size()));
  std::vector<float> values;
  values.reserve(d.values.size());
  for (std::size_t i = 0; i < d.values.size(); ++i) {
    if (!std::isfinite(static_cast<float>(d.values[i])))
      fail_sdf("buffer[" + std::to_string(i + 1) + "]: expected a finite number, got " + text(d.values[i]));
    values.push_back(static_cast<float>(d.values[i]));
  }
  return from_values(d, at, std::move(values), {});
}

ShapePtr from_shape(const SdfDesc& d) {
  if (!(d.shape->mass(1).mass > 0))
    fail_sdf(std::string("shape: a ") + d.shape->kind() + " has no inside; expected a solid");
  if (d.shape->planar()) fail_sdf(std::string("shape: a ") + d.shape->kind() + " is a 2D section; expected a solid");
  const Aabb box = d.shape->bounds(Pose{});
  const Real spacing = chosen_spacing(box, d.spacing);
  check_box(box, spacing);
  Truth truth;
  truth.distance = [&](const Vec3& p) {
    Vec3 normal;
    return d.shape->distance(p, kInfinity, normal);
  };
  const FieldLayout at = layout_around(box, spacing, kPadding, d.adaptive);
  if (d.shape->parts().size() < 2) return finish(sampled(at, d, truth), truth, {});
  // parts may lie in each other: the least of their distances is none of the whole
  return from_values(d, at, values_of(at, truth), truth);
}

}  // namespace

DistanceField thinned(const DistanceField& dense, Real tolerance) {
  const auto ask = [](const void* from, const Vec3& p) { return static_cast<const DistanceField*>(from)->at(p); };
  return DistanceField::adaptive(dense.layout(), kFineBand * dense.layout().spacing, tolerance, ask, &dense);
}

ShapePtr build_sdf_at(const SdfDesc& d, const Vec3& middle) { return from_function(d, middle); }

ShapePtr build_sdf(const SdfDesc& d) {
  const int sources = int(!d.triangles.empty() || !d.vertices.empty()) + int(d.shape != nullptr) +
                      int(d.function != nullptr) + int(!d.values.empty());
  if (sources != 1) fail_sdf("expected one of mesh, shape, fn and buffer, got " + std::to_string(sources));
  if (!(d.tolerance >= 0) || !is_finite(d.tolerance))
    fail_sdf("tolerance: expected a number not below 0, got " + text(d.tolerance));
  if (d.shape) return from_shape(d);
  if (d.function) return from_function(d, Vec3::Zero());
  if (!d.values.empty()) return from_given(d);
  return from_triangles(d, TriangleField(corners_with_area(d)));
}

}  // namespace feder
