// A distance field against a triangle mesh: samples of the field over each triangle, on the side of the ball inside the
// field that is nearest to it; and the least value of the field over the triangle (Macklin et al. 2020), for edges and
// corners of the mesh, whose push is kept within what the neighbours leave. Triangles come in ascending order.
// Keeps nothing between calls. Weak spot: what is deeper behind a triangle than four samples are apart is lost.
#include <algorithm>

#include "narrow/field_contact.h"
#include "narrow/narrow_phase.h"

namespace feder {
namespace {

constexpr Real kDeepest = 4;                 // sample spacings behind a triangle
constexpr Real kOverTriangle = Real(-1e-3);  // barycentric
constexpr Real kEdgeWeight = Real(1e-3);

struct MeshField {
  const Sdf& field;
  const Shape& mesh;
  Pose place;  // of the mesh in the frame of the field
  FieldContacts& contacts;
};

struct Weight {
  Real a, b, c;
};

Weight weights(const Vec3 (&t)[3], const Vec3& across, const Vec3& p) {
  const Real nn = dot(across, across);
  const Vec3 ap = p - t[0];
  const Real b = dot(across, cross(ap, t[2] - t[0])) / nn, c = dot(across, cross(t[1] - t[0], ap)) / nn;
  return {1 - b - c, b, c};
}

void meet_triangle(MeshField& m, std::uint32_t index) {
  const Triangle& triangle = m.mesh.triangle(index);
  const Vec3 t[3] = {to_world(m.place, triangle.a), to_world(m.place, triangle.b), to_world(m.place, triangle.c)};
  const Vec3 middle = (t[0] + t[1] + t[2]) / 3;
  const Real reach = std::max({length(t[0] - middle), length(t[1] - middle), length(t[2] - middle)});
  const Real margin = m.contacts.margin();
  if (m.field.field().at(middle) > reach + margin) return;
  const Vec3 across = cross(t[1] - t[0], t[2] - t[0]);
  Vec3 up = normalized_or(across, Vec3(0, 1, 0));
  Vec3 at, n;
  const Real least = least_over_convex(m.field.field(), Convex(t, 3), Pose{}, middle, at, n);
  // the side of the nearest ball
  Real nearest = kInfinity, height = 0;
  for (const Sdf::Ball& ball : m.field.balls()) {
    const Real d = length(ball.center - at) - ball.radius;
    if (d < nearest) nearest = d, height = dot(up, ball.center - t[0]);
  }
  const bool behind = height < 0;
  if (behind) up = -up;

  const Real deepest = std::min(kDeepest * m.field.sample_spacing(), reach + margin);
  Aabb box;
  for (const Vec3& corner : t) box.include(corner);
  box.grow(std::max(margin, deepest));
  const auto samples = m.field.samples();
  m.field.sample_tree().query(box, [&](std::uint32_t i) {
    const Sdf::Sample& s = samples[i];
    const Real d = dot(up, s.at - t[0]);
    if (!(d <= margin && d >= -deepest) || dot(up, s.normal) > kOpposed) return;
    const Weight w = weights(t, across, s.at);
    if (std::min({w.a, w.b, w.c}) < kOverTriangle) return;
    m.contacts.add({s.at - d / 2 * up, -up, d, (i + 1) * 2654435761u});
  });
  if (!(least <= margin)) return;
  // edges and corners may push as far round as the neighbour's normal
  const Weight w = weights(t, across, at);
  const Real opposite[3] = {w.c, w.a, w.b};
  const std::uint32_t flat = behind ? triangle.flat_edges >> 3 : triangle.flat_edges;
  Real cosine = 1;
  bool sharp = false;
  for (int k = 0; k < 3; ++k) {
    if (opposite[k] > kEdgeWeight || (flat >> k & 1u)) continue;
    sharp = true;
    cosine = std::min(cosine, triangle.edge_cosine[k]);
  }
  const bool face = dot(n, up) < Real(-0.95);
  if (!face && !(sharp && -dot(n, up) >= cosine - Real(0.01))) return;
  m.contacts.add({at - least / 2 * n, n, least, (index + 1) * 3266489917u});
}

int sdf_mesh(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
             Manifold* out) {
  const Sdf& field = static_cast<const Sdf&>(a);
  FieldContacts contacts(field, margin);
  MeshField m{field, b, {to_local(pose_a, pose_b.position), conjugate(pose_a.rotation) * pose_b.rotation}, contacts};
  Aabb box = a.bounds({to_local(pose_b, pose_a.position), conjugate(pose_b.rotation) * pose_a.rotation});
  box.grow(margin);
  b.triangles_in(
      box, [](void* to, std::uint32_t i) { meet_triangle(*static_cast<MeshField*>(to), i); }, &m);
  return contacts.finish(pose_a, 1, out);
}

}  // namespace

PairRow narrow_sdf_mesh() { return {"sdf", "mesh", sdf_mesh}; }

}  // namespace feder
