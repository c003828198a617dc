// Two distance fields: the surface samples of each in the other, then led to where both are nearest (Macklin et al.
// 2020 seek the same place; here by descent on the sum of the distances from the samples). Both sides are walked, so a
// corner of either is found. Keeps nothing between calls.
#include "narrow/field_contact.h"
#include "narrow/narrow_phase.h"

namespace feder {
namespace {

// Fields by their samples, those of b in the frame of a.
int sdf_sdf(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache&,
            Manifold* out) {
  const Sdf &field = static_cast<const Sdf&>(a), &to = static_cast<const Sdf&>(b);
  const Pose place{to_local(pose_a, pose_b.position), conjugate(pose_a.rotation) * pose_b.rotation};
  Aabb box = b.bounds(place);
  box.grow(margin);
  if (!overlaps(box, field.box())) return 0;
  FieldContacts contacts(field, margin);
  const PlacedShape other(to, place);
  contacts.add_samples(other);
  // the other way round: points of b and slopes of a
  const auto at_least = [&](const Vec3& p) { return field.field().at_least(to_world(place, p)); };
  const auto distance = [&](const Vec3& p) { return field.field().within(to_world(place, p), margin); };
  each_sample_near(to, margin, at_least, distance, [&](std::uint32_t i, const Sdf::Sample& s) {
    const Vec3 p = to_world(place, s.at), own = rotate(place.rotation, s.normal);
    Vec3 n;
    const Real d = field.field().smooth_at(p, n);
    n = normalized_or(n, Vec3(-own));
    if (dot(n, own) <= kOpposed) contacts.add({p - d / 2 * n, n, d, (i + 1) * 2246822519u});
  });
  contacts.refine(other);
  return contacts.finish(pose_a, 1, out);
}

}  // namespace

PairRow narrow_sdf_sdf() { return {"sdf", "sdf", sdf_sdf}; }

}  // namespace feder
