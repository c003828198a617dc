// Runs script texts for tests. Line 1 of a text is line 1 in messages; the chunk is called test.lua.
#pragma once
#include <string>

#include "feder/lua.h"
#include "support/catch.h"

namespace feder::test {

struct Ran {
  std::string output;                     // of print()
  std::string error;                      // what() of the ScriptError, "" when none
  std::vector<lua::HandlerError> errors;  // of handlers
};

inline const char* const kPrelude = "local feder = require 'feder'; local world = feder.world{}; ";

inline Ran run(const std::string& text, lua::HostOptions options = {}, const char* prelude = kPrelude) {
  Ran ran;
  options.print = [&ran](std::string_view more) { ran.output += more; };
  lua::Script script(std::move(options));
  try {
    script.load_string(prelude + text, "test.lua");
  } catch (const lua::ScriptError& e) {
    ran.error = e.what();
  }
  ran.errors = script.handler_errors();
  return ran;
}

// The error that the text must end in.
inline std::string error_of(const std::string& text) {
  const Ran ran = run(text);
  CAPTURE(text, ran.output);
  CHECK(!ran.error.empty());
  return ran.error;
}

// What the text prints; no error of any kind may happen.
inline std::string output_of(const std::string& text, lua::HostOptions options = {}) {
  const Ran ran = run(text, std::move(options));
  CHECK(ran.error == "");
  for (const auto& e : ran.errors) {
    CAPTURE(e.where, e.message);
    CHECK(ran.errors.empty());
  }
  return ran.output;
}

}  // namespace feder::test
