// Arenas of a world, by name.
#include "feder/memory.h"

namespace feder {

Arena& Store::arena(const char* name) {
  FEDER_ASSERT(name && *name);
  for (const auto& a : arenas_)
    if (a->name() == name) return *a;
  arenas_.push_back(std::make_unique<Arena>(name));
  return *arenas_.back();
}

}  // namespace feder
