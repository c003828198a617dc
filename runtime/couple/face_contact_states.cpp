// What couplings of fluids with faces report: the sums of a step. Kept between calls: the states of the running step.
// Weak spot: a particle that is solved and then projected in a substep may count twice.
#include "couple/face_contact_states.h"

#include <algorithm>

namespace feder {

void FaceContactStates::record(ObjectId object, ObjectId fluid, std::uint32_t particle, const Vec3& at, Real impulse,
                               Real speed, const Vec3& normal) {
  FEDER_ASSERT(!(impulse < 0 || speed < 0));
  std::size_t k = 0;
  while (k < list_.size() && (list_[k].object != object || list_[k].fluid != fluid)) ++k;
  if (k == list_.size()) {
    State fresh;
    fresh.object = object, fresh.fluid = fluid;
    k = 0;
    while (k < list_.size() && (list_[k].object != object ? list_[k].object < object : list_[k].fluid < fluid)) ++k;
    list_.insert(list_.begin() + static_cast<std::ptrdiff_t>(k), fresh);
  }
  State& t = list_[k];
  if (t.last != particle) t.last = particle, ++t.now;
  t.impulse += impulse;
  t.speed = std::max(t.speed, speed);
  if (!(impulse > t.strongest)) return;
  t.strongest = impulse, t.normal = normal;
  t.point = at;
}

void FaceContactStates::end_substep() {
  for (State& t : list_) t.count = std::max(t.count, t.now), t.now = 0, t.last = kNone;
}

void FaceContactStates::report(ContactBook& contacts, std::uint32_t finder, const Objects& objects) {
  for (const State& t : list_) {
    FEDER_ASSERT(objects.alive(t.object) && objects.alive(t.fluid) && t.now == 0 && t.count > 0);
    ContactFinding n;
    n.key = {t.object, t.fluid};
    n.index = t.count, n.number = 1;
    n.point = t.point, n.normal = t.normal;
    n.speed = t.speed, n.impulse = t.impulse;
    contacts.see(finder, n);
  }
  list_.clear();
}

}  // namespace feder
