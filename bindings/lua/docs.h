// Every function that a script sees, with signature and one line: what `feder doc` lists.
#pragma once
#include <string>
#include <vector>

namespace feder::lua {

struct DocRow {
  std::string owner;  // "feder", "world", "body" ...
  std::string name;
  std::string signature;
  std::string doc;
};

std::vector<DocRow> docs();

}  // namespace feder::lua
