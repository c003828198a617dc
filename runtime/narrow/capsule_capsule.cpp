// Capsule against capsule: the nearest points of the two segments (Ericson, Real-Time Collision Detection, 5.1.9).
// Nearly parallel ones touch along the stretch they share: one point at each of its ends, so that they lie still.
// Keeps nothing between calls. Weak spot: at 6 degrees from parallel the second point appears or goes at once.
#include "narrow/narrow_phase.h"
#include "narrow/round.h"

namespace feder {
namespace {

constexpr Real kParallelSquared = Real(0.01);  // sine of 6 degrees, squared
constexpr Real kMinStretch = Real(1e-3);       // of the radii: shorter common stretches are one point

struct Segment {
  Vec3 middle, axis;  // axis: unit
  Real half;

  Segment(const Shape& s, const Pose& p)
      : middle(p.position), axis(rotate(p.rotation, vec3(0, 1, 0))), half(s.support(vec3(0, 1, 0))[1]) {}
  Vec3 at(Real t) const { return middle + t * axis; }
};

// Parameters of the nearest points.
void nearest(const Segment& a, const Segment& b, Real& s, Real& t) {
  const Vec3 d = b.middle - a.middle;
  const Real e = dot(a.axis, b.axis), da = dot(d, a.axis), db = dot(d, b.axis), sine = 1 - e * e;
  s = sine > Real(1e-6) ? clamp((da - e * db) / sine, -a.half, a.half) : clamp(da, -a.half, a.half);
  t = clamp(e * s - db, -b.half, b.half);
  s = clamp(e * t + da, -a.half, a.half);
}

int capsule_capsule(const Shape& shape_a, const Pose& pose_a, const Shape& shape_b, const Pose& pose_b, Real margin,
                    PairCache&, Manifold* out) {
  const Segment a(shape_a, pose_a), b(shape_b, pose_b);
  const Real ra = shape_a.radius(), rb = shape_b.radius();
  Real s, t;
  nearest(a, b, s, t);
  Vec3 aside = cross(a.axis, b.axis);
  aside = normalized_or(aside, rotate(pose_a.rotation, vec3(1, 0, 0)));
  if (dot(aside, b.middle - a.middle) < 0) aside = -aside;
  if (round_contact(a.at(s), ra, b.at(t), rb, margin, aside, *out) == 0) return 0;

  // the ends of b's segment over a's
  const Real e = dot(a.axis, b.axis), da = dot(b.middle - a.middle, a.axis);
  const Real lo = std::max(-a.half, da - b.half * std::abs(e)), hi = std::min(a.half, da + b.half * std::abs(e));
  const Vec3 across = cross(a.axis, b.axis);
  if (dot(across, across) > kParallelSquared || hi - lo < kMinStretch * (ra + rb)) return 1;
  const ManifoldPoint one = out->points[0];
  int count = 0;
  for (std::uint32_t k = 0; k < 2; ++k) {
    const Real u = k == 0 ? lo : hi;
    const Vec3 p = a.at(u), q = b.at(clamp((u - da) / e, -b.half, b.half));
    const Real separation = std::max(dot(q - p, out->normal) - ra - rb, one.separation);
    if (separation > margin) continue;
    out->points[count++] = {(p + q) / 2 + out->normal * ((ra - rb) / 2), separation, k + 1};
  }
  // the nearest points stay when neither end is as deep
  const Real depth = std::min(out->points[0].separation, count > 1 ? out->points[1].separation : kInfinity);
  if (count == 0 || depth > one.separation + Real(1e-4) * (ra + rb)) out->points[count++] = one;
  out->count = count;
  return 1;
}

}  // namespace

PairRow narrow_capsule_capsule() { return {"capsule", "capsule", capsule_capsule}; }

}  // namespace feder
