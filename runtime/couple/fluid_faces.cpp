// Screens, candidate contacts and projection of particles at faces. The tree of faces is built anew in every substep: a
// few hundred nanoseconds a face, and the same order of contacts after a snapshot. Kept between calls: nothing.
#include "couple/fluid_faces.h"

#include <algorithm>
#include <cmath>

#include "fluid/block_sums.h"
#include "geom/closest.h"
#include "geom/swept_triangle.h"

namespace feder {
namespace {

constexpr Real kSlack = Real(0.1);      // of the spacing: margin within which contacts are listed
constexpr Real kClearance = Real(0.3);  // of the distance at rest, that every particle keeps
constexpr Real kSameSide = Real(0.5);   // least cosine between the normals of a contact at the start and at the end
constexpr Real kClear = Real(0.75);     // of the distance at rest, from which on it is clear where an edge pushes to
constexpr Real kOffEdge = Real(0.02);   // least weight of each corner where a particle stays on a face

}  // namespace

void nearest_weights(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c, Vec3& q, Real (&w)[3]) {
  q = closest_on_triangle(x, a, b, c);
  plane_weights(q, a, b, c, w);
  Real sum = 0;
  for (Real& k : w) k = clamp(k, 0, 1), sum += k;
  FEDER_ASSERT(!(sum <= 0));
  for (Real& k : w) k /= sum;
}

void plane_weights(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c, Real (&w)[3]) {
  const Vec3 u = b - a, v = c - a, p = x - a, n = cross(u, v);
  const Real nn = dot(n, n);
  if (!(nn > 0)) return void((w[0] = 1, w[1] = w[2] = 0));
  w[1] = dot(n, cross(p, v)) / nn;
  w[2] = dot(n, cross(u, p)) / nn;
  w[0] = 1 - w[1] - w[2];
}

void FluidFaces::list_faces() {
  faces_.clear(), box_.clear();
  solids_ = Aabb{};
  for (std::uint32_t k = 0; k < surfaces.size(); ++k) {
    const FaceSurface& s = surfaces[k];
    for (std::size_t t = 0; t + 2 < s.triangles.size(); t += 3) {
      Face f;
      f.surface = k;
      Aabb box;
      for (int i = 0; i < 3; ++i) {
        f.v[i] = s.first + s.triangles[t + static_cast<std::size_t>(i)];
        FEDER_ASSERT(f.v[i] < start.size());
        box.include(start[f.v[i]]);
      }
      if (s.solid) solids_.include(box);
      box.grow(s.half);
      faces_.push_back(f), box_.push_back(box);
    }
  }
  tree_.build({box_.data(), box_.size()});
}

// Whether the box of a face meets that of a pool, and so keeps it awake (fluid/sleep.cpp).
bool FluidFaces::near_box(const FluidPool& p, const StepContext& c) const {
  Aabb box;
  for (std::uint32_t i = 0; i < p.count; ++i) box.include(p.x[i].vec());
  box.grow(p.support + c.dt * c.dt * length(c.gravity));
  for (std::size_t f = 0; f < faces_.size(); ++f)
    if (meets(p, surfaces[faces_[f].surface]) && overlaps(box_[f], box)) return true;
  return false;
}

void FluidFaces::screen(Fluid& fluid, const StepContext& c) {
  list_faces();
  const std::uint64_t number =
      c.step * static_cast<std::uint64_t>(c.substeps) + static_cast<std::uint64_t>(c.substep) + 1;
  for (std::size_t n = 0; n < fluid.pool_count(); ++n) {
    FluidPool& p = fluid.pool_at(n);
    if (p.count == 0 || p.frozen) continue;
    if (c.substep == 0 && near_box(p, c)) p.faces_near = c.step + 1;
    if (p.asleep && p.faces_near != c.step + 1) continue;
    p.keep_origins();
    const bool first = p.screened != number;  // of the couplings that screen in this substep
    FEDER_ASSERT(p.screened <= number);
    p.screened = number;
    const Real rest = p.desc.spacing / 2;
    c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t from, std::uint32_t to, int) {
      for (std::uint32_t i = from; i < to; ++i) {
        // nearest face within the support, as a plane boundary (sph/boundary_table.h)
        if (first) p.origin[i] = p.x[i], p.screen[i] = 0;
        const Vec3 x = p.x[i].vec();
        Aabb box{x, x};
        box.grow(p.support);
        Real nearest = p.support;
        tree_.query(box, [&](std::uint32_t f) {
          const Face& face = faces_[f];
          const FaceSurface& s = surfaces[face.surface];
          if (!meets(p, s)) return;
          const Vec3 q = closest_on_triangle(x, start[face.v[0]], start[face.v[1]], start[face.v[2]]);
          nearest = std::min(nearest, length(Vec3(x - q)) - s.half);
        });
        if (nearest < p.support)
          p.screen[i] =
              std::max(p.screen[i], static_cast<Real>(p.table->at(std::max(nearest, rest) / p.support).value));
      }
    });
  }
}

namespace {

// Twice the area of o, a, b in the plane of y and z, with the sign that the edge has for both of its faces: points on
// an edge are on one side of it.
bool left_of(const Vec3& x, std::uint32_t i, const Vec3& a, std::uint32_t j, const Vec3& b) {
  const bool turned = j < i;
  const Vec3 &from = turned ? b : a, &to = turned ? a : b;
  const double u = static_cast<double>(to[1]) - static_cast<double>(from[1]);
  const double v = static_cast<double>(to[2]) - static_cast<double>(from[2]);
  const double s = static_cast<double>(x[1]) - static_cast<double>(from[1]);
  const double t = static_cast<double>(x[2]) - static_cast<double>(from[2]);
  return (u * t - v * s >= 0) != turned;
}

}  // namespace

// By the winding number: of the faces that a ray along x meets, how many more it leaves by than it enters by.
std::uint32_t FluidFaces::solid_around(const FluidPool& p, const Vec3& x) const {
  Aabb ray{x, x};
  ray.hi[0] = solids_.hi[0];
  std::uint32_t around = kNone;
  for (std::uint32_t k = 0; k < surfaces.size() && around == kNone; ++k) {
    const FaceSurface& s = surfaces[k];
    if (!s.solid || !meets(p, s)) continue;
    int winding = 0;
    tree_.query(ray, [&](std::uint32_t at) {
      const Face& f = faces_[at];
      if (f.surface != k) return;
      const Vec3 &a = start[f.v[0]], &b = start[f.v[1]], &e = start[f.v[2]];
      const bool ab = left_of(x, f.v[0], a, f.v[1], b), be = left_of(x, f.v[1], b, f.v[2], e);
      if (ab != be || ab != left_of(x, f.v[2], e, f.v[0], a)) return;
      // which side of the face it is on: beyond it along x, where the face looks that way
      const Vec3 normal = cross(Vec3(b - a), Vec3(e - a));
      const bool behind = dot(normal, Vec3(x - a)) < 0;
      if (ab == behind) winding += ab ? 1 : -1;
    });
    if (winding > 0) around = k;
  }
  return around;
}

bool FluidFaces::mark_inside(FluidPool& p, const StepContext& c) const {
  if (!(solids_.lo[0] <= solids_.hi[0])) return false;  // there are none
  const Scratch::Frame frame(*c.scratch);
  const std::uint32_t blocks = block_count(p.count, kFluidGrain);
  std::uint8_t* any = c.scratch->take<std::uint8_t>(blocks);
  c.jobs->for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    std::uint8_t found = 0;
    for (std::uint32_t i = first; i < last; ++i) {
      const Vec3 x = p.x[i].vec();
      p.inside[i] = overlaps(solids_, Aabb{x, x}) && solid_around(p, x) != kNone;
      found |= p.inside[i];
    }
    any[first / kFluidGrain.items] = found;
  });
  return std::any_of(any, any + blocks, [](std::uint8_t b) { return b != 0; });
}

// To the nearest point of the skin, and from there to the clearance outside.
bool FluidFaces::way_out(const FluidPool& p, FaceContact& k, FaceHit& way) const {
  const Vec3 x = p.x[k.particle].vec();
  k.surface = solid_around(p, x);
  if (k.surface == kNone) return false;
  Real nearest = kInfinity;
  for (const Face& f : faces_) {
    if (f.surface != k.surface) continue;
    const Vec3 &a = start[f.v[0]], &b = start[f.v[1]], &e = start[f.v[2]];
    Vec3 q;
    Real weight[3];
    nearest_weights(x, a, b, e, q, weight);
    const Vec3 normal = cross(Vec3(b - a), Vec3(e - a));
    const Real far = length(Vec3(q - x));
    if (far >= nearest || !(dot(normal, normal) > 0)) continue;
    nearest = far;
    std::copy(f.v, f.v + 3, k.vertex), std::copy(weight, weight + 3, way.weight);
    way.normal = normalized_or(normal, Vec3(0, 1, 0));
    way.position = q;
  }
  if (nearest == kInfinity) return false;
  k.rest = p.desc.spacing / 2 + surfaces[k.surface].half;
  way.position += kClearance * k.rest * way.normal;
  return true;
}

void FluidFaces::find(Fluid& fluid) {
  FEDER_ASSERT(end.size() == start.size() && box_.size() == faces_.size());
  contacts.clear();
  moved_ = 0;
  allowed_ = kInfinity;
  for (std::size_t n = 0; n < fluid.pool_count(); ++n)
    allowed_ = std::min(allowed_, kSlack * fluid.pool_at(n).desc.spacing);
  // boxes of faces swept over the substep
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    Aabb& box = box_[f];
    for (const std::uint32_t v : faces_[f].v) box.include(end[v]);
  }
  tree_.refit({box_.data(), box_.size()});
  for (std::size_t n = 0; n < fluid.pool_count(); ++n) {
    FluidPool& p = fluid.pool_at(n);
    if (!p.active() || p.origin.empty()) continue;
    FEDER_ASSERT(p.origin.size() > p.count);
    const Real slack = kSlack * p.desc.spacing, half = p.desc.spacing / 2;
    for (std::uint32_t i = 0; i < p.count; ++i) {
      const Vec3 from = p.origin[i].vec(), to = p.x[i].vec();
      if (!is_finite(to)) continue;  // removed at the end of the step
      Aabb box{from.cwiseMin(to), from.cwiseMax(to)};
      box.grow(half + slack);
      const std::size_t first = contacts.size();
      tree_.query(box, [&](std::uint32_t at) {
        const Face& f = faces_[at];
        const FaceSurface& s = surfaces[f.surface];
        if (!meets(p, s)) return;
        FaceContact k;
        const Vec3 a = start[f.v[0]], b = start[f.v[1]], e = start[f.v[2]];
        Vec3 q, path = to - from;
        nearest_weights(from, a, b, e, q, k.weight);
        // faces within the motion of both sides
        Real fastest = 0;
        for (int j = 0; j < 3; ++j) fastest = std::max(fastest, length(Vec3(end[f.v[j]] - start[f.v[j]])));
        fastest += length(path);
        k.distance = length(Vec3(from - q));
        k.rest = half + s.half;
        if (k.distance > k.rest + slack + fastest) return;
        // the contact, with the normal to the particle's side
        k.pool = static_cast<std::uint32_t>(n), k.particle = i, k.surface = f.surface;
        for (int j = 0; j < 3; ++j) k.vertex[j] = f.v[j];
        const Vec3 up = normalized_or(cross(Vec3(b - a), Vec3(e - a)), Vec3(0, 1, 0));
        // exactly on the face: back to where it came from
        const Vec3 back = dot(up, path) > 0 ? Vec3(-up) : up;
        k.normal = k.distance > Real(1e-4) * p.desc.spacing ? Vec3((from - q) / k.distance) : back;
        if (fastest <= k.rest) aim(k, from, to);
        FEDER_ASSERT(is_direction(k.normal) && sums_to(k.weight, 1) && k.rest > 0);
        contacts.push_back(k);
      });
      // in the order of the faces' points: the order of the tree may depend on earlier steps
      std::sort(contacts.begin() + static_cast<std::ptrdiff_t>(first), contacts.end(),
                [](const FaceContact& x, const FaceContact& y) {
                  return std::lexicographical_compare(x.vertex, x.vertex + 3, y.vertex, y.vertex + 3);
                });
    }
  }
}

// The contact as it will be at the end of a substep in which neither side goes far, unless the particle would pass the
// face: by the line at the start a particle that slides along a sheet runs into each next face, tilted as it is seen
// from afar.
void FluidFaces::aim(FaceContact& k, const Vec3& from, const Vec3& to) const {
  const auto corner = [&](int i) { return end[k.vertex[i]]; };
  Vec3 q;
  Real weight[3];
  nearest_weights(to, corner(0), corner(1), corner(2), q, weight);
  const Vec3 apart = to - q, normal = normalized_or(apart, k.normal);
  const bool on_edge = *std::min_element(weight, weight + 3) < kOffEdge;
  if (dot(normal, k.normal) < kSameSide || (on_edge && length(apart) < kClear * k.rest)) return;
  Vec3 then = Vec3::Zero();
  for (int i = 0; i < 3; ++i) then += weight[i] * start[k.vertex[i]];
  std::copy(weight, weight + 3, k.weight);
  // no overlap that there was not: the rows would take it out, and hold the particle by it
  k.normal = normal, k.distance = std::max(dot(normal, Vec3(from - then)), std::min(k.distance, k.rest));
}

bool FluidFaces::near(Fluid& fluid, const FaceSurface& s, std::span<const Vec3> points, const StepContext& c) {
  Real fastest = 0;
  for (std::size_t n = 0; n < fluid.pool_count(); ++n) fastest = std::max(fastest, fluid.pool_at(n).max_speed());
  const Real margin = c.dt * (fastest + c.dt * length(c.gravity));
  Aabb all;
  for (const std::uint32_t v : s.triangles) all.include(points[s.first + v]);
  all.grow(s.half + margin);
  for (std::size_t n = 0; n < fluid.pool_count(); ++n) {
    const FluidPool& p = fluid.pool_at(n);
    if (!meets(p, s)) continue;
    for (std::uint32_t i = 0; i < p.count; ++i) {
      const Vec3 x = p.x[i].vec();
      if (!overlaps(all, Aabb{x, x})) continue;
      const Real far = s.half + margin + p.desc.spacing / 2;
      for (std::size_t t = 0; t + 2 < s.triangles.size(); t += 3) {
        const std::uint32_t* v = &s.triangles[t];
        const Vec3 q = closest_on_triangle(x, points[s.first + v[0]], points[s.first + v[1]], points[s.first + v[2]]);
        if (length(Vec3(x - q)) < far) return true;
      }
    }
  }
  return false;
}

// A particle that met a face stays on it to the end of the substep, at the point where they met: wherever the sheet
// went meanwhile, that is on its side of it. Then it leaves it for its clearance, as far as no other face is in
// between: a fold closes over particles without losing them.
const FaceContact* FluidFaces::first_met(std::span<const FaceContact> of, const Vec3& from, const Vec3& to,
                                         FaceHit& hit) const {
  const auto corners = [](const FaceContact& k, const Array<Vec3>& at, Vec3(&out)[3]) {
    for (int i = 0; i < 3; ++i) out[i] = at[k.vertex[i]];
  };
  const FaceContact* by = nullptr;
  SweptHit met;
  for (const FaceContact& k : of) {
    Vec3 then[3], now[3];
    corners(k, start, then), corners(k, end, now);
    if (SweptTriangle(from, to, then, now).first(met)) by = &k;
  }
  Vec3 now[3];
  if (by) {
    corners(*by, end, now);
    Real sum = 0;
    for (int i = 0; i < 3; ++i) hit.weight[i] = std::max(met.weight[i], kOffEdge), sum += hit.weight[i];
    Vec3 on = Vec3::Zero();
    for (int i = 0; i < 3; ++i) hit.weight[i] /= sum, on += hit.weight[i] * now[i];
    const Vec3 front = normalized_or(cross(Vec3(now[1] - now[0]), Vec3(now[2] - now[0])), by->normal);
    hit.normal = met.from_front ? front : Vec3(-front);
    hit.position = clear_of_others(on, on + kClearance * by->rest * hit.normal, by);
    return by;
  }
  for (const FaceContact& k : of) {
    Vec3 then[3];
    corners(k, start, then), corners(k, end, now);
    const Vec3 up0 = normalized_or(cross(Vec3(then[1] - then[0]), Vec3(then[2] - then[0])), k.normal);
    const Vec3 up1 = normalized_or(cross(Vec3(now[1] - now[0]), Vec3(now[2] - now[0])), k.normal);
    const Real before = dot(up0, Vec3(from - then[0])), after = dot(up1, Vec3(to - now[0]));
    const Real side = before < 0 ? Real(-1) : Real(1), keep = kClearance * k.rest;
    if (after * side < 0 || after * side >= keep || before * side < keep / 2) continue;
    plane_weights(to, now[0], now[1], now[2], hit.weight);
    if (*std::min_element(hit.weight, hit.weight + 3) < 0) continue;
    hit.normal = side * up1;
    hit.position = clear_of_others(to, to + (keep - after * side) * hit.normal, &k);
    return &k;
  }
  return nullptr;
}

Vec3 FluidFaces::clear_of_others(const Vec3& from, const Vec3& to, const FaceContact* on) const {
  Aabb box{from.cwiseMin(to), from.cwiseMax(to)};
  box.grow(length(Vec3(to - from)));
  SweptHit met;
  tree_.query(box, [&](std::uint32_t f) {
    const Face& face = faces_[f];
    if (std::equal(face.v, face.v + 3, on->vertex)) return;
    const Vec3 now[3] = {end[face.v[0]], end[face.v[1]], end[face.v[2]]};
    SweptTriangle(from, to, now, now).first(met);
  });
  return met.when > 1 ? to : Vec3(from + static_cast<Real>(met.when / 2) * (to - from));
}

void FluidFaces::validate() const {
  FEDER_ASSERT(start.size() == end.size() && box_.size() == faces_.size());
  for (const Face& f : faces_)
    FEDER_ASSERT(f.surface < surfaces.size() && std::max({f.v[0], f.v[1], f.v[2]}) < start.size());
  for (std::size_t n = 0; n < contacts.size(); ++n) {
    const FaceContact& k = contacts[n];
    FEDER_ASSERT(k.surface < surfaces.size() && std::max({k.vertex[0], k.vertex[1], k.vertex[2]}) < end.size());
    if (n == 0) continue;
    const FaceContact& last = contacts[n - 1];
    FEDER_ASSERT(last.pool != k.pool ? last.pool < k.pool : last.particle <= k.particle);
    FEDER_ASSERT(last.pool != k.pool || last.particle != k.particle ||
                 !std::lexicographical_compare(k.vertex, k.vertex + 3, last.vertex, last.vertex + 3));
  }
}

}  // namespace feder
