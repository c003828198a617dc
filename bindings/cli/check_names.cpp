#include "cli/check_names.h"

#include <algorithm>
#include <sstream>

#include "cli/session.h"
#include "lua/part.h"
#include "lua/reference.h"

namespace feder::cli {

namespace fs = std::filesystem;

ScriptNames::ScriptNames(const Options& options)
    : parts_(options.build.parts), systems_(options.build.systems), rows_(lua::docs(parts_)), roots_(library_roots()) {
  objects_.insert(std::string(kForceKind.text()));
  for (const lua::Part* part : parts_)
    for (const lua::ObjectClass& c : part->classes) objects_.insert(c.name);
  for (const lua::DocRow& row : rows_) {
    classes_.insert(row.owner);
    members_[row.owner].push_back(row.name);
  }
  classes_.insert(objects_.begin(), objects_.end());
  classes_.erase("feder");
  const Words shared = members_["object"];
  for (const std::string& name : objects_) {
    Words& own = members_[name];
    own.insert(own.end(), shared.begin(), shared.end());
    // of an object whose class is not known: what any of them has
    members_["object"].insert(members_["object"].end(), own.begin(), own.end());
  }
  events_ = lua::event_kinds(systems_);
  for (EventKind kind : events_) event_names_.emplace_back(kind.text());
  ask_sandbox(options);
}

// Globals and libraries as a script finds them: lines "global", "library<tab>member".
void ScriptNames::ask_sandbox(const Options& options) {
  std::string text;
  lua::HostOptions host = host_options(options);
  host.set.clear();
  host.world.clear();
  host.print = [&text](std::string_view more) { text += more; };
  lua::Script(std::move(host))
      .load_string(R"(
for name, value in pairs(_G) do
  print(name)
  if type(value) == "table" and value ~= _G then for member in pairs(value) do print(name, member) end end
end
for member in pairs(require "feder") do print("feder", member) end)",
                   "check");
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const std::size_t tab = line.find('\t');
    const std::string name = line.substr(0, tab);
    if (tab == std::string::npos)
      globals_.push_back(name);
    else
      members_[name == "feder" ? name : "library " + name].push_back(line.substr(tab + 1));
  }
  std::ranges::sort(globals_);
}

void ScriptNames::add_globals(const fs::path& file) {
  const LuaTree* const tree = module_tree(file);
  if (!tree) return;
  for (const auto& [name, variable] : tree->globals)
    if (!variable->sources.empty()) globals_.push_back(name);
  std::ranges::sort(globals_);
}

const lua::DocRow* ScriptNames::function(std::string_view owner, std::string_view name) const {
  const auto find = [&](std::string_view of) {
    const auto found = std::ranges::find_if(rows_, [&](const auto& r) { return r.owner == of && r.name == name; });
    return found == rows_.end() ? nullptr : &*found;
  };
  const lua::DocRow* const own = find(owner);
  return own || !objects_.count(std::string(owner)) ? own : find("object");
}

const Words* ScriptNames::members(const std::string& kind) const {
  const auto found = members_.find(kind);
  return found == members_.end() ? nullptr : &found->second;
}

const EventKind* ScriptNames::event(std::string_view name) const {
  const auto found = std::ranges::find_if(events_, [&](const EventKind& k) { return name == k.text(); });
  return found == events_.end() ? nullptr : &*found;
}

Words ScriptNames::event_fields(const std::string& name, bool own) const {
  Words fields = members_.at("event");  // its methods
  if (const EventKind* kind = event(name))
    for (const OptionInfo& field : lua::event_fields(*kind, own)) fields.emplace_back(field.row.name);
  return fields;
}

bool ScriptNames::is_object(const std::string& name, std::string_view field) const {
  const EventKind* const kind = event(name);
  if (!kind) return false;
  const std::vector<OptionInfo> fields = lua::event_fields(*kind, true);
  const auto found = std::ranges::find_if(fields, [&](const OptionInfo& f) { return field == f.row.name; });
  return found != fields.end() && std::string_view(found->type) == "object";
}

const std::vector<OptionInfo>& ScriptNames::event_filters(const std::string& name) const {
  const auto [at, fresh] = filters_.try_emplace(name);
  const EventKind* const kind = event(name);
  if (fresh && kind) at->second = lua::event_filters(*kind);
  return at->second;
}

const std::vector<OptionInfo>& ScriptNames::world_options() const {
  if (world_options_) return *world_options_;
  world_options_ = function("feder", "world")->options;
  for (const SystemDescriptor* d : systems_) {
    if (!d->joins.empty()) continue;
    OptionInfo& system = world_options_->emplace_back();
    system.row.name = d->name;
    system.type = "table";
    system.inner = lua::system_options(systems_, d->name);
  }
  return *world_options_;
}

bool ScriptNames::is_system(std::string_view name) const {
  return std::ranges::any_of(systems_, [&](const SystemDescriptor* d) { return d->joins.empty() && name == d->name; });
}

fs::path ScriptNames::module_file(const std::string& name, const fs::path& folder) const {
  std::string relative = name + ".lua";
  std::replace(relative.begin(), relative.begin() + static_cast<std::ptrdiff_t>(name.size()), '.', '/');
  std::error_code ignored;
  for (const fs::path& root : roots_)
    if (fs::is_regular_file(root / relative, ignored)) return root / relative;
  // of a module, the scene that requires it is not known: it may lie further out
  fs::path at = fs::absolute(folder.empty() ? "." : folder, ignored).lexically_normal();
  for (;; at = at.parent_path()) {
    if (fs::is_regular_file(at / relative, ignored)) return at / relative;
    if (at == at.parent_path()) return {};
  }
}

Words ScriptNames::module_names(const fs::path& folder) const {
  Words names = globals_;  // libraries of Lua can be required
  std::erase_if(names, [&](const std::string& name) { return !members_.count("library " + name); });
  names.emplace_back("feder");
  const auto add = [&names](const fs::path& file, const fs::path& root) {
    if (file.extension() != ".lua") return;
    std::string name = fs::path(file).replace_extension().lexically_relative(root).generic_string();
    std::ranges::replace(name, '/', '.');
    names.push_back(std::move(name));
  };
  std::error_code ignored;
  for (const fs::path& root : roots_)
    for (const auto& entry : fs::recursive_directory_iterator(root, ignored)) add(entry.path(), root);
  const fs::path beside = folder.empty() ? "." : folder;
  for (const auto& entry : fs::directory_iterator(beside, ignored)) add(entry.path(), beside);
  std::ranges::sort(names);
  return names;
}

const LuaTree* ScriptNames::module_tree(const fs::path& file) const {
  const auto [at, fresh] = trees_.try_emplace(file);
  if (!fresh) return at->second.get();
  try {
    check_syntax(file.string(), {});
    at->second = parse_lua(read_text(file.string()));
  } catch (const std::exception&) {
    // said where that file is checked
  }
  return at->second.get();
}

Words results_of(const lua::DocRow& row) {
  const std::string mark = "-> ";
  const std::size_t at = row.signature.find(mark);
  if (at == std::string::npos) return {};
  const std::string all = row.signature.substr(at + mark.size());
  if (all.starts_with("{")) return {all};
  Words words;
  std::istringstream in(all);
  for (std::string word; std::getline(in, word, ',');) words.push_back(word.substr(word.find_first_not_of(' ')));
  return words;
}

bool takes_event(const lua::DocRow& row) { return row.signature.find(row.name + "(kind") != std::string::npos; }

}  // namespace feder::cli
