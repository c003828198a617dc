// The reference: a page for every function, event and table of options that a script may use, made from the rows that
// the binding itself reads by. In feder_reference, which a host without a reference does not link.
#pragma once
#include <string>
#include <vector>

#include "feder/events.h"
#include "lua/docs.h"

namespace feder::lua {

enum class PageKind { function, method, event, options, yaml, command };

// An option, an event's field, or one of a table within (friction.static).
struct ReferenceRow {
  std::string name;
  std::string type;      // in Lua's words: "number", "vector", "string"
  std::string unit;      // SI; "" where it has none
  std::string fallback;  // as a script would write it; "" where it is absent then
  std::string allowed;   // names, or the range of a number; "" for any
  std::string of;        // the variant that alone reads it
  std::string text;      // what it means, one sentence
  Range range = kAny;    // of numbers
};

struct ReferencePage {
  PageKind kind = PageKind::function;
  std::string title;      // "world:joint", "feder.box", "hit", "world.rigid", "yaml.bodies"
  std::string owner;      // "world", "feder", "body"; "event"; "options"; "yaml"
  std::string name;       // "joint"
  std::string signature;  // "world:joint{ type =, a =, ... } -> joint"; of events "world:on("hit", fn(e))"
  std::string text;       // what it does
  std::string example;    // Lua; "" for none
  std::vector<ReferenceRow> rows;
  std::string maker = {};  // of a list in YAML: title of the method whose rows its entries have too
};

// In the order of owners as docs() has them, then events, then the options of systems.
std::vector<ReferencePage> reference(std::span<const Part* const> parts, Catalog systems);

// Of every world, then of its systems.
std::vector<EventKind> event_kinds(Catalog systems);

// Every example with the title that it belongs to.
struct Example {
  std::string title, code;
};
std::vector<Example> examples();

}  // namespace feder::lua
