// Every function that a script sees, with signature and one line: what `feder doc` lists.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "feder/events.h"
#include "feder/params.h"
#include "feder/system.h"

namespace feder::lua {

struct DocRow {
  std::string owner;  // "feder", "world", "body" ...
  std::string name;
  std::string signature;
  std::string doc;
  std::vector<OptionInfo> options;  // of its options table
};

struct Part;
std::vector<DocRow> docs(std::span<const Part* const> parts);
// The options of a system: world = { <system> = { ... } }. Rows that one variant alone reads name it.
std::vector<OptionInfo> system_options(Catalog systems, std::string_view system);
// The fields of such events in a handler (`own`: one of an object, object:on), and what subscriptions to them may
// filter by.
std::vector<OptionInfo> event_fields(EventKind kind, bool own = false);
std::vector<OptionInfo> event_filters(EventKind kind);
// What an option means, of a method (`world:body`), table or variant: in one sentence, "" where nobody wrote one. In a
// library of its own (feder_reference): a host without a reference does not link the sentences.
std::string_view option_sentence(std::string_view owner, std::string_view option);
std::string_view option_texts();  // all lines "owner.option  sentence"

}  // namespace feder::lua
