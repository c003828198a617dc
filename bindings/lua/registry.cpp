// The parts of this build. In a library of its own, because it links them all.
#include "lua/part.h"

namespace feder::lua {

#include "lua_declare.inc"

std::span<const Part* const> parts() {
  static const std::vector<const Part*> all = {
#include "lua_rows.inc"
  };
  return all;
}

}  // namespace feder::lua
