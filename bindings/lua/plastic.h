// The option `plastic` of what flows.
#pragma once
#include "lua/method.h"

namespace feder::lua {

template <class Reading>
inline constexpr Option<Reading> kPlastic[] = {
    field<&Reading::yield>("yield", "", kNotNegative),
    field<&Reading::flow>("flow", "1/s", kNotNegative),
};

// plastic = { yield =, flow = }
template <class Reading>
void read_plastic(Options& o, const OptionRow&, Reading& desc) {
  if (!o.push_any("plastic")) return;
  if (lua_type(o.L(), -1) != LUA_TTABLE) o.wrong("plastic", "{ yield =, flow = }");
  Options inner(o.L(), -1, o.path("plastic"));
  for (const char* key : {"yield", "flow"})
    if (!inner.given(key)) o.raise("plastic", std::string("expected { yield =, flow = }, got no ") + key);
  inner.read(kPlastic<Reading>, desc);
  lua_pop(o.L(), 1);
}

}  // namespace feder::lua
