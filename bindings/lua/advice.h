// What systems say about their objects before a world runs: feder.advise, `feder explain`.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "state/objects.h"

struct lua_State;

namespace feder {
class World;
}
namespace feder::lua {

struct Part;

struct Advice {
  using Fact = std::variant<std::int64_t, double, std::string>;  // a number may be infinite
  ObjectId object;
  std::string text;  // a sentence that names it
  std::vector<std::pair<const char*, Fact>> facts;
};

std::vector<Advice> advise(std::span<const Part* const> parts, World& world);
int feder_advise(lua_State* L);

}  // namespace feder::lua
