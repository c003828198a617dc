#include "state/bodies.h"

#include "base/hash.h"
#include "feder/error.h"
#include "feder/snapshot.h"

namespace feder {
namespace {

// Every array of the block, in one place, for add, save and load.
template <class B, class F>
void each_array(B& b, F&& f) {
  f(b.type), f(b.awake), f(b.can_sleep), f(b.bullet), f(b.lock), f(b.object), f(b.position), f(b.rotation);
  f(b.velocity), f(b.angular_velocity), f(b.local_com), f(b.mass), f(b.inv_mass), f(b.inertia), f(b.inv_inertia);
  f(b.force), f(b.torque), f(b.gravity_scale), f(b.linear_damping), f(b.angular_damping), f(b.extent), f(b.target);
  f(b.has_target), f(b.sleep_energy), f(b.island), f(b.first_collider), f(b.solver_slot);
}

}  // namespace

Bodies::Bodies(Arena& a)
    : type(&a), awake(&a), can_sleep(&a), bullet(&a), lock(&a), object(&a), position(&a), rotation(&a), velocity(&a),
      angular_velocity(&a), local_com(&a), mass(&a), inv_mass(&a), inertia(&a), inv_inertia(&a), force(&a), torque(&a),
      gravity_scale(&a), linear_damping(&a), angular_damping(&a), extent(&a), target(&a), has_target(&a),
      sleep_energy(&a), island(&a), first_collider(&a), solver_slot(&a), free_list(&a) {}

std::uint32_t Bodies::add() {
  std::uint32_t i;
  if (!free_list.empty()) {
    i = free_list.back();
    free_list.pop_back();
    FEDER_ASSERT(i < size() && type[i] == BodyType::free);
  } else {
    i = size();
    each_array(*this, [](auto& array) { array.emplace_back(); });
  }
  type[i] = BodyType::fixed;
  awake[i] = bullet[i] = lock[i] = has_target[i] = 0;
  can_sleep[i] = 1;
  object[i] = {};
  position[i] = velocity[i] = angular_velocity[i] = local_com[i] = force[i] = torque[i] = Vec3::Zero();
  rotation[i] = Quat::identity();
  mass[i] = inv_mass[i] = linear_damping[i] = angular_damping[i] = extent[i] = sleep_energy[i] = 0;
  inertia[i] = inv_inertia[i] = Mat3::Zero();
  gravity_scale[i] = 1;
  target[i] = Pose{};
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
  MultisetHash free, listed;
  for (std::uint32_t i = 0; i < size(); ++i) {
    if (type[i] == BodyType::free) free.add(i);
    FEDER_ASSERT(awake[i] <= (type[i] == BodyType::dynamic || type[i] == BodyType::kinematic));
  }
  for (const std::uint32_t i : free_list) listed.add(i);
  FEDER_ASSERT(free == listed);
}

void Bodies::save(Writer& w) const {
  each_array(*this, [&](const auto& array) { w.list(array); });
  w.list(free_list);
}

void Bodies::load(Reader& r) {
  each_array(*this, [&](auto& array) { r.list(array); });
  r.list(free_list);
}

}  // namespace feder
