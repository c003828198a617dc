// The shape of a distance field. Volume, centre and moments: cells near the surface by 3 x 3 x 3 parts, from which the
// bias of trilinear values (t (1 - t) h^2/2 times the second derivative along each axis) is taken off. Rays: sphere
// tracing, Hart 1996, with bisection where the sign changes. Reads only after it is made.
// Weak spots: a ray may step over what is thinner than a twentieth of a cell; the hull is that of 2048 directions.
#include "geom/sdf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "base/double3.h"
#include "base/trig.h"
#include "feder/error.h"
#include "geom/point_groups.h"

namespace feder {
namespace {

constexpr int kHullDirections = 2048;
constexpr Real kHullSlack = Real(0.0015);  // of the extent: what so many directions leave out of a ball
constexpr int kMaxBalls = 12, kBallSeeds = 256;
constexpr Real kOfDetail = Real(1.2);  // samples are so many half widths of details apart
constexpr Real kBlunt = 4;             // cells that a sample may lie farther in than one on an edge
constexpr int kParts = 3;              // of a cell, along each axis, for the volume
constexpr Real kShort = Real(0.4);     // a slope that says no direction

Real half_diagonal(const Aabb& box) { return length(box.hi - box.lo) / 2; }

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", x);
  return text;
}

// The i-th of `count` directions spread evenly (golden angle).
Vec3 spread_direction(int i, int count) {
  const double y = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - y * y), angle = 2.39996322972865332 * i;
  return Vec3(Real(r * cosine(angle)), Real(y), Real(r * sine(angle)));
}

}  // namespace

Sdf::Sdf(DistanceField field) : Shape("sdf", false), field_(std::move(field)) {
  IsoMesh mesh;
  surface(mesh);
  if (mesh.triangles.empty())
    throw SceneError("sdf: nothing is inside; walls thinner than the spacing (" + number(field_.layout().spacing) +
                     " m) are lost, a function is negative inside");
  for (const Vec3& v : mesh.vertices) box_.include(v);
  take_samples(mesh);
  take_hull(mesh);
  integrate();
  if (!(unit_.mass > 0)) throw SceneError("sdf: its volume is not above 0; a field is negative inside");
  take_balls();
}

void Sdf::surface(IsoMesh& mesh) const {
  const FieldLayout& at = field_.layout();
  const IsoGrid grid{at.origin, at.spacing, {at.n[0], at.n[1], at.n[2]}};
  std::vector<std::uint32_t> blocks;  // that the surface may pass
  const Real reach = Real(0.8661) * at.spacing * IsoGrid::kBlock;
  for (std::uint32_t i = 0, count = grid.block_count(); i < count; ++i) {
    const IsoBlock b(grid, i);
    Vec3 middle;
    for (int k = 0; k < 3; ++k) middle[k] = grid.coordinate(k, b.first[k]) + at.spacing * Real(b.count[k] - 1) / 2;
    if (std::abs(field_.at(middle)) <= reach + 2 * at.spacing) blocks.push_back(i);
  }
  IsoSurface iso;
  const auto sample = [&](const IsoBlock& b, Real* values) {
    for (int z = 0; z < b.count[2]; ++z)
      for (int y = 0; y < b.count[1]; ++y)
        for (int x = 0; x < b.count[0]; ++x)
          values[x + IsoBlock::kRow * y + IsoBlock::kLayer * z] =
              -field_.at(at.corner(b.first[0] + x, b.first[1] + y, b.first[2] + z));
  };
  iso.extract_blocks(grid, blocks, sample, 0, true, mesh);
}

// Half of how thick teeth and walls, or how wide grooves are across the finer fifth of the surface.
Real Sdf::detail(const std::vector<Vec3>& at, const std::vector<Vec3>& normals) const {
  std::vector<Real> widths;
  const std::size_t stride = std::max<std::size_t>(1, at.size() / kBallSeeds);
  const Real step = field_.layout().spacing / 2;
  for (std::size_t i = 0; i < at.size(); i += stride) {
    Real least = 2 * half_diagonal(box_);
    for (const Real side : {Real(-1), Real(1)})
      for (Real t = 2 * step; t < least; t += step)
        if (side * field_.at(at[i] + side * t * normals[i]) < 0) least = t;
    widths.push_back(least);
  }
  std::sort(widths.begin(), widths.end());
  return widths[widths.size() / 5] / 2;
}

// One vertex of those in a cube about as large as the spacing of samples, for each of six ways to look.
void Sdf::take_samples(const IsoMesh& mesh) {
  double area = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    const Vec3 &a = mesh.vertices[mesh.triangles[i]], &b = mesh.vertices[mesh.triangles[i + 1]];
    area += double(length(cross(b - a, mesh.vertices[mesh.triangles[i + 2]] - a))) / 2;
  }
  struct Found {
    std::array<std::int32_t, 4> cube;
    Real near;  // less: farther out, so that the corners of a foot stay, but on a face
    std::uint32_t vertex;
    auto operator<=>(const Found&) const = default;
  };
  std::vector<Found> found;
  std::vector<Vec3> normals;
  std::vector<Real> blunt;  // by how much the slope is short: at edges
  normals.reserve(mesh.vertices.size()), blunt.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) {
    Vec3 slope;
    field_.smooth_at(v, slope);
    normals.push_back(normalized_or(slope, Vec3(0, 1, 0)));
    blunt.push_back(std::max(1 - length(slope), Real(0)));
  }
  const Real h = field_.layout().spacing;
  const auto spaced = [&](std::size_t count) { return Real(std::sqrt(1.5 * area / double(count))); };
  const Real fine = kOfDetail * detail(mesh.vertices, normals);
  sample_spacing_ = std::max({h, std::min(fine, spaced(kSamples)), spaced(kMostSamples)});
  for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
    Found f{{}, 0, i};
    for (int k = 0; k < 3; ++k) {
      const Real u = (mesh.vertices[i][k] - box_.lo[k]) / sample_spacing_;
      f.cube[std::size_t(k)] = static_cast<std::int32_t>(std::floor(u));
    }
    f.near = kBlunt * field_.layout().spacing * blunt[i] - length(mesh.vertices[i] - (box_.lo + box_.hi) / 2);
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (std::abs(normals[i][k]) > std::abs(normals[i][axis])) axis = k;
    f.cube[3] = 2 * axis + (normals[i][axis] < 0);
    found.push_back(f);
  }
  std::sort(found.begin(), found.end());
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (i == 0 || found[i].cube != found[i - 1].cube)
      samples.push_back({mesh.vertices[found[i].vertex], normals[found[i].vertex]});
  std::vector<Aabb> boxes;
  boxes.reserve(samples.size());
  for (const Sample& s : samples) boxes.push_back({s.at, s.at});
  tree_.build(boxes);
  samples_.reserve(samples.size());
  for (const std::uint32_t i : tree_.order()) samples_.push_back(samples[i]);
  tree_.number_in_order();
}

void Sdf::take_hull(const IsoMesh& mesh) {
  const auto all = grouped(mesh.vertices.size(), [&](std::size_t i) -> const Vec3& { return mesh.vertices[i]; });
  std::vector<std::uint32_t> chosen;
  for (int i = 0; i < kHullDirections; ++i) {
    const Vec3 d = spread_direction(i, kHullDirections);
    chosen.push_back(point_kernel()->farthest(all.data(), groups_in(all), d[0], d[1], d[2]));
  }
  for (int k = 0; k < 6; ++k) {  // the box exactly
    Vec3 d = Vec3::Zero();
    d[k / 2] = k % 2 ? Real(1) : Real(-1);
    chosen.push_back(point_kernel()->farthest(all.data(), groups_in(all), d[0], d[1], d[2]));
  }
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  hull_ = grouped(chosen.size(), [&](std::size_t i) -> const Vec3& { return mesh.vertices[chosen[i]]; });
  hull_points_ = static_cast<std::uint32_t>(chosen.size());
  hull_slack_ = kHullSlack * half_diagonal(box_);
}

// From the surface inwards as far as the distance grows with the way.
void Sdf::take_balls() {
  std::vector<Ball> all;
  const std::size_t stride = std::max<std::size_t>(1, samples_.size() / kBallSeeds);
  const Real step = field_.layout().spacing / 2;
  for (std::size_t i = 0; i < samples_.size(); i += stride) {
    const Sample& s = samples_[i];
    Ball ball{s.at, 0};
    for (Real t = step; t < 2 * half_diagonal(box_); t += step) {
      const Vec3 at = s.at - t * s.normal;
      const Real depth = -field_.at(at);
      if (!(depth > Real(0.9) * t)) break;
      ball = {at, depth};
    }
    if (ball.radius > 0) all.push_back(ball);
  }
  std::stable_sort(all.begin(), all.end(), [](const Ball& a, const Ball& b) { return a.radius > b.radius; });
  for (const Ball& b : all) {
    if (balls_.size() == kMaxBalls) break;
    const bool covered = std::any_of(balls_.begin(), balls_.end(), [&](const Ball& o) {
      return length(o.center - b.center) < std::max(o.radius, Real(0.25) * half_diagonal(box_));
    });
    if (!covered) balls_.push_back(b);
  }
  for (const ShapeKind& kind : shape_kinds())
    if (!std::strcmp(kind.name, "sphere"))
      for (const Ball& b : balls_) ball_shapes_.push_back({make_sphere(b.radius), {b.center, {}}});
}

namespace {

// Sums over small cubes of the solid.
struct SolidSum {
  double volume = 0, first[3] = {0, 0, 0}, second[3][3] = {};
  void add(const Vec3& at, double v, double side) {
    volume += v;
    for (int i = 0; i < 3; ++i) {
      first[i] += v * double(at[i]);
      for (int j = 0; j < 3; ++j) second[i][j] += v * double(at[i]) * double(at[j]);
      second[i][i] += v * side * side / 12;
    }
  }
};

}  // namespace

void Sdf::integrate() {
  const FieldLayout& at = field_.layout();
  const Real h = at.spacing, part = h / kParts;
  const Vec3 origin = (box_.lo + box_.hi) / 2;  // moments about it lose no digits
  SolidSum sum;
  const auto add_cell = [&](const Vec3& corner) {
    const Vec3 middle = corner + Vec3::Constant(h / 2);
    const Real d = field_.at(middle);
    if (d > Real(1.4) * h) return;
    if (d < Real(-1.4) * h) return sum.add(middle - origin, double(h) * h * h, h);
    Vec3 second;  // derivatives times h^2
    for (int k = 0; k < 3; ++k) {
      Vec3 step = Vec3::Zero();
      step[k] = h;
      second[k] = clamp(field_.at(middle + step) - 2 * d + field_.at(middle - step), -h / 2, h / 2);
    }
    for (int z = 0; z < kParts; ++z)
      for (int y = 0; y < kParts; ++y)
        for (int x = 0; x < kParts; ++x) {
          const Vec3 t = Vec3(Real(2 * x + 1), Real(2 * y + 1), Real(2 * z + 1)) / Real(2 * kParts);
          const Vec3 p = corner + h * t;
          Real value = field_.at(p);
          for (int k = 0; k < 3; ++k) value -= t[k] * (1 - t[k]) / 2 * second[k];
          const Real share = clamp(Real(0.5) - value / (Real(1.3) * part), 0, 1);
          if (share > 0) sum.add(p - origin, double(share) * part * part * part, part);
        }
  };
  constexpr int kBlock = 8;
  for (int z = 0; z + 1 < at.n[2]; z += kBlock)
    for (int y = 0; y + 1 < at.n[1]; y += kBlock)
      for (int x = 0; x + 1 < at.n[0]; x += kBlock) {
        const int count[3] = {std::min(kBlock, at.n[0] - 1 - x), std::min(kBlock, at.n[1] - 1 - y),
                              std::min(kBlock, at.n[2] - 1 - z)};
        const Vec3 half = h / 2 * Vec3(Real(count[0]), Real(count[1]), Real(count[2]));
        const Real d = field_.at(at.corner(x, y, z) + half);
        if (d > length(half) + 2 * h) continue;
        for (int k = 0; k < count[2]; ++k)
          for (int j = 0; j < count[1]; ++j)
            for (int i = 0; i < count[0]; ++i) add_cell(at.corner(x + i, y + j, z + k));
      }
  unit_.mass = Real(sum.volume);
  if (!(sum.volume > 0)) return;
  double center[3], covariance[3][3], trace = 0;
  for (int i = 0; i < 3; ++i) center[i] = sum.first[i] / sum.volume;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) covariance[i][j] = sum.second[i][j] - sum.volume * center[i] * center[j];
  for (int i = 0; i < 3; ++i) trace += covariance[i][i];
  for (int i = 0; i < 3; ++i) {
    unit_.center[i] = origin[i] + Real(center[i]);
    for (int j = 0; j < 3; ++j) unit_.inertia(i, j) = Real((i == j ? trace : 0) - covariance[i][j]);
  }
}

Aabb Sdf::bounds(const Pose& pose) const {
  Aabb box = bounds_of(hull_, pose);
  box.grow(hull_slack_);
  return box;
}

MassProperties Sdf::mass(Real density) const { return {density * unit_.mass, unit_.center, density * unit_.inertia}; }

Real Sdf::extent(const Vec3& center) const {
  Real far = 0;
  for (std::uint32_t i = 0; i < hull_points_; ++i) {
    const Lane8x3& g = hull_[i / kLanes];
    far = std::max(far, length(Vec3(g.x.v[i % kLanes], g.y.v[i % kLanes], g.z.v[i % kLanes]) - center));
  }
  return far + hull_slack_;
}

Vec3 Sdf::hull_support(const Vec3& direction) const {
  const std::uint32_t i =
      point_kernel()->farthest(hull_.data(), groups_in(hull_), direction[0], direction[1], direction[2]);
  const Lane8x3& g = hull_[i / kLanes];
  return Vec3(g.x.v[i % kLanes], g.y.v[i % kLanes], g.z.v[i % kLanes]);
}

Real Sdf::distance(const Vec3& p, Real limit, Vec3& normal) const {
  // far outside of the box that is near enough
  Real out = 0;
  for (int k = 0; k < 3; ++k) out = std::max({out, box_.lo[k] - p[k], p[k] - box_.hi[k]});
  Vec3 slope;
  if (out > limit) {
    normal = normalized_or(p - (box_.lo + box_.hi) / 2, Vec3(0, 1, 0));
    return out;
  }
  const Real d = field_.smooth_at(p, slope);
  if (!(dot(slope, slope) > kShort * kShort)) slope = slope_across(p, d);
  normal = normalized_or(slope, Vec3(0, 1, 0));
  return d;
}

// Where several surfaces are equally near: away from one of them.
Vec3 Sdf::slope_across(const Vec3& p, Real d) const {
  const Real h = field_.layout().spacing, sign = d < 0 ? Real(-1) : Real(1);
  Vec3 best = Vec3(0, 1, 0);
  Real nearest = kInfinity;
  for (int k = 0; k < 6; ++k) {
    Vec3 step = Vec3::Zero();
    step[k / 2] = k % 2 ? h : -h;
    const Real there = sign * field_.at(p + step);
    if (there < nearest) nearest = there, best = -sign * step;
  }
  return best;
}

bool Sdf::raycast(const Vec3& origin, const Vec3& ray, RayHit& hit) const {
  const Real whole = length(ray), h = field_.layout().spacing;
  // the part of the ray in the box of the surface, in fractions
  Real enter = 0, leave = 1;
  for (int k = 0; k < 3; ++k) {
    if (ray[k] == 0) {
      if (origin[k] < box_.lo[k] || origin[k] > box_.hi[k]) return false;
      continue;
    }
    const Real a = (box_.lo[k] - origin[k]) / ray[k], b = (box_.hi[k] - origin[k]) / ray[k];
    enter = std::max(enter, std::min(a, b)), leave = std::min(leave, std::max(a, b));
  }
  if (!(enter <= leave)) return false;
  if (enter == 0 && field_.at(origin) < 0) {
    hit = {0, Vec3::Zero()};
    return true;
  }
  if (whole == 0) return false;
  // in metres from where it enters the box: fractions of a long ray have no digits for its cells
  const Vec3 start = origin + enter * ray, along = normalized_or(ray, Vec3(0, 1, 0));
  const Real way = (leave - enter) * whole;
  if (!(way < 4 * half_diagonal(box_))) return false;  // not finite
  Real s = 0, last = 0;
  while (!(field_.at(start + s * along) < 0)) {
    if (s >= way) return false;
    last = s;
    s = std::min(way, s + std::max(Real(0.9) * field_.at(start + s * along), Real(0.05) * h));
  }
  Real outside = last, inside = s;
  for (int i = 0; i < 24; ++i) {
    const Real middle = (outside + inside) / 2;
    (field_.at(start + middle * along) < 0 ? inside : outside) = middle;
  }
  Vec3 slope;
  field_.smooth_at(start + outside * along, slope);
  hit = {std::min(enter + outside / whole, Real(1)), normalized_or(slope, Vec3(-along))};
  return true;
}

// Its content: the length of the warnings, the warnings a line each, then the field.
ShapeArguments Sdf::arguments() const {
  ShapeArguments out{.sizes = {error_}};
  std::string lines;
  for (const std::string& w : warnings_) lines += w + "\n";
  const std::uint64_t length = lines.size();
  out.content.assign(reinterpret_cast<const char*>(&length), sizeof length);
  out.content += lines + field_.content();
  return out;
}

namespace {

ShapePtr from_content(const ShapeInput& in) {
  std::uint64_t length = 0;
  if (in.content.size() < sizeof length) throw SceneError("sdf: its content is cut short");
  std::memcpy(&length, in.content.data(), sizeof length);
  std::string_view rest = in.content.substr(sizeof length);
  if (length > rest.size()) throw SceneError("sdf: its content is cut short");
  std::string_view lines = rest.substr(0, length);
  std::vector<std::string> warnings;
  for (std::size_t end; (end = lines.find('\n')) != std::string_view::npos; lines.remove_prefix(end + 1))
    warnings.emplace_back(lines.substr(0, end));
  const auto made = std::make_shared<Sdf>(DistanceField::from_content(rest.substr(length)));
  made->certify(in.sizes.empty() ? Real(-1) : in.size(0), std::move(warnings));
  return made;
}

}  // namespace

SdfReport Sdf::report() const {
  SdfReport r;
  const FieldLayout& at = field_.layout();
  for (int k = 0; k < 3; ++k) r.cells[k] = at.n[k] - 1;
  r.spacing = at.spacing, r.bytes = field_.bytes(), r.adaptive = field_.is_adaptive();
  r.error = error_, r.warnings = warnings_;
  return r;
}

std::string Sdf::describe() const {
  const SdfReport r = report();
  std::string text = "field of " + std::to_string(r.cells[0]) + " x " + std::to_string(r.cells[1]) + " x " +
                     std::to_string(r.cells[2]) + " cells, spacing " + number(r.spacing) + " m" +
                     (r.adaptive ? ", adaptive, " : ", ") + std::to_string((r.bytes + 1023) / 1024) + " KiB";
  if (r.error >= 0) text += ", largest error near the surface " + number(r.error) + " m";
  return text;
}

bool is_sdf(const Shape& shape) { return shape_kinds()[static_cast<std::size_t>(shape.kind_id())].fields != nullptr; }

namespace {

const SdfMakers kMakers = {
    build_sdf,
    combine_sdf,
    offset_sdf,
    parts_of_sdf,
    [](const Shape& s) { return static_cast<const Sdf&>(s).report(); },
    [](const Shape& s) {
      IsoMesh mesh;
      static_cast<const Sdf&>(s).surface(mesh);
      return SdfSurface{std::move(mesh.vertices), std::move(mesh.normals), std::move(mesh.triangles)};
    }};

}  // namespace

ShapeKind geom_sdf() {
  return {"sdf",
          "{ mesh = | shape = | fn = | buffer =, size =, spacing =, adaptive =, tolerance =, acquire = }",
          "any solid by its distances on a grid, for bodies that are not convex",
          {},
          {},
          from_content,
          [] {
            SdfDesc torus, box;
            torus.function = [](double x, double y, double z) {
              const double r = std::sqrt(x * x + z * z) - 1;
              return std::sqrt(r * r + y * y) - 0.3;
            };
            torus.size = Vec3(3, 1, 3), torus.spacing = Real(0.04);
            box.shape = make_box(1, 2, Real(0.7)), box.spacing = Real(0.04), box.adaptive = true;
            return std::vector<ShapePtr>{build_sdf(torus), build_sdf(box)};
          },
          false,
          "field, distance_field, voxels",
          &kMakers};
}

}  // namespace feder
