// A convex shape against a distance field: surface samples of the field in the convex shape's distance; the least value
// of the field over the convex core, sought from its middle and from the deepest samples (Frank and Wolfe), which finds
// corners and edges; and the corners of the face that looks that way, so that boxes rest on four points.
// Keeps nothing between calls. Weak spot: of a shape much larger than the field's details, the eight normals that
// differ most are kept.
#include "geom/width.h"
#include "narrow/field_contact.h"
#include "narrow/narrow_phase.h"
#include "narrow/reduce.h"

namespace feder {
namespace {

constexpr int kStarts = 4;

// The candidate where a point of the core is, at the field's distance d along n.
FieldCandidate of_core(const Vec3& at, Real d, Real radius, const Vec3& n, std::uint32_t feature) {
  const Real separation = d - radius;
  return {at - n * (radius + separation / 2), n, separation, feature};
}

int convex_sdf(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
               Manifold* out) {
  const Sdf& field = static_cast<const Sdf&>(b);
  const Pose place{to_local(pose_b, pose_a.position), conjugate(pose_b.rotation) * pose_a.rotation};
  Aabb box = a.bounds(place);
  box.grow(margin);
  if (!overlaps(box, field.box())) return 0;
  FieldContacts contacts(field, margin);
  const PlacedShape other(a, place);
  contacts.add_samples(other);

  // the core's nearest points
  Vec3 start[kStarts + 1] = {to_world(place, inner_point(a))};
  int starts = 1;
  FieldCandidate deep[kStarts];
  const int deepest = contacts.deepest(deep, kStarts);
  for (int i = 0; i < deepest; ++i) {
    // from the surface towards the middle until in the core
    Vec3 x = deep[i].at, n;
    const Real d = other.distance(x, n) + a.radius();
    if (d > 0) x -= n * d;
    start[starts++] = x;
  }
  for (int i = 0; i < starts; ++i) {
    Vec3 at, n;
    const Real d = least_over_convex(field.field(), Convex(a), place, start[i], at, n);
    if (d - a.radius() > margin) continue;
    contacts.add(of_core(at, d, a.radius(), n, feature_of(to_local(place, at))));
    Vec3 corner[kMaxFacePoints];
    const int corners = a.face(rotate_inverse(place.rotation, -n), corner);
    for (int k = 0; k < corners; ++k) {
      const Vec3 p = to_world(place, corner[k]);
      Vec3 m;
      const Real e = field.field().smooth_at(p, m);
      if (e - a.radius() <= margin) contacts.add(of_core(p, e, a.radius(), normalized_or(m, n), feature_of(corner[k])));
    }
  }
  contacts.refine(other);
  return contacts.finish(pose_b, -1, out);
}

}  // namespace

PairRow narrow_convex_sdf() { return {"convex", "sdf", convex_sdf}; }

}  // namespace feder
