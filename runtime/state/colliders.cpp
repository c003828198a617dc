// Adding and removing colliders, their invariants and snapshots. Shapes are saved as indices into the world's list of
// pinned shapes, which keeps them in memory.
#include "state/colliders.h"

#include "feder/error.h"
#include "feder/snapshot.h"

namespace feder {

std::uint32_t Colliders::add() {
  FEDER_ASSERT(free_list.empty() || (free_list.back() < size() && motion[free_list.back()] == ColliderMotion::none));
  const std::uint32_t i = add_blank(*this);
  shape.resize(size(), nullptr);
  shapes.resize(size());
  motion[i] = ColliderMotion::fixed;
  owner_index[i] = solver_slot[i] = next_of_body[i] = kNone;
  friction_static[i] = friction_dynamic[i] = Real(0.5);
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
  touched.push_back(i);
  free_list.push_back(i);
}

void Colliders::validate() const {
  each_array(*this, [&](const auto& array) { FEDER_ASSERT(array.size() == size()); });
  FEDER_ASSERT(shape.size() == size() && shapes.size() == size());
  const auto is_free = [&](std::uint32_t i) { return motion[i] == ColliderMotion::none; };
  for (std::uint32_t i = 0; i < size(); ++i)
    FEDER_ASSERT(shape[i] == shapes[i].get() && is_free(i) == (shape[i] == nullptr));
  FEDER_ASSERT(lists_free(free_list, size(), is_free));
}

void Colliders::save(Writer& w) const {
  each_saved(*this, saved_to(w));
  // shapes come in the same order each time: mostly the next one is the next pin
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
  each_saved(*this, loaded_from(r));
  touched.clear();
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
