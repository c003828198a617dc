// Contacts of fluids and objects with faces in a step, one per pair, for events: a fluid is in contact with such an
// object from its first particle that pushes to its last; the event has their number.
#pragma once
#include "feder/object.h"
#include "state/contact_book.h"

namespace feder {

class FaceContactStates {
 public:
  explicit FaceContactStates(Arena& a) : list_(&a) {}

  // An impulse, N s, of a particle at `at`; `speed`: closing, m/s; `normal`: from the face to the particle. Particles
  // of a fluid come in their order.
  void record(ObjectId object, ObjectId fluid, std::uint32_t particle, const Vec3& at, Real impulse, Real speed,
              const Vec3& normal);
  void end_substep();
  void report(ContactBook& contacts, std::uint32_t finder, const Objects& objects);  // and forgets them
  void clear() { list_.clear(); }
  bool empty() const { return list_.empty(); }

 private:
  struct State {
    ObjectId object, fluid;
    std::uint32_t count = 0;                           // largest number of particles in contact in a substep
    std::uint32_t now = 0, last = kNone;               // the same in this substep; the particle counted last
    Real impulse = 0;                                  // N s
    Real speed = 0;                                    // closing, the largest, m/s
    Real strongest = 0;                                // N s
    Vec3 point = Vec3::Zero(), normal = Vec3::Zero();  // of the strongest push
  };
  Array<State> list_;  // in the order of the objects
};

}  // namespace feder
