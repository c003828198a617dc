// Pages of the reference from the rows of functions, options and events; sentences on options, from the options.txt of
// all folders; examples, from examples.lua.
#include "lua/reference.h"

#include <algorithm>

#include "feder/world.h"
#include "lua/part.h"
#include "lua/yaml_scene.h"

namespace feder::lua {
namespace {

// Lines "owner.option  sentence", of all options.txt.
constexpr std::string_view kTexts =
#include "option_texts.inc"
    ;

std::string_view sentence(const std::string& key) {
  const std::size_t at = kTexts.find("\n" + key + " ");
  if (at == std::string_view::npos) return {};
  const std::size_t from = kTexts.find_first_not_of(' ', at + 1 + key.size());
  return kTexts.substr(from, kTexts.find('\n', from) - from);
}

}  // namespace

std::string_view option_sentence(std::string_view owner, std::string_view option) {
  const std::string_view own = sentence(std::string(owner) + "." + std::string(option));
  return own.empty() ? sentence("*." + std::string(option)) : own;
}

std::string_view option_texts() { return kTexts; }

namespace {

constexpr std::string_view kExamples =
#include "examples.inc"
    ;

std::string allowed(const OptionInfo& o) {
  if (!o.choices.empty()) return o.choices;
  const Range& r = o.row.range;
  const bool number = std::string_view(o.type) == "number", whole = std::string_view(o.type) == "integer";
  if ((!number && !whole) || (r.lo <= kAny.lo && r.hi >= kAny.hi)) return "";
  return whole ? r.whole() : r.text();
}

// Rows of tables within follow their row, with its name in front; their sentences are its.
void add_rows(const std::string& owner, const std::string& before, const std::vector<OptionInfo>& from,
              std::vector<ReferenceRow>& rows) {
  for (const OptionInfo& o : from) {
    const std::string& by = o.of.empty() ? owner : o.of;
    rows.push_back({before + o.row.name, o.type, o.row.unit, o.fallback, allowed(o), o.of,
                    std::string(option_sentence(by, o.row.name)), o.row.range});
    add_rows(o.row.name, before + o.row.name + ".", o.inner, rows);
  }
}

// Defaults and names of what systems read from the world's own options: broad_phase, air_density.
void complete_world(Catalog systems, std::vector<ReferenceRow>& rows) {
  World probe({}, systems);
  for (const SystemDescriptor* d : systems)
    if (d->joins.empty()) probe.need_system(d->name);
  for (const OptionInfo& o : probe.desc().options.rows())
    for (ReferenceRow& row : rows) {
      if (row.name != o.row.name) continue;
      if (row.fallback.empty()) row.fallback = o.fallback;
      if (row.allowed.empty()) row.allowed = allowed(o);
    }
}

std::string title_of(const DocRow& row) {
  return row.owner + (row.signature.starts_with(row.owner + ".") ? "." : ":") + row.name;
}

ReferencePage event_page(EventKind kind) {
  const std::string name = kind.text();
  ReferencePage page{PageKind::event, name, "event", name, "", std::string(option_sentence("events", name)), "", {}};
  page.signature =
      "world:on(\"" + name + "\", " + (kind.has(EventKind::kAlone) ? "" : "[filter], ") + "function(e) end)";
  add_rows("event", "e.", event_fields(kind, true), page.rows);
  add_rows("filter", "filter.", event_filters(kind), page.rows);
  return page;
}

// What a scene in YAML has that no function has: lists of objects, parameters, forces, a check.
void add_yaml_pages(std::span<const Part* const> parts, std::vector<ReferencePage>& pages) {
  const auto add = [&](const std::string& key, const std::string& form, const std::string& text) -> ReferencePage& {
    pages.push_back({PageKind::yaml, "yaml." + key, "yaml", key, key + ": " + form, text, "", {}});
    return pages.back();
  };
  for (const Part* part : parts)
    for (const YamlList& list : part->yaml) {
      const std::string maker = list.maker ? std::string("world:") + list.maker : "";
      ReferencePage& page =
          add(list.key, "[ { ... }, ... ]",
              maker.empty() ? "objects of the world" : "objects of the world, with the options of " + maker);
      page.maker = maker;
      if (list.more) add_rows(list.key, "", list.more(), page.rows);
    }
  add("forces", "[ { ... }, ... ]", "forces of the world, with the options of world:force").maker = "world:force";
  ReferencePage& params = add("params", "{ NAME: value, NAME: { value:, min:, max:, step:, choices:, help: }, ... }",
                              "parameters as of feder.param; \"$NAME\" as a value anywhere below stands for one");
  add_rows("param", "", yaml_param_rows(), params.rows);
  add("check", "text", "Lua text that sees world, scene and expect, and makes the scene a test");
}

}  // namespace

std::vector<Example> examples() {
  std::vector<Example> all;
  constexpr std::string_view kMark = "\n--: ";
  for (std::size_t at = kExamples.find(kMark); at != std::string_view::npos;) {
    const std::size_t from = at + kMark.size(), line = kExamples.find('\n', from);
    at = kExamples.find(kMark, line);
    const std::size_t end = std::min(at, kExamples.size());
    all.push_back({std::string(kExamples.substr(from, line - from)),
                   std::string(kExamples.substr(line + 1, end > line ? end - line : 0))});
  }
  return all;
}

std::vector<EventKind> event_kinds(Catalog systems) {
  std::vector<EventKind> all(std::begin(kEventKinds), std::end(kEventKinds));
  for (const SystemDescriptor* d : systems) all.insert(all.end(), d->events.begin(), d->events.end());
  return all;
}

std::vector<ReferencePage> reference(std::span<const Part* const> parts, Catalog systems) {
  std::vector<ReferencePage> pages;
  for (const DocRow& row : docs(parts)) {
    const PageKind kind = row.owner == "feder" ? PageKind::function : PageKind::method;
    pages.push_back({kind, title_of(row), row.owner, row.name, row.signature, row.doc, "", {}});
    add_rows(row.name, "", row.options, pages.back().rows);
    if (pages.back().title == "feder.world") complete_world(systems, pages.back().rows);
  }
  for (const EventKind& kind : event_kinds(systems)) pages.push_back(event_page(kind));
  for (const SystemDescriptor* d : systems) {
    if (!d->joins.empty()) continue;
    ReferencePage page{PageKind::options, std::string("world.") + d->name, "options", d->name, "", "", "", {}};
    page.signature = std::string("feder.world{ ") + d->name + " = { ... } }";
    page.text = std::string("options of ") + d->name + " in a world";
    add_rows(d->name, "", system_options(systems, d->name), page.rows);
    if (!page.rows.empty()) pages.push_back(std::move(page));
  }
  add_yaml_pages(parts, pages);
  for (Example& example : examples())
    for (ReferencePage& page : pages)
      if (page.title == example.title) page.example = example.code;
  return pages;
}

}  // namespace feder::lua
