// What feder check says about a Lua text: names that nothing has.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "cli/check_names.h"

namespace feder::cli {

struct Finding {
  int line;
  std::string message;
};

// Of a text that Lua compiles, in the order of the lines. `folder`: of the file, for `require`.
std::vector<Finding> check_names(std::string_view text, const std::filesystem::path& folder, const ScriptNames& names);

}  // namespace feder::cli
