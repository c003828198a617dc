// Flow-insensitive inference: a variable has the kinds of all values that the text gives it, a parameter those of all
// calls and of every place where its function is passed on. All variables begin without a kind; rounds over the text
// join what their values have until nothing changes. A kind goes up only, from none to one to unknown, so a few rounds
// do; the work of a round is about that of reading the text.
#include "cli/check_kinds.h"

#include <algorithm>
#include <sstream>

namespace feder::cli {
namespace {

const Kind kNothingKnown{.name = Kind::kUnknown};

// "function(world, scene)" of an option's type: the names of its parameters.
Words parameters_in(std::string_view type) {
  Words words;
  const std::size_t at = type.find("function(");
  if (at == std::string_view::npos) return words;
  std::istringstream in(std::string(type.substr(at + 9, type.find(')', at) - at - 9)));
  for (std::string word; std::getline(in, word, ',');) words.push_back(word.substr(word.find_first_not_of(' ')));
  return words;
}

// The names that a table of a module has: null where they are not all written down.
bool collect_exports(const LuaNode* table, Words& names) {
  for (const LuaNode* entry : table->parts) {
    if (entry->text.empty()) return false;
    names.push_back(entry->text);
  }
  return true;
}

bool is_global(const LuaNode* node, std::string_view name) {
  return node->syntax == Syntax::name && node->variable->global && node->text == name;
}

bool is_call(const LuaNode* node) { return node->syntax == Syntax::call || node->syntax == Syntax::method; }

}  // namespace

Kind join(const Kind& a, const Kind& b) {
  if (a.name.empty() || a == b) return b;
  if (b.name.empty()) return a;
  if (a.name != b.name || a.list != b.list) return kNothingKnown;
  Kind both = a;
  both.guessed = a.guessed || b.guessed;
  both.own = a.own || b.own;
  for (const std::string& event : b.events)
    if (std::ranges::find(both.events, event) == both.events.end()) both.events.push_back(event);
  return both;
}

Kinds::Kinds(const ScriptNames& names, const LuaTree& tree, std::filesystem::path folder)
    : names_(names), tree_(tree), folder_(std::move(folder)) {
  for (const LuaVariable& v : tree.variables)
    for (const LuaSource& s : v.sources)
      if (s.value && s.result == 0) holder_[s.value] = &v;
  for (const LuaNode& node : tree.nodes) uses_feder_ = uses_feder_ || required(&node) == "feder";
  bool changed = true;
  for (int round = 0; round < kMaxRounds && changed; ++round) changed = find_all();
  gave_up_ = changed;
}

// One round; false when it has changed nothing.
bool Kinds::find_all() {
  known_.clear();
  for (const LuaNode& node : tree_.nodes) of(&node);  // parts come first: the depth stays small
  std::map<const LuaVariable*, Kind> variables;
  for (const LuaVariable& v : tree_.variables) variables[&v] = find_variable(&v);
  std::map<std::string, Kind> fields;
  for (const auto& [target, source] : tree_.writes)
    if (const Place place = place_of(target); !place.field.empty()) {
      Kind& kind = fields[place.field];
      kind = join(kind, of(source.value, source.result));
    }
  std::map<const LuaNode*, Kind> returned;
  for (const LuaNode& node : tree_.nodes) {
    if (node.syntax != Syntax::function) continue;
    Kind& kind = returned[&node] = node.returns.empty() ? kNothingKnown : Kind{};
    for (const LuaNode* value : node.returns) kind = join(kind, of(value));
  }
  std::map<Place, Kind> elements = find_elements();
  const bool same = variables == variables_ && fields == fields_ && elements == elements_ && returned == returned_;
  returned_ = std::move(returned);
  variables_ = std::move(variables), fields_ = std::move(fields), elements_ = std::move(elements);
  return !same;
}

Kind Kinds::of(const LuaNode* value, std::size_t result) {
  if (!value || gave_up_) return kNothingKnown;
  const std::pair key(value, result);
  if (const auto found = known_.find(key); found != known_.end()) return found->second;
  return known_[key] = find(value, result);
}

Kind Kinds::find(const LuaNode* value, std::size_t result) {
  switch (value->syntax) {
    case Syntax::nothing: return {};
    case Syntax::string: return {.name = "library string"};
    case Syntax::name: return of_variable(value->variable);
    case Syntax::index: return of_index(value);
    case Syntax::call:
    case Syntax::method: return of_call(value, result);
    case Syntax::loop: return of_loop(value, result);
    default: return kNothingKnown;
  }
}

Kind Kinds::of_variable(const LuaVariable* variable) const {
  if (variable->global && variable->sources.empty()) {
    const std::string library = "library " + variable->name;
    return names_.members(library) ? Kind{.name = library} : kNothingKnown;
  }
  const auto found = variables_.find(variable);
  return found == variables_.end() ? Kind{} : found->second;
}

Kind Kinds::find_variable(const LuaVariable* variable) {
  Kind kind = variable->function ? of_parameter(variable) : Kind{};
  for (const LuaSource& source : variable->sources) kind = join(kind, of(source.value, source.result));
  const bool alone = variable->function && variable->sources.empty();
  if (kind == kNothingKnown && alone && uses_feder_ && variable->name == "world")
    return {.name = "world", .guessed = true};
  return kind;
}

Kind Kinds::of_parameter(const LuaVariable* variable) {
  const LuaNode* const function = variable->function;
  const auto held = holder_.find(function);
  if (held == holder_.end()) return passed(function, function, variable->parameter);
  Kind kind;
  bool used = false;
  for (const LuaNode* use : held->second->uses) {
    if (use->assigned) continue;
    used = true;
    const bool called = use->parent && use->parent->syntax == Syntax::call && use->parent->parts[0] == use;
    if (!called)
      kind = join(kind, passed(function, use, variable->parameter));
    else if (const auto& parts = use->parent->parts; variable->parameter + 1 < parts.size())
      kind = join(kind, of(parts[variable->parameter + 1]));
    else
      kind = kNothingKnown;
  }
  return used ? kind : kNothingKnown;
}

Kind Kinds::passed(const LuaNode* function, const LuaNode* place, std::size_t k) {
  const LuaNode* const parent = place->parent;
  if (!parent) return kNothingKnown;
  waits_ = false;
  if (parent->syntax == Syntax::entry) {
    const OptionInfo* const row = option_row(parent);
    if (!row && waits_) return {};
    Words names = row ? parameters_in(row->type) : Words{};
    // functions of studies may be written like build
    if (!names.empty() && names.size() < 3 && function->parameters.size() > 1 &&
        function->parameters[1]->name == "scene")
      names = {"world", "scene"};
    const std::string name = k < names.size() ? names[k] : "";
    return name == "scene" || names_.is_class(name) ? Kind{.name = name} : kNothingKnown;
  }
  if (!is_call(parent) || parent->parts[0] == place || k > 0) return kNothingKnown;
  Kind receiver;
  const lua::DocRow* const row = row_of(parent, &receiver);
  if (!row && waits_) return {};
  return row && takes_event(*row) ? event_of(parent, *row, receiver) : kNothingKnown;
}

Kind Kinds::event_of(const LuaNode* call, const lua::DocRow& row, const Kind& receiver) const {
  if (call->parts.size() < 2 || call->parts[1]->syntax != Syntax::string || !names_.event(call->parts[1]->text))
    return kNothingKnown;
  return {.name = "event", .events = {call->parts[1]->text}, .own = row.owner == "object", .guessed = receiver.guessed};
}

const lua::DocRow* Kinds::row_of(const LuaNode* call, Kind* receiver) {
  const LuaNode* object = nullptr;
  std::string name;
  if (call->syntax == Syntax::method)
    object = call->parts[0], name = call->text;
  else if (call->syntax == Syntax::call && call->parts[0]->syntax == Syntax::index)
    object = call->parts[0]->parts[0], name = call->parts[0]->text;
  if (!object || name.empty()) return nullptr;
  const Kind kind = of(object);
  waits_ = kind.name.empty();
  // world.body(world, ...) has its arguments elsewhere
  if (!kind.known() || kind.list || (call->syntax == Syntax::call) != (kind.name == "feder")) return nullptr;
  if (receiver) *receiver = kind;
  return names_.function(kind.name, name);
}

std::string Kinds::required(const LuaNode* call) const {
  const bool is = call->syntax == Syntax::call && is_global(call->parts[0], "require") && call->parts.size() > 1 &&
                  call->parts[1]->syntax == Syntax::string;
  return is ? call->parts[1]->text : "";
}

Kind Kinds::of_call(const LuaNode* call, std::size_t result) {
  if (const std::string module = required(call); !module.empty()) {
    if (module == "feder") return {.name = module};
    if (names_.members("library " + module)) return {.name = "library " + module};
    return {.name = "module " + module};
  }
  Kind receiver;
  waits_ = false;
  if (const lua::DocRow* row = row_of(call, &receiver)) {
    const Words words = results_of(*row);
    if (result >= words.size()) return kNothingKnown;
    std::string word = words[result];
    if (word == "self") return receiver;
    const bool list = word.starts_with("{");
    if (list) word = word.substr(1, word.find_first_of(",}") - 1);
    return names_.is_class(word) ? Kind{.name = word, .list = list, .guessed = receiver.guessed} : kNothingKnown;
  }
  if (waits_) return {};
  // a function of the script
  const LuaNode* const callee = call->parts[0];
  if (call->syntax == Syntax::call && callee->syntax == Syntax::name && result == 0 && !callee->variable->function &&
      callee->variable->sources.size() == 1) {
    const LuaNode* const function = callee->variable->sources[0].value;
    if (function && function->syntax == Syntax::function) {
      const auto found = returned_.find(function);
      return found == returned_.end() ? Kind{} : found->second;
    }
  }
  return kNothingKnown;
}

Kind Kinds::of_loop(const LuaNode* loop, std::size_t result) {
  const LuaNode* const call = loop->parts[0];
  Kind receiver;
  waits_ = false;
  const lua::DocRow* const row = is_call(call) ? row_of(call, &receiver) : nullptr;
  if (waits_) return {};
  if (row && result == 0 && takes_event(*row)) return event_of(call, *row, receiver);
  const bool lists = call->syntax == Syntax::call && call->parts.size() == 2 &&
                     (is_global(call->parts[0], "ipairs") || is_global(call->parts[0], "pairs"));
  return lists && result == 1 ? element(call->parts[1]) : kNothingKnown;
}

Kind Kinds::of_index(const LuaNode* index) {
  if (index->text.empty()) return element(index->parts[0]);
  const Kind base = of(index->parts[0]);
  if (base.name.empty()) return {};
  if (base.name == "event" &&
      std::ranges::all_of(base.events, [&](const std::string& event) { return names_.is_object(event, index->text); }))
    return {.name = "object", .guessed = base.guessed};
  if (base.name != "scene" || base.list) return kNothingKnown;
  const auto found = fields_.find(index->text);
  return found == fields_.end() ? Kind{} : found->second;
}

Kinds::Place Kinds::place_of(const LuaNode* node) {
  if (node->syntax == Syntax::name && !node->variable->function && !node->variable->global) return {node->variable, ""};
  if (node->syntax == Syntax::index && !node->text.empty() && of(node->parts[0]).name == "scene")
    return {nullptr, node->text};
  return {};
}

Kind Kinds::element(const LuaNode* list) {
  Kind whole = of(list);
  if (whole.list) return whole.list = false, whole;
  if (whole.name.empty()) return {};
  const Place place = place_of(list);
  if (!place) return kNothingKnown;
  const auto found = elements_.find(place);
  return found == elements_.end() ? Kind{} : found->second;
}

// A use that leaves a list as it is: list[i], #list, ipairs(list), a test.
bool Kinds::reads(const LuaNode* use) const {
  const LuaNode* const parent = use->parent;
  if (!parent) return false;
  if (parent->syntax == Syntax::call)
    return is_global(parent->parts[0], "ipairs") || is_global(parent->parts[0], "pairs");
  return parent->syntax == Syntax::index || parent->syntax == Syntax::loop || parent->syntax == Syntax::other ||
         parent->syntax == Syntax::test;
}

Kind Kinds::elements_in(const LuaSource& source) {
  if (source.value && source.value->syntax == Syntax::nothing) return {};
  if (!source.value || source.value->syntax != Syntax::table) return kNothingKnown;
  Kind kind;
  for (const LuaNode* entry : source.value->parts) kind = join(kind, of(entry->parts[0]));
  return kind;
}

// Of the tables that locals and fields of the scene are given, and of what is written into them.
std::map<Kinds::Place, Kind> Kinds::find_elements() {
  std::map<Place, Kind> elements;
  const auto add = [&](const Place& place, const Kind& kind) {
    if (place) elements[place] = join(elements[place], kind);
  };
  for (const LuaVariable& v : tree_.variables)
    for (const LuaSource& source : v.sources) add({&v, ""}, elements_in(source));
  for (const auto& [target, source] : tree_.writes) {
    add(place_of(target), elements_in(source));
    add(place_of(target->parts[0]), of(source.value, source.result));
  }
  // where somebody else may change them
  for (const LuaNode& node : tree_.nodes)
    if (!node.assigned && !reads(&node)) add(place_of(&node), kNothingKnown);
  return elements;
}

const Words* Kinds::exports(const std::string& module) {
  const auto [at, fresh] = exports_.try_emplace(module);
  auto& [closed, names] = at->second;
  if (!fresh) return closed ? &names : nullptr;
  const std::filesystem::path file = names_.module_file(module, folder_);
  const LuaTree* const tree = file.empty() ? nullptr : names_.module_tree(file);
  const LuaNode* const result = tree ? tree->result : nullptr;
  if (!result) return nullptr;
  if (result->syntax == Syntax::table) closed = collect_exports(result, names);
  if (result->syntax == Syntax::name && result->variable->sources.size() == 1) {
    const LuaNode* const table = result->variable->sources[0].value;
    closed = table && table->syntax == Syntax::table && collect_exports(table, names);
    // every other use reads or writes a field by its name
    for (const LuaNode* use : result->variable->uses) {
      if (use == result) continue;
      const bool field = use->parent && use->parent->parts[0] == use &&
                         ((use->parent->syntax == Syntax::index && !use->parent->text.empty()) ||
                          use->parent->syntax == Syntax::method);
      closed = closed && field;
      if (field && use->parent->assigned) names.push_back(use->parent->text);
    }
  }
  return closed ? &names : nullptr;
}

}  // namespace feder::cli
