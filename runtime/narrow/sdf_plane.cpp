// A distance field against a half-space: its surface samples. Keeps nothing between calls. Weak spot: samples lie up to
// their spacing apart, so a rounded field stands on points that are off its lowest by spacing^2/(8 radius).
#include "narrow/field_contact.h"
#include "narrow/narrow_phase.h"

namespace feder {
namespace {

int sdf_plane(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
              Manifold* out) {
  const Sdf& field = static_cast<const Sdf&>(a);
  const Pose place{to_local(pose_a, pose_b.position), conjugate(pose_a.rotation) * pose_b.rotation};
  FieldContacts contacts(field, margin);
  const PlacedShape other(b, place);
  contacts.add_samples(other);
  contacts.refine(other);
  return contacts.finish(pose_a, 1, out);
}

}  // namespace

PairRow narrow_sdf_plane() { return {"sdf", "plane", sdf_plane}; }

}  // namespace feder
