// Which tables of a text are options, and by which rows they are read: those in the arguments of a function that has
// rows, and the tables within them.
#include <algorithm>

#include "cli/check_kinds.h"

namespace feder::cli {

// The last argument of the call is read by rows.
const Kinds::Rows* Kinds::options_of_argument(const LuaNode* call, const LuaNode* table, std::string* owner) {
  Kind receiver;
  const lua::DocRow* const row = row_of(call, &receiver);
  if (!row || table == call->parts[0]) return nullptr;
  if (owner) *owner = row->owner == "feder" ? "feder." + row->name : receiver.name + ":" + row->name;
  if (takes_event(*row)) {
    const Kind event = event_of(call, *row, receiver);
    if (!event.known() || call->parts.size() < 3 || call->parts[2] != table) return nullptr;
    if (owner) *owner += "(\"" + event.events[0] + "\")";
    return &names_.event_filters(event.events[0]);
  }
  if (row->options.empty() || call->parts.back() != table) return nullptr;
  return row->owner == "feder" && row->name == "world" ? &names_.world_options() : &row->options;
}

// A table as the value of an option; or in a list of tables, or in one by names that the script makes up.
const Kinds::Rows* Kinds::options_of_entry(const LuaNode* entry, std::string* owner) {
  const OptionInfo* row = option_row(entry, owner);
  const bool direct = row != nullptr;
  if (!row) {
    const LuaNode* const outer = entry->parent->parent;
    row = outer && outer->syntax == Syntax::entry ? option_row(outer, owner) : nullptr;
  }
  if (!row || row->inner.empty()) return nullptr;
  if (owner) *owner += std::string(".") + row->row.name;
  const std::string_view type = row->type;
  const bool list = type == "list" || type.starts_with("list of {"), named = type.ends_with(" by name");
  if (direct ? named || type.starts_with("list") : entry->text.empty() ? !list : !named) return nullptr;
  return std::string_view(row->row.name) == "world" ? &names_.world_options() : &row->inner;
}

const Kinds::Rows* Kinds::options_of(const LuaNode* table, std::string* owner) {
  if (const LuaNode* const parent = table->parent) {
    if (parent->syntax == Syntax::call || parent->syntax == Syntax::method)
      return options_of_argument(parent, table, owner);
    return parent->syntax == Syntax::entry ? options_of_entry(parent, owner) : nullptr;
  }
  // of a variable that has this value alone and is passed on
  const auto held = holder_.find(table);
  if (held == holder_.end() || held->second->sources.size() != 1) return nullptr;
  for (const LuaNode* use : held->second->uses) {
    const LuaNode* const call = use->parent;
    if (!call || (call->syntax != Syntax::call && call->syntax != Syntax::method)) continue;
    if (const Rows* rows = options_of_argument(call, use, owner)) return rows;
  }
  return nullptr;
}

const OptionInfo* Kinds::option_row(const LuaNode* entry, std::string* owner) {
  const Rows* const rows = entry->text.empty() ? nullptr : options_of(entry->parent, owner);
  if (!rows) return nullptr;
  const auto found = std::ranges::find_if(*rows, [&](const OptionInfo& o) { return entry->text == o.row.name; });
  return found == rows->end() ? nullptr : &*found;
}

}  // namespace feder::cli
