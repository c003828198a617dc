#include "cli/check_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "cli/check_kinds.h"
#include "lua/state.h"

namespace feder::cli {
namespace {

class Rules {
 public:
  Rules(const ScriptNames& names, const LuaTree& tree, const std::filesystem::path& folder)
      : names_(names), tree_(tree), folder_(folder), kinds_(names, tree, folder) {
    collect_globals(tree);
  }

  std::vector<Finding> run() {
    for (const LuaNode& node : tree_.nodes)
      if (!may_fail(node)) check(node);
    std::ranges::stable_sort(findings_, {}, &Finding::line);
    return std::move(findings_);
  }

 private:
  void check(const LuaNode& node) {
    switch (node.syntax) {
      case Syntax::name: return check_global(node);
      case Syntax::index:
      case Syntax::method: check_member(node); return node.syntax == Syntax::method ? check_event(node) : void();
      case Syntax::call: check_module(node); return check_event(node);
      case Syntax::table: return check_options(node);
      default: return;
    }
  }

  void say(const LuaNode& node, std::string message) { findings_.push_back({node.line, std::move(message)}); }

  // In a function that pcall runs: its mistake may be what is asked for.
  static bool may_fail(const LuaNode& node) {
    for (const LuaNode* f = node.function; f; f = f->function) {
      const LuaNode* const call = f->parent;
      if (!call || call->syntax != Syntax::call || call->parts[0]->syntax != Syntax::name) continue;
      if (call->parts[0]->text == "pcall" || call->parts[0]->text == "xpcall") return true;
    }
    return false;
  }

  // Globals that the script and its modules make. They are open when a table of globals goes elsewhere.
  void collect_globals(const LuaTree& tree) {
    if (!seen_.insert(&tree).second) return;
    for (const auto& [name, variable] : tree.globals) {
      if (!variable->sources.empty()) made_.insert(name);
      if (name != "_G" && name != "_ENV") continue;
      for (const LuaNode* use : variable->uses) {
        const LuaNode* const index = use->parent;
        const bool field = index && index->syntax == Syntax::index && index->parts[0] == use && !index->text.empty();
        if (field && index->assigned) made_.insert(index->text);
        open_ = open_ || !field;
      }
    }
    for (const LuaVariable& v : tree.variables) open_ = open_ || v.name == "_ENV";
    open_ = open_ || runs_other(tree);
    for (const auto& [target, source] : tree.writes) added_.insert(owner_of(*target->parts[0]) + "." + target->text);
    for (const LuaNode& node : tree.nodes) {
      const std::string module = kinds_.required(&node);
      if (module.empty()) continue;
      const std::filesystem::path file = names_.module_file(module, folder_);
      if (const LuaTree* inner = file.empty() ? nullptr : names_.module_tree(file)) collect_globals(*inner);
    }
  }

  // Does it run what is not written in it: a text by load, a module whose name is no constant?
  static bool runs_other(const LuaTree& tree) {
    if (tree.globals.count("load")) return true;
    const auto require = tree.globals.find("require");
    if (require == tree.globals.end()) return false;
    return std::ranges::any_of(require->second->uses, [](const LuaNode* use) {
      return !use->parent || std::ranges::none_of(use->parent->parts,
                                                  [](const LuaNode* part) { return part->syntax == Syntax::string; });
    });
  }

  // The library or module that a name stands for in whatever text: "library string", "feder", "module x".
  std::string owner_of(const LuaNode& base) const {
    if (base.syntax != Syntax::name) return "";
    if (base.variable->global) return "library " + base.text;
    if (base.variable->sources.size() != 1 || !base.variable->sources[0].value) return "";
    const std::string module = kinds_.required(base.variable->sources[0].value);
    return module == "feder" ? module : (names_.members("library " + module) ? "library " : "module ") + module;
  }

  void check_global(const LuaNode& node) {
    const LuaVariable& v = *node.variable;
    const bool asks = node.parent && node.parent->syntax == Syntax::test;
    if (!v.global || node.assigned || open_ || asks || made_.count(node.text)) return;
    if (std::ranges::binary_search(names_.globals(), node.text)) return;
    Words near;
    for (const LuaVariable* local : node.visible) near.push_back(local->name);
    near.insert(near.end(), made_.begin(), made_.end());
    near.insert(near.end(), names_.globals().begin(), names_.globals().end());
    // of one or two letters, everything is near
    const std::string advice = node.text.size() > 2 ? lua::did_you_mean(node.text, near) : "";
    say(node, fmt::format("nothing is called '{}'{}", node.text, advice));
  }

  void check_member(const LuaNode& node) {
    const Kind kind = kinds_.of(node.parts[0]);
    if (node.text.empty() || !kind.known() || kind.list) return;
    if (kind.name == "event") return check_field(node, kind);
    const bool library = kind.name.starts_with("library "), module = kind.name.starts_with("module ");
    const std::string name = kind.name.substr(library ? 8 : module ? 7 : 0);
    if (node.assigned && (library || module || name == "feder")) return;  // a script may add to them
    const bool asks = node.parent && node.parent->syntax == Syntax::test;
    if (asks && (library || module)) return;
    const Words* const known = module ? kinds_.exports(name) : names_.members(kind.name);
    if (!known || std::ranges::find(*known, node.text) != known->end() || added_.count(kind.name + "." + node.text))
      return;
    const std::string near = lua::did_you_mean(node.text, *known);
    if (kind.guessed && near.empty()) return;
    if (names_.is_class(kind.name) && !library && name != "expect")
      say(node, fmt::format("{} {} has no method '{}'{}", name == "object" ? "an" : "a", name, node.text, near));
    else
      say(node, fmt::format("{}{} has no '{}'{}", module ? "the module " : "", name, node.text, near));
  }

  void check_field(const LuaNode& node, const Kind& event) {
    Words known;
    for (const std::string& kind : event.events)
      for (const std::string& field : names_.event_fields(kind, event.own)) known.push_back(field);
    if (std::ranges::find(known, node.text) != known.end()) return;
    std::string kinds;
    for (const std::string& kind : event.events) kinds += (kinds.empty() ? "" : ", ") + kind;
    say(node, fmt::format("event {}: no field '{}'{}", kinds, node.text, lua::did_you_mean_or(node.text, known)));
  }

  // The name of an event in the arguments.
  void check_event(const LuaNode& call) {
    Kind receiver;
    const lua::DocRow* const row = kinds_.row_of(&call, &receiver);
    if (!row || !takes_event(*row) || call.parts.size() < 2 || call.parts[1]->syntax != Syntax::string) return;
    const std::string& name = call.parts[1]->text;
    if (names_.event(name)) return;
    const std::string near = lua::did_you_mean(name, names_.events());
    if (receiver.guessed && near.empty()) return;
    say(*call.parts[1], fmt::format("unknown event '{}'{}", name, lua::did_you_mean_or(name, names_.events())));
  }

  void check_module(const LuaNode& call) {
    const std::string name = kinds_.required(&call);
    if (name.empty() || name == "feder" || names_.members("library " + name)) return;
    if (!names_.module_file(name, folder_).empty()) return;
    say(call, fmt::format("no module '{}'{}", name, lua::did_you_mean(name, names_.module_names(folder_))));
  }

  void check_options(const LuaNode& table) {
    std::string owner;
    const std::vector<OptionInfo>* const rows = kinds_.options_of(&table, &owner);
    if (!rows) return;
    Words known;
    for (const OptionInfo& row : *rows) known.emplace_back(row.row.name);
    for (const LuaNode* entry : table.parts) {
      if (entry->text.empty()) continue;
      const auto row = std::ranges::find_if(*rows, [&](const OptionInfo& o) { return entry->text == o.row.name; });
      if (row == rows->end())
        say_unknown(*entry, *rows, known, owner);
      else
        check_choice(*entry, *row, owner);
    }
  }

  // As the reader of the options would say it.
  void say_unknown(const LuaNode& entry, const std::vector<OptionInfo>& rows, const Words& known,
                   const std::string& owner) {
    for (const OptionInfo& row : rows) {
      const bool world = std::string_view(row.row.name) == "world";  // with its systems
      for (const OptionInfo& inner : world ? names_.world_options() : row.inner) {
        if (entry.text != inner.row.name) continue;
        const std::string within = world && names_.is_system(entry.text) ? entry.text + " = { ... }" : "...";
        return say(entry,
                   fmt::format("{}: '{}' belongs into `{} = {{ {} }}`", owner, entry.text, row.row.name, within));
      }
    }
    say(entry, fmt::format("{}: unknown option '{}'{}", owner, entry.text, lua::did_you_mean_or(entry.text, known)));
  }

  void check_choice(const LuaNode& entry, const OptionInfo& row, const std::string& owner) {
    const LuaNode& value = *entry.parts[0];
    if (value.syntax != Syntax::string || row.choices.empty() || std::string_view(row.type) != "string") return;
    const std::vector<std::string_view> choices = split_choices(row.choices);
    if (std::ranges::find(choices, value.text) != choices.end()) return;
    say(value, fmt::format("{}.{}: expected one of {}, got '{}'", owner, row.row.name, row.choices, value.text));
  }

  const ScriptNames& names_;
  const LuaTree& tree_;
  std::filesystem::path folder_;
  Kinds kinds_;
  std::set<const LuaTree*> seen_;
  std::set<std::string> made_, added_;  // globals; "string.trim"
  bool open_ = false;
  std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> check_names(std::string_view text, const std::filesystem::path& folder, const ScriptNames& names) {
  const std::unique_ptr<LuaTree> tree = parse_lua(text);
  return Rules(names, *tree, folder).run();
}

}  // namespace feder::cli
