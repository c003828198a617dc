// Solids joined, cut and grown as fields: minimum, maximum and difference of distances at the corners of a new grid
// around what is left. Exact on the surface away from where the two meet; beyond it the distance of a union outside and
// of the others inside is a bound: the band is measured anew when that is off by more than a twentieth on average.
// Weak spot: the edge where two surfaces meet is rounded by up to .9 of the spacing.
#include <algorithm>
#include <cmath>

#include "feder/error.h"
#include "geom/sdf.h"

namespace feder {
namespace {

constexpr int kPad = 3;  // cells

const Sdf* as_field(const Shape& s) { return is_sdf(s) ? &static_cast<const Sdf&>(s) : nullptr; }

// As by a function in a box that need not be about the origin.
ShapePtr resampled(const Aabb& box, Real spacing, bool adaptive, const std::function<Real(const Vec3&)>& distance) {
  const Vec3 middle = (box.lo + box.hi) / 2;
  SdfDesc d;
  d.function = [&](double x, double y, double z) { return double(distance(middle + Vec3(Real(x), Real(y), Real(z)))); };
  for (int k = 0; k < 3; ++k) d.size[k] = spacing * (2 * kPad + std::ceil((box.hi[k] - box.lo[k]) / spacing));
  d.spacing = spacing, d.adaptive = adaptive;
  return build_sdf_at(d, middle);
}

// On the grid of a itself, near b alone.
ShapePtr cut_from(const Sdf& a, const Shape& b, const Pose& place_b) {
  const FieldLayout& at = a.field().layout();
  std::vector<float> values = a.field().values();
  int lo[3], hi[3];
  at.range(b.bounds(place_b), kPad * at.spacing, lo, hi);
  for (int z = lo[2]; z <= hi[2]; ++z)
    for (int y = lo[1]; y <= hi[1]; ++y)
      for (int x = lo[0]; x <= hi[0]; ++x) {
        Vec3 normal;
        float& v = values[at.index(x, y, z)];
        v = std::max(v, static_cast<float>(-b.distance(to_local(place_b, at.corner(x, y, z)), kInfinity, normal)));
      }
  return std::make_shared<Sdf>(DistanceField(at, std::move(values)));
}

}  // namespace

ShapePtr combine_sdf(SdfOperation operation, const Shape& a, const Shape& b, const Pose& place_b) {
  const Sdf *fa = as_field(a), *fb = as_field(b);
  if (!fa && !fb)
    throw SceneError("expected at least one field, got a " + std::string(a.kind()) + " and a " + b.kind());
  for (const Shape* s : {&a, &b})
    if (!(s->mass(1).mass > 0)) throw SceneError(std::string("a ") + s->kind() + " has no inside");
  if (operation == SdfOperation::subtract && fa && !fa->field().is_adaptive()) return cut_from(*fa, b, place_b);
  Real spacing = kInfinity;
  bool adaptive = false;
  for (const Sdf* f : {fa, fb})
    if (f) spacing = std::min(spacing, f->field().layout().spacing), adaptive = adaptive || f->field().is_adaptive();
  Aabb box = fa ? fa->box() : a.bounds(Pose{});
  const Aabb other = b.bounds(place_b);
  if (operation == SdfOperation::unite) box.include(other);
  if (operation == SdfOperation::intersect)
    for (int k = 0; k < 3; ++k) {
      box.lo[k] = std::max(box.lo[k], other.lo[k]), box.hi[k] = std::min(box.hi[k], other.hi[k]);
      if (!(box.lo[k] < box.hi[k])) throw SceneError("nothing is left");
    }
  return resampled(box, spacing, adaptive, [&](const Vec3& p) {
    Vec3 normal;
    const Real da = a.distance(p, kInfinity, normal), db = b.distance(to_local(place_b, p), kInfinity, normal);
    switch (operation) {
      case SdfOperation::unite: return std::min(da, db);
      case SdfOperation::subtract: return std::max(da, -db);
      case SdfOperation::intersect: break;
    }
    return std::max(da, db);
  });
}

ShapePtr offset_sdf(const Shape& a, Real distance) {
  const Sdf* f = as_field(a);
  if (!f) throw SceneError(std::string("expected a field, got a ") + a.kind());
  if (!is_finite(distance)) throw SceneError("distance: expected a finite distance");
  Aabb box = f->box();
  box.grow(distance);
  for (int k = 0; k < 3; ++k)
    if (!(box.lo[k] < box.hi[k])) throw SceneError("nothing is left");
  return resampled(box, f->field().layout().spacing, f->field().is_adaptive(), [&](const Vec3& p) {
    Vec3 normal;
    return f->distance(p, kInfinity, normal) - distance;
  });
}

namespace {

// Itself and the corners beside it, also across edges and cells.
template <class F>
void each_beside(const FieldLayout& at, const int (&c)[3], F&& visit) {
  for (int z = std::max(c[2] - 1, 0); z <= std::min(c[2] + 1, at.n[2] - 1); ++z)
    for (int y = std::max(c[1] - 1, 0); y <= std::min(c[1] + 1, at.n[1] - 1); ++y)
      for (int x = std::max(c[0] - 1, 0); x <= std::min(c[0] + 1, at.n[0] - 1); ++x) visit(at.index(x, y, z));
}

// A part's values without the others: what was near these is measured anew from its own surface.
std::vector<float> alone(const FieldLayout& at, const std::vector<float>& values,
                         const std::vector<std::uint32_t>& part, std::uint32_t number) {
  std::vector<float> own = values;
  std::vector<std::uint8_t> near(values.size(), 0);  // to a corner of another
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(values[i] < 0) || part[i] == number) continue;
    own[i] = static_cast<float>(at.spacing);
    int c[3];
    at.place_of(i, c);
    each_beside(at, c, [&](std::size_t j) { near[j] = 1; });
  }
  const std::vector<float> measured = surface_distances(at, own);
  const auto cut_off = static_cast<float>(Real(1.2) * at.spacing);  // of a corner, by the cells' chamfer
  for (std::size_t i = 0; i < own.size(); ++i)
    if (own[i] >= 0 && (near[i] || std::abs(measured[i] - own[i]) > cut_off)) own[i] = measured[i];
  return own;
}

}  // namespace

// Corners inside that are beside each other hang together. A part's own field has the others' corners outside.
std::vector<ShapePtr> parts_of_sdf(const ShapePtr& field) {
  constexpr std::size_t kDust = 8;  // corners
  if (!is_sdf(*field)) throw SceneError(std::string("sdf_parts: expected a field, got a ") + field->kind());
  const DistanceField& of = static_cast<const Sdf&>(*field).field();
  const FieldLayout& at = of.layout();
  std::vector<float> values = of.values();
  if (of.is_adaptive()) {
    if (at.corners() > kMostSdfCorners) return {field};
    values = at.values([&](int x, int y, int z) { return of.at(at.corner(x, y, z)); });
  }
  std::vector<std::uint32_t> part(values.size(), 0), open;
  struct Found {
    std::uint32_t number;
    std::size_t corners;
  };
  std::vector<Found> found;
  for (std::size_t start = 0; start < values.size(); ++start) {
    if (!(values[start] < 0) || part[start] > 0) continue;
    const auto number = static_cast<std::uint32_t>(found.size() + 1);
    found.push_back({number, 0});
    part[start] = number, open.assign(1, static_cast<std::uint32_t>(start));
    while (!open.empty()) {
      const std::size_t i = open.back();
      open.pop_back();
      ++found.back().corners;
      int corner[3];
      at.place_of(i, corner);
      each_beside(at, corner, [&](std::size_t j) {
        if (!(values[j] < 0) || part[j] > 0) return;
        part[j] = number, open.push_back(static_cast<std::uint32_t>(j));
      });
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.corners > b.corners; });
  const std::size_t all = found.size();
  while (found.size() > 1 && found.back().corners < kDust) found.pop_back();
  if (all < 2) return {field};
  std::vector<ShapePtr> out;
  for (const Found& f : found) {
    DistanceField dense(at, alone(at, values, part, f.number));
    out.push_back(std::make_shared<Sdf>(of.is_adaptive() ? thinned(dense, 0) : std::move(dense)));
  }
  return out;
}

}  // namespace feder
