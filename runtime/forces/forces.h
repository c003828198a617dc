// The forces of a world, and whom they act on.
#pragma once
#include "feder/force.h"
#include "feder/memory.h"

namespace feder {

class Writer;
class Reader;

// The block: a world's forces in the order they were made.
struct Forces {
  explicit Forces(Arena&) {}
  // What each force may stop of a mass (or of a rate) if all that act against velocities share it.
  Real drag_share() const {
    int count = 0;
    for (const ForceEntry& f : list) count += f.enabled && f.force && f.force->depends_on_velocity();
    return count > 1 ? 1 / static_cast<Real>(count) : Real(1);
  }
  void save(Writer& w) const;
  void load(Reader& r);

  std::vector<ForceEntry> list;

 private:
  // Generators stay in memory while a snapshot may need them: images hold their indices.
  mutable std::vector<std::shared_ptr<const Force>> pinned_;
};

// Is the force meant for that object, whoever evaluates it?
inline bool aims_at(const ForceEntry& f, ObjectId object, TagMask tags) {
  return f.enabled && (f.all || (f.tags & tags) != 0 || f.target == object);
}

// Does the force act on that object when its owner asks?
inline bool acts_on(const ForceEntry& f, ObjectId object, TagMask tags) { return f.force && aims_at(f, object, tags); }

}  // namespace feder
