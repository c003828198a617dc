#include "state/colliders.h"

#include "base/hash.h"
#include "feder/error.h"
#include "feder/snapshot.h"

namespace feder {
namespace {

// Every plain array of the block, in one place, for add, save and load.
template <class C, class F>
void each_array(C& c, F&& f) {
  f(c.motion), f(c.awake), f(c.sensor), f(c.bullet), f(c.owner), f(c.owner_index), f(c.solver_slot), f(c.object),
      f(c.sub);
  f(c.next_of_body), f(c.local), f(c.pose), f(c.box), f(c.center), f(c.velocity), f(c.angular_velocity);
  f(c.friction_static), f(c.friction_dynamic), f(c.restitution), f(c.rolling_friction), f(c.surface_velocity);
  f(c.material), f(c.group), f(c.mask);
}

}  // namespace

std::uint32_t Colliders::add() {
  std::uint32_t i;
  if (!free_list.empty()) {
    i = free_list.back();
    free_list.pop_back();
    FEDER_ASSERT(i < size() && motion[i] == ColliderMotion::none);
  } else {
    i = size();
    each_array(*this, [](auto& array) { array.emplace_back(); });
    shape.push_back(nullptr);
    shapes.emplace_back();
  }
  motion[i] = ColliderMotion::fixed;
  awake[i] = sensor[i] = bullet[i] = 0;
  shape[i] = nullptr;
  owner[i] = ColliderOwner::body;
  owner_index[i] = solver_slot[i] = next_of_body[i] = kNone;
  object[i] = {};
  sub[i] = 0;
  local[i] = pose[i] = Pose{};
  box[i] = Aabb{};
  center[i] = velocity[i] = angular_velocity[i] = surface_velocity[i] = Vec3::Zero();
  friction_static[i] = friction_dynamic[i] = Real(0.5);
  restitution[i] = rolling_friction[i] = 0;
  material[i] = 0;
  group[i] = 1;
  mask[i] = 0xffffffffu;
  changed.push_back(i);
  return i;
}

void Colliders::remove(std::uint32_t i) {
  FEDER_ASSERT(i < size() && motion[i] != ColliderMotion::none);
  motion[i] = ColliderMotion::none;
  awake[i] = 0;
  shape[i] = nullptr;
  shapes[i].reset();
  box[i] = Aabb{};
  free_list.push_back(i);
}

void Colliders::validate() const {
  each_array(*this, [&](const auto& array) { FEDER_ASSERT(array.size() == size()); });
  FEDER_ASSERT(shape.size() == size() && shapes.size() == size());
  MultisetHash free, listed;
  for (std::uint32_t i = 0; i < size(); ++i) {
    const bool used = motion[i] != ColliderMotion::none;
    if (!used) free.add(i);
    FEDER_ASSERT(shape[i] == shapes[i].get() && used == (shape[i] != nullptr));
  }
  for (const std::uint32_t i : free_list) listed.add(i);
  FEDER_ASSERT(free == listed);
}

void Colliders::save(Writer& w) const {
  each_array(*this, [&](const auto& array) { w.list(array); });
  w.list(free_list);
  w.list(changed);
  // shapes come in the same order each time: the next one is mostly the next pin
  std::uint32_t guess = 0;
  for (const ShapePtr& s : shapes) {
    std::uint32_t pin = kNone;
    if (s && guess < pinned.size() && pinned[guess] == s) {
      pin = guess++;
    } else if (s) {
      for (pin = 0; pin < pinned.size() && pinned[pin] != s; ++pin) {
      }
      if (pin == pinned.size()) pinned.push_back(s);
      guess = pin + 1;
    }
    w.add(pin);
  }
}

void Colliders::load(Reader& r) {
  each_array(*this, [&](auto& array) { r.list(array); });
  r.list(free_list);
  r.list(changed);
  shapes.assign(motion.size(), nullptr);
  shape.assign(motion.size(), nullptr);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    std::uint32_t pin = kNone;
    r.get(pin);
    if (pin == kNone) continue;
    if (pin >= pinned.size()) throw SceneError("snapshot: made by another world (unknown shape)");
    shapes[i] = pinned[pin];
    shape[i] = shapes[i].get();
  }
}

}  // namespace feder
