// Names that a script may use: functions, methods, options, events, globals and modules, from the rows and the sandbox
// of the binding itself.
#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "cli/check_tree.h"
#include "cli/options.h"
#include "lua/docs.h"

namespace feder::cli {

using Words = std::vector<std::string>;

class ScriptNames {
 public:
  explicit ScriptNames(const Options& options);

  // The row of a function of the module or of a method of a class; null when there is none.
  const lua::DocRow* function(std::string_view owner, std::string_view name) const;
  // Of an object's class or "world", "shape" ...; of "feder"; of a library of Lua, "library string". Null: not known.
  const Words* members(const std::string& kind) const;
  bool is_class(std::string_view name) const { return classes_.count(std::string(name)) > 0; }
  const Words& globals() const { return globals_; }  // sorted
  // The globals that a file makes, which is checked with others, are known to them.
  void add_globals(const std::filesystem::path& file);

  // Null for what is no event. The names of all; the fields of one, `own`: in a handler of an object.
  const EventKind* event(std::string_view name) const;
  const Words& events() const { return event_names_; }
  Words event_fields(const std::string& event, bool own) const;
  bool is_object(const std::string& event, std::string_view field) const;
  const std::vector<OptionInfo>& event_filters(const std::string& event) const;

  // Options in world = { ... }, its systems included.
  const std::vector<OptionInfo>& world_options() const;
  bool is_system(std::string_view name) const;  // that has options there

  // The file that `require` finds for a script in that folder: of the libraries, or in the folder or one around it.
  std::filesystem::path module_file(const std::string& name, const std::filesystem::path& folder) const;
  Words module_names(const std::filesystem::path& folder) const;
  // Its syntax tree; null for what cannot be read.
  const LuaTree* module_tree(const std::filesystem::path& file) const;

 private:
  void ask_sandbox(const Options& options);

  std::span<const lua::Part* const> parts_;
  Catalog systems_;
  std::vector<lua::DocRow> rows_;
  std::set<std::string> classes_, objects_;
  std::map<std::string, Words> members_;
  Words globals_, event_names_;
  std::vector<EventKind> events_;
  std::vector<std::filesystem::path> roots_;
  mutable std::map<std::string, std::vector<OptionInfo>> filters_;
  mutable std::optional<std::vector<OptionInfo>> world_options_;
  mutable std::map<std::filesystem::path, std::unique_ptr<LuaTree>> trees_;
};

// "-> body" of a signature: what the function returns, in its words.
Words results_of(const lua::DocRow& row);
// Its first argument is the name of an event: world:on, h:on, world:events, feder.wait_for.
bool takes_event(const lua::DocRow& row);

}  // namespace feder::cli
