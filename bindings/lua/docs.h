// Every function that a script sees, with signature and one line: what `feder doc` lists.
#pragma once
#include <span>
#include <string>
#include <vector>

namespace feder::lua {

struct DocRow {
  std::string owner;  // "feder", "world", "body" ...
  std::string name;
  std::string signature;
  std::string doc;
};

struct Part;
std::vector<DocRow> docs(std::span<const Part* const> parts);

}  // namespace feder::lua
