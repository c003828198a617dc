// feder's parts and the toy's: what a program with a system of its own lists.
#pragma once
#include <algorithm>

#include "cli/app.h"
#include "toy/wind_sock.h"
#include "view/collector.h"

namespace feder {

namespace lua {
const Part& wind_sock_part();
}
namespace view {
Row view_wind_socks();
}

template <class T>
std::vector<T> with(std::span<const T> all, T one) {
  std::vector<T> more(all.begin(), all.end());
  more.push_back(one);
  return more;
}

struct ToyBuild {
  std::vector<const lua::Part*> parts = with(lua::parts(), &lua::wind_sock_part());
  std::vector<const SystemDescriptor*> systems = with(catalog(), &WindSocks::descriptor());
  std::vector<view::Row> frames = with(view::frame_sources(), view::view_wind_socks());
  cli::Build build() const { return {parts, systems}; }
};

}  // namespace feder
