// feder.choices: the names that an option takes, by its path from whoever reads it: "cloth.solver", "joint.type",
// "world.rigid.solver", "net.integrator_options.solver".
#include "lua/choices.h"

#include <algorithm>
#include <map>

#include "feder/world.h"
#include "lua/docs.h"
#include "lua/library.h"
#include "lua/options.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

using Names = std::vector<std::string>;
using Choices = std::map<std::string, Names>;  // by path; of an option of several variants the names of all

void add_choices(const std::string& path, const std::vector<OptionInfo>& rows, Choices& all) {
  for (const OptionInfo& o : rows) {
    const std::string at = path + "." + o.row.name;
    for (std::string_view word : split_choices(o.choices))
      if (std::ranges::find(all[at], word) == all[at].end()) all[at].emplace_back(word);
    add_choices(at, o.inner, all);
  }
}

Choices choices_of_functions(std::span<const Part* const> parts) {
  Choices all;
  for (const DocRow& row : docs(parts)) add_choices(row.name, row.options, all);
  return all;
}

// Systems say what they read when they are made.
void add_choices_of_systems(Catalog systems, Choices& all) {
  World probe({}, systems);
  for (const SystemDescriptor* d : systems) {
    if (!d->joins.empty()) continue;
    probe.need_system(d->name);
    const std::vector<OptionInfo> rows = system_options(systems, d->name);
    add_choices(d->name, rows, all);
    add_choices(std::string("world.") + d->name, rows, all);
  }
  add_choices("world", probe.desc().options.rows(), all);
}

}  // namespace

int feder_choices(lua_State* L) {
  std::string wanted = check_text(L, 1, function_name(L));
  if (const std::string_view owner = "world:"; wanted.starts_with(owner)) wanted.erase(0, owner.size());
  Choices all = choices_of_functions(state(L).options.parts);
  if (!all.count(wanted)) add_choices_of_systems(state(L).options.systems, all);
  const auto found = all.find(wanted);
  if (found != all.end()) return push_list(L, found->second, [&](const std::string& name) { push(L, name); }), 1;
  const std::string module = wanted.substr(0, wanted.find('.'));
  if (is_left_out("feder." + module)) fail_here(L, "this build leaves out the module '" + module + "'");
  Names known;
  for (const auto& [path, names] : all) known.push_back(path);
  fail_here(L, "expected an option with choices, such as \"joint.type\", got " + describe(L, 1) +
                   did_you_mean(wanted, known));
}

}  // namespace feder::lua
