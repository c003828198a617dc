// What expectations of objects share: the objects, and which of them does not do what is expected. Objects are asked by
// their Lua methods, so that every kind that has them can be tested.
#pragma once
#include "lua/expect.h"
#include "lua/object_points.h"

namespace feder::lua {

// Argument 1, an object or a list of objects, as a list there; their world.
WorldRecord& tested_objects(lua_State* L);

// An object that does not do what is expected of it, and what it does.
struct Offender {
  std::string object, actual, delta = {};
};
using ObjectTest = std::function<bool(std::size_t number, Offender& offender)>;  // of the object on top of the stack

// Waits until every object of argument 1 passes, or sees that all do for so long; the first that does not is reported.
enum class Wait { within, during };
int expect_of_objects(lua_State* L, Wait wait, double seconds, const std::string& wanted, const std::string& tolerance,
                      const ObjectTest& passes);

}  // namespace feder::lua
