// Snapshots: time, objects and every system's state as one byte image.
#include "feder/world.h"
#include "forces/forces.h"
#include "state/command_log.h"
#include "state/contact_book.h"
#include "world/own.h"

namespace feder {
namespace {
constexpr std::uint64_t kMagic = 0x3130726564656600ull + sizeof(Real);  // "feder01", and the precision

// Owner key: tells worlds apart without writing an address into the image.
std::uint64_t owner_key(const World* world) {
  Hash h;
  h.add(reinterpret_cast<std::uintptr_t>(world));
  return h.value();
}
// Names an image in recordings.
std::uint64_t hash_of(std::string_view image) {
  Hash h;
  h.bytes(image.data(), image.size());
  return h.value();
}
}  // namespace

std::string World::save_image() const {
  std::string image;
  Writer w(image);
  w.add(kMagic);
  w.add(owner_key(this));
  w.add(time_);
  w.add(steps_);
  w.add(own_->rng);
  w.add(desc_.gravity[0]), w.add(desc_.gravity[1]), w.add(desc_.gravity[2]);
  objects_.save(w);
  w.add(static_cast<std::uint64_t>(systems_.size()));
  for (const Present& p : systems_) {
    w.text(p.descriptor->name);
    p.system->save(w);
  }
  if (const ContactBook* book = store_.find<ContactBook>()) book->save(w);
  if (const Forces* forces = store_.find<Forces>())
    forces->save(w);
  else
    w.add(std::uint64_t{0});
  return image;
}

std::string World::snapshot() const {
  std::string image = save_image();
  const Command command(*commands_, "world.snapshot", commands_->recording() ? hash_of(image) : 0);
  return image;
}

void World::load_image(std::string_view image) {
  Reader r(image);
  std::uint64_t magic = 0, maker = 0, count = 0;
  r.get(magic);
  if (magic != kMagic) throw SceneError("snapshot: not a snapshot of this build");
  r.get(maker);
  if (maker != owner_key(this)) throw SceneError("snapshot: made by another world");
  r.get(time_);
  r.get(steps_);
  r.get(own_->rng);
  r.get(desc_.gravity[0]), r.get(desc_.gravity[1]), r.get(desc_.gravity[2]);
  objects_.load(r);
  r.get(count);
  if (count != systems_.size()) throw SceneError("snapshot: the world has got other systems since it was taken");
  for (Present& p : systems_) {
    std::string name;
    r.text(name);
    if (name != p.descriptor->name) throw SceneError("snapshot: the world has got other systems since it was taken");
    p.system->load(r);
  }
  if (ContactBook* book = store_.find<ContactBook>()) book->load(r);
  if (Forces* forces = store_.find<Forces>())
    forces->load(r);
  else if (r.get<std::uint64_t>() != 0)
    throw SceneError("snapshot: made by another world (forces)");
  if (!r.at_end()) throw SceneError("snapshot: longer than expected");
  structure_changed_ = true;
}

void World::restore(std::string_view image) {
  if (stepping_) throw SceneError("world: restore() called inside a step");
  const Command command(*commands_, "world.restore", commands_->recording() ? hash_of(image) : 0);
  const std::string before = snapshot();
  try {
    load_image(image);
  } catch (const SceneError&) {
    load_image(before);
    throw;
  }
}

}  // namespace feder
