// Completion of a line that somebody types: in `feder repl` and in the viewer's console.
#pragma once
#include "lua/reference.h"

namespace feder::lua {

struct Completion {
  std::size_t from = 0;            // where in the line the word begins that the candidates replace
  std::vector<std::string> words;  // in order, each once
};

// Of the word that ends at the end of `line`: methods behind a colon, functions of feder behind its dot, options in the
// table of a function, kinds of events in the text of `on`, else names that the console knows.
Completion complete(const std::vector<ReferencePage>& pages, std::string_view line);

}  // namespace feder::lua
