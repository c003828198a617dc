// The table of commands of this build, generated from the feder_variant(record ...) lines.
#include "record/commands.h"

namespace feder {

using Row = CommandRows;
#include "record_declare.inc"

static const std::map<std::string, CommandRow, std::less<>>& all_commands() {
  static const auto table = [] {
    std::map<std::string, CommandRow, std::less<>> rows;
    const std::initializer_list<CommandRows> lists = {
#include "record_rows.inc"
    };
    for (const CommandRows& list : lists)
      for (const CommandRow& row : list) rows.emplace(row.name, row);
    return rows;
  }();
  return table;
}

const CommandRow* find_command(std::string_view name) {
  const auto at = all_commands().find(name);
  return at == all_commands().end() ? nullptr : &at->second;
}

std::vector<std::string> command_names() {
  std::vector<std::string> names;
  for (const auto& [name, row] : all_commands()) names.push_back(name);
  return names;
}

}  // namespace feder
