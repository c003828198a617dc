// Scripts against stubs: what an editor with these stubs would say. Types flow from calls, from the functions that are
// passed on and from literals; what has no type is checked as far as any class has it.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "cli/lua_stubs.h"

namespace feder::test {

struct StubFindings {
  std::vector<std::string> errors;  // "line: what is wrong"
  int calls = 0;                    // of functions and methods that stubs have
  int typed = 0;                    // of those where it is known what the method belongs to
  int arguments = 0, keys = 0;      // that were compared with a type
};

StubFindings check_with_stubs(const std::string& lua, const LuaStubs& stubs, const std::filesystem::path& libraries);

}  // namespace feder::test
