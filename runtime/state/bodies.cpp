// Adding and removing bodies, world inertia with locks, and the invariants of the arrays.
#include "state/bodies.h"

#include "feder/error.h"

namespace feder {

std::uint32_t Bodies::add() {
  FEDER_ASSERT(free_list.empty() || (free_list.back() < size() && type[free_list.back()] == BodyType::free));
  const std::uint32_t i = add_blank(*this);
  type[i] = BodyType::fixed;
  can_sleep[i] = 1;
  gravity_scale[i] = 1;
  island[i] = first_collider[i] = solver_slot[i] = kNone;
  return i;
}

void Bodies::remove(std::uint32_t i) {
  FEDER_ASSERT(i < size() && type[i] != BodyType::free);
  type[i] = BodyType::free;
  awake[i] = 0;
  free_list.push_back(i);
}

Mat3 Bodies::world_inv_inertia(std::uint32_t i) const {
  FEDER_ASSERT(is_unit(rotation[i]));
  const Mat3 r = to_matrix(rotation[i]);
  Mat3 m = r * inv_inertia[i] * r.transpose();
  for (int k = 0; k < 3; ++k) {
    if (!(lock[i] & (kLockRx << k))) continue;
    m.row(k).setZero();
    m.col(k).setZero();
  }
  return m;
}

void Bodies::validate() const {
  each_array(*this, [&](const auto& array) { FEDER_ASSERT(array.size() == size()); });
  for (std::uint32_t i = 0; i < size(); ++i)
    FEDER_ASSERT(awake[i] <= (type[i] == BodyType::dynamic || type[i] == BodyType::kinematic));
  const bool listed = lists_free(free_list, size(), [&](std::uint32_t i) { return type[i] == BodyType::free; });
  FEDER_ASSERT(listed);
}

}  // namespace feder
