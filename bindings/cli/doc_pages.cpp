// What there is to read about, and what a word finds.
#include "cli/doc_pages.h"

#include <algorithm>
#include <cctype>

namespace feder::cli {
namespace {

lua::ReferencePage command_page(const Row& row) {
  Arguments arguments(row.name, row.summary);
  Options options;
  const auto command = row.make();
  command->declare(arguments);
  declare(arguments, options);
  lua::ReferencePage page{
      lua::PageKind::command, std::string("feder ") + row.name, "command", row.name, "", row.summary, "", {}};
  page.signature = page.title;
  for (const Arguments::Declared& o : arguments.declared()) {
    if (o.name[0] != '-') page.signature += (o.required ? " " : " [") + o.name + (o.required ? "" : "]");
    page.rows.push_back({o.name, o.type, "", "", "", "", o.help});
  }
  page.signature += " [options]";
  for (lua::ReferenceRow& field : output_fields(row.name)) page.rows.push_back(std::move(field));
  return page;
}

// "world.joint()" and "World:Joint" are "world:joint".
std::string plain(std::string_view text) {
  std::string out;
  for (const char c : text.substr(0, text.find('(')))
    out += c == '.' ? ':' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

bool contains(const std::string& text, const std::string& word) { return plain(text).find(word) != std::string::npos; }

template <class Test>
Pages chosen(const Pages& all, Test&& test) {
  Pages out;
  std::ranges::copy_if(all, std::back_inserter(out), test);
  return out;
}

}  // namespace

Pages all_pages(const Build& build) {
  Pages pages = lua::reference(build.parts, build.systems);
  for (const Row& row : commands()) pages.push_back(command_page(row));
  return pages;
}

std::vector<Owner> owners(const Pages& pages) {
  static const Owner known[] = {{"feder", "functions of the module"},
                                {"world", "methods of a world"},
                                {"object", "methods of every object"},
                                {"expect", "what checks expect"},
                                {"event", "kinds of events, with their fields"},
                                {"options", "options of systems in world = {}"},
                                {"yaml", "what scenes in YAML have besides"},
                                {"command", "commands of the program"}};
  std::vector<Owner> out;
  for (const lua::ReferencePage& page : pages) {
    if (std::ranges::any_of(out, [&](const Owner& o) { return o.name == page.owner; })) continue;
    const auto row = std::ranges::find_if(known, [&](const Owner& o) { return o.name == page.owner; });
    out.push_back(row != std::end(known) ? *row
                                         : Owner{page.owner, std::string("methods of ") +
                                                                 (page.owner[0] == 'e' ? "an " : "a ") + page.owner});
  }
  return out;
}

Found find_pages(const Pages& all, const std::string& word) {
  const std::string wanted = plain(word);
  // of that title or name, and with them what its objects can do
  Pages named = chosen(all, [&](const auto& p) { return plain(p.title) == wanted || plain(p.name) == wanted; });
  if (!named.empty()) return {std::move(named), true};
  if (Pages owned = chosen(all, [&](const auto& p) { return p.owner == wanted; }); !owned.empty())
    return {owned, false};
  // an option or a field: the pages that have it, with that row alone
  Pages rows;
  for (const lua::ReferencePage& page : all) {
    lua::ReferencePage part = page;
    std::erase_if(part.rows, [&](const lua::ReferenceRow& r) {
      const std::string name = plain(r.name), full = plain(page.name) + ":" + name;
      if (name[0] == ':' && name.ends_with(":" + wanted)) return false;  // of what --json prints
      return name != wanted && full != wanted && name != "e:" + wanted && name.find("--" + wanted) == std::string::npos;
    });
    if (part.rows.empty()) continue;
    part.example.clear();
    rows.push_back(std::move(part));
  }
  if (!rows.empty()) return {std::move(rows), true};
  return {chosen(all, [&](const auto& p) { return contains(p.title, wanted) || contains(p.text, wanted); }), false};
}

report::Json pages_json(const Pages& pages) {
  report::Json all = report::Json::array();
  for (const lua::ReferencePage& p : pages) {
    report::Json rows = report::Json::array();
    for (const lua::ReferenceRow& r : p.rows)
      rows.push_back({{"name", r.name},
                      {"type", r.type},
                      {"unit", r.unit},
                      {"default", r.fallback},
                      {"allowed", r.allowed},
                      {"of", r.of},
                      {"text", r.text}});
    all.push_back({{"title", p.title},
                   {"owner", p.owner},
                   {"signature", p.signature},
                   {"text", p.text},
                   {"example", p.example},
                   {"rows", rows}});
  }
  return all;
}

}  // namespace feder::cli
