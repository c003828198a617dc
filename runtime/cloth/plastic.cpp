// Plastic flow of rest lengths and rest angles, once per step: strain e beyond the yield Y relaxes at the rate `flow`,
//   d rest/dt = flow sign(e) (|e| - Y) rest,
// by implicit Euler (viscoplasticity of Bingham's kind; Perzyna 1966). The rest goes towards what is now and never past
// it, and stiffness stays, so stored energy only falls. Strain of bending is that at the faces of the cloth,
// thickness/2 times the curvature, the angle over the mean height of both triangles. Rest lengths stay between
// kShortest and kLongest times those of the mesh, angles within a turn. Kept between steps: rest lengths and angles, in
// the mesh. Weak spot: masses and areas stay those of the first shape; ties to pins count from it too.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "cloth/impl.h"

namespace feder {
namespace {
constexpr Real kShortest = Real(0.05), kLongest = 20;
constexpr Real kMostFold = Real(3.0);  // rad, of a rest angle

// Part of `strain` beyond the yield that goes over in the step.
Real flowing(Real strain, Real yield, Real share) {
  if (strain > yield) return share * (strain - yield);
  return strain < -yield ? share * (strain + yield) : Real(0);
}
}  // namespace

void Cloth::Impl::flow(StepContext& c) {
  for (auto& p : sheets) {
    Sheet& s = *p;
    if (!s.active() || !s.settings.flows() || s.bad_vertex != kNone) continue;
    const Vec3* x = vertices.position.data() + s.first;
    const Vec3* rest = vertices.rest.data() + s.first;
    const Real yield = s.settings.yield, rate = s.settings.flow * c.dt, share = rate / (1 + rate);
    bool changed = false;
    for (ClothLink& l : s.mesh.links) {
      const Real change = flowing(length(x[l.b] - x[l.a]) / l.rest - 1, yield, share);
      if (change == 0) continue;
      const Real first = length(rest[l.b] - rest[l.a]);
      const Real next = clamp(l.rest * (1 + change), kShortest * first, kLongest * first);
      changed = changed || next != l.rest;
      l.rest = next;
    }
    for (ClothHinge& k : s.mesh.hinges) {
      const Vec3 e = rest[k.v[1]] - rest[k.v[0]];
      const Real height =
          (length(cross(e, rest[k.v[2]] - rest[k.v[0]])) + length(cross(e, rest[k.v[3]] - rest[k.v[0]]))) /
          (2 * length(e));
      const Real face = s.settings.thickness / (2 * height);  // strain per angle
      const double angle = double(hinge_angle(x[k.v[0]], x[k.v[1]], x[k.v[2]], x[k.v[3]]));
      const Real bent = static_cast<Real>(std::remainder(angle - double(k.angle), 6.283185307179586));
      const Real change = flowing(face * bent, yield, share);
      if (change == 0) continue;
      const Real next = clamp(k.angle + change / face, -kMostFold, kMostFold);
      changed = changed || next != k.angle;
      k.angle = next;
    }
    if (changed) ++s.rests;
  }
}

// After `split` was divided into itself and the vertices from old_points on, and elements were made anew from the rest
// shape: what had flowed of those that were there before.
void Cloth::Impl::keep_flow(Sheet& s, const FlowBefore& old, std::uint32_t old_points, std::uint32_t split) {
  const std::uint32_t added = s.points - old_points;
  const auto was = [&](std::uint32_t i) { return i < old_points ? i : i < s.points ? split : i - added; };
  const auto ends = [](std::uint32_t a, std::uint32_t b) { return std::pair(std::min(a, b), std::max(a, b)); };
  const auto key = [&](const auto& h, auto&& f) { return std::tuple(f(h.v[0]), f(h.v[1]), f(h.v[2]), f(h.v[3])); };
  const auto same = [](std::uint32_t i) { return i; };
  std::vector<ClothLink> links = old.links;
  std::vector<ClothHinge> hinges = old.hinges;
  std::sort(links.begin(), links.end(),
            [&](const ClothLink& a, const ClothLink& b) { return ends(a.a, a.b) < ends(b.a, b.b); });
  std::sort(hinges.begin(), hinges.end(),
            [&](const ClothHinge& a, const ClothHinge& b) { return key(a, same) < key(b, same); });
  for (ClothLink& l : s.mesh.links) {
    const auto wanted = ends(was(l.a), was(l.b));
    const auto at = std::lower_bound(links.begin(), links.end(), wanted,
                                     [&](const ClothLink& k, const auto& w) { return ends(k.a, k.b) < w; });
    if (at != links.end() && ends(at->a, at->b) == wanted) l.rest = at->rest;
  }
  for (ClothHinge& h : s.mesh.hinges) {
    const auto wanted = key(h, was);
    const auto at = std::lower_bound(hinges.begin(), hinges.end(), wanted,
                                     [&](const ClothHinge& k, const auto& w) { return key(k, same) < w; });
    if (at != hinges.end() && key(*at, same) == wanted) h.angle = at->angle;
  }
}

}  // namespace feder
