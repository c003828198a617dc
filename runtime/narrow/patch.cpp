// The face of each core that looks along the contact normal (Shape::face); the one more parallel to the contact plane
// is the reference, the other is clipped against its sides (Sutherland and Hodgman 1974). Two parallel edges overlap
// in a segment; anything else touches in the nearest points alone. Those join the patch when clipping has lost the
// depth. A normal within 1 mrad of the reference face's is replaced by it, so that resting contacts do not tilt with
// the rounding of GJK.
// Keeps nothing between calls. Weak spot: round faces are their inscribed polygons; corners beyond kMaxFacePoints are
// left out.
#include "narrow/patch.h"

#include "narrow/clip.h"
#include "narrow/reduce.h"

namespace feder {
namespace {

constexpr Real kFaceCosine = Real(0.96);   // of the angle between normal and reference face: 16 degrees
constexpr Real kEdgeSine = Real(0.1);      // edges that are closer to parallel than 6 degrees share a segment
constexpr Real kSnapSquared = Real(1e-6);  // (1 mrad)^2
constexpr Real kSlack = Real(1e-4);        // of the reference face: flush sides keep their corners
constexpr std::uint32_t kSideLabel = kMaxFacePoints;

struct Outline {
  Vec3 p[kMaxFacePoints];
  int count = 0;
  Vec3 normal = Vec3::Zero();  // unit, outward; zero for points and edges
  Real size = 0;
};

// Newell's normal, which takes slightly bent loops.
void finish(Outline& o) {
  Vec3 n = Vec3::Zero();
  for (int i = 1; i < o.count; ++i) o.size = std::max(o.size, (o.p[i] - o.p[0]).cwiseAbs().maxCoeff());
  if (o.count < 3) return;
  for (int i = 2; i < o.count; ++i) n += cross(o.p[i - 1] - o.p[0], o.p[i] - o.p[0]);
  o.normal = normalized_or(n, Vec3::Zero());
}

using Clipped = ClipLoop<2 * kMaxFacePoints>;

// The corners of `incident` over the reference face, as points midway. `sign`: +1 when the reference belongs to a.
void clip_faces(const ConvexPair& pair, const Outline& reference, const Outline& incident, Real sign, Real margin,
                Patch& patch) {
  Clipped c;
  c.count = incident.count;
  for (int i = 0; i < c.count; ++i) c.p[i] = incident.p[i], c.edge[i] = static_cast<std::uint8_t>(i);
  const bool closed = incident.count > 2;
  const Vec3 n = sign * patch.normal;  // from reference to incident; the sides are parallel to it
  for (int i = 0; i < reference.count && c.count > 0; ++i) {
    const Vec3 &p = reference.p[i], e = reference.p[(i + 1) % reference.count] - p;
    const Vec3 m = normalized_or(cross(e, n), Vec3::Zero());
    const Real limit = dot(m, p) + kSlack * reference.size;
    clip(c, closed, static_cast<std::uint8_t>(kSideLabel + i), [&](const Vec3& q) { return dot(m, q) - limit; });
  }
  const Real along = dot(n, reference.normal), radii = pair.a.radius + pair.b.radius;
  const Real own = sign > 0 ? pair.b.radius : pair.a.radius;
  const std::uint32_t faces = feature_of(reference.p[0]) ^ feature_of(incident.p[0]) << 1;
  for (int i = 0; i < c.count; ++i) {
    const Real core = dot(reference.normal, c.p[i] - reference.p[0]) / along, separation = core - radii;
    if (separation > margin) continue;
    const int last = i > 0 ? i - 1 : (closed ? c.count - 1 : i);
    patch.points[patch.count++] = {c.p[i] - n * (own + separation / 2), separation,
                                   faces ^ (static_cast<std::uint32_t>(c.edge[last]) << 8 | c.edge[i])};
  }
}

// Two nearly parallel edges: the ends of their common stretch.
void clip_edges(const ConvexPair& pair, const Outline& ea, const Outline& eb, Real margin, Patch& patch) {
  const Vec3 u = ea.p[1] - ea.p[0], w = eb.p[1] - eb.p[0];
  const Real uu = dot(u, u), uw = dot(u, w), sine = length(cross(u, w));
  if (!(uu > 0) || sine > kEdgeSine * std::abs(uw)) return;
  // stretch of b's edge over a's, in parameters of a
  Real s0 = dot(eb.p[0] - ea.p[0], u) / uu, s1 = dot(eb.p[1] - ea.p[0], u) / uu;
  const Real b0 = s0, scale = uu / uw;
  if (s0 > s1) std::swap(s0, s1);
  s0 = clamp(s0, 0, 1), s1 = clamp(s1, 0, 1);
  if (s1 - s0 < Real(1e-3)) return;
  const Real radii = pair.a.radius + pair.b.radius;
  const std::uint32_t edges = feature_of(ea.p[0]) ^ feature_of(eb.p[0]) << 1;
  for (std::uint32_t k = 0; k < 2; ++k) {
    const Real s = k == 0 ? s0 : s1;
    const Vec3 p = ea.p[0] + s * u, q = eb.p[0] + ((s - b0) * scale) * w;
    const Real separation = dot(q - p, patch.normal) - radii;
    if (separation > margin) continue;
    patch.points[patch.count++] = {(p + q) / 2 + patch.normal * ((pair.a.radius - pair.b.radius) / 2), separation,
                                   edges ^ (k + 1)};
  }
}

}  // namespace

void contact_patch(const ConvexPair& pair, const Gap& gap, Real margin, Patch& patch) {
  patch.normal = narrow(gap.normal);
  patch.count = 0;
  patch.reference = 0;
  Outline fa, fb;
  fa.count = pair.a.face(patch.normal, fa.p);
  fb.count = pair.b.face(narrow(pair.direction_to_b(-gap.normal)), fb.p);
  for (int i = 0; i < fb.count; ++i) fb.p[i] = narrow(pair.from_b(wide(fb.p[i])));
  finish(fa);
  finish(fb);

  const Real parallel_a = dot(fa.normal, patch.normal), parallel_b = -dot(fb.normal, patch.normal);
  const bool first = parallel_a >= parallel_b - Real(1e-3);
  if (fa.count > 1 && fb.count > 1 && std::max(parallel_a, parallel_b) > kFaceCosine) {
    const Vec3 face_normal = first ? fa.normal : Vec3(-fb.normal), tilt = face_normal - patch.normal;
    if (dot(tilt, tilt) < kSnapSquared) patch.normal = face_normal;
    patch.reference = first ? 1 : 2;
    if (first)
      clip_faces(pair, fa, fb, 1, margin, patch);
    else
      clip_faces(pair, fb, fa, -1, margin, patch);
  } else if (fa.count == 2 && fb.count == 2) {
    clip_edges(pair, fa, fb, margin, patch);
  }

  // no point is deeper than the gap: what is, comes from the normal's rounding
  const Real separation = Real(gap.distance) - pair.a.radius - pair.b.radius;
  Real deepest = kInfinity;
  for (int i = 0; i < patch.count; ++i) {
    patch.points[i].separation = std::max(patch.points[i].separation, separation);
    deepest = std::min(deepest, patch.points[i].separation);
  }
  // the nearest points themselves, when no clipped point is as deep
  const Real rounding = kSlack * std::min(fa.size, fb.size) + 10 * kEpsilon * std::max(fa.size, fb.size);
  if (deepest > separation + rounding || patch.count == 0) {
    const Vec3 middle = narrow(0.5 * (gap.a + gap.b)) + patch.normal * ((pair.a.radius - pair.b.radius) / 2);
    patch.points[patch.count++] = {middle, separation, 0};
  }
}

int gap_manifold(const ConvexPair& pair, const Gap& gap, Real margin, const Pose& pose_a, Manifold& out) {
  Patch patch;
  contact_patch(pair, gap, margin, patch);
  reduce_points({patch.points, static_cast<std::size_t>(patch.count)}, patch.normal, out);
  const Mat3 r = to_matrix(pose_a.rotation);
  out.normal = r * patch.normal;
  for (int i = 0; i < out.count; ++i) out.points[i].position = pose_a.position + r * out.points[i].position;
  return 1;
}

}  // namespace feder
