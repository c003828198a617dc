// Completion of a line that somebody types: in `feder repl` and in the viewer's console.
#pragma once
#include <algorithm>

#include "lua/reference.h"

namespace feder::lua {

struct Completion {
  std::size_t from = 0;            // where in the line the word begins that the candidates replace
  std::vector<std::string> words;  // in order, each once

  // What they all begin with.
  std::string common() const {
    std::string start = words.empty() ? "" : words[0];
    for (const std::string& w : words) {
      std::size_t same = 0;
      while (same < std::min(start.size(), w.size()) && start[same] == w[same]) ++same;
      start.resize(same);
    }
    return start;
  }
};

// Of the word that ends at the end of `line`: methods behind a colon, functions of feder behind its dot, options in the
// table of a function, kinds of events in the text of `on`, else names that the console knows.
Completion complete(const std::vector<ReferencePage>& pages, std::string_view line);

}  // namespace feder::lua
