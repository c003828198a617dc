// Pages for a terminal, and as one Markdown document.
#include <algorithm>

#include "cli/doc_pages.h"
#include "report/table.h"

namespace feder::cli {
namespace {

// "number, kg/m3", and what is allowed of it.
std::string type_text(const lua::ReferenceRow& r) {
  return r.type + (r.unit.empty() ? "" : (r.type.empty() ? "" : ", ") + r.unit);
}

// Sentence, then names or range, then the variant that reads it.
std::string meaning(const lua::ReferenceRow& r) {
  std::string text = r.text;
  if (!r.allowed.empty()) text += (text.empty() ? "" : " ") + std::string("One of: ") + r.allowed + ".";
  if (r.allowed.starts_with("a ")) text.replace(text.find("One of: "), 8, "Takes ");
  if (!r.of.empty()) text += " Of " + r.of + " alone.";
  return text;
}

// At blanks, into lines of at most `width`, all but the first behind `indent`.
std::string wrapped(const std::string& text, std::size_t width, const std::string& indent) {
  std::string out, line;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, end - at);
    if (!line.empty() && line.size() + 1 + word.size() > width) {
      out += line + "\n" + indent;
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
    at = end + 1;
  }
  return out + line;
}

std::string indented(const std::string& code) {
  std::string out;
  for (std::size_t at = 0; at < code.size();) {
    const std::size_t end = std::min(code.find('\n', at), code.size());
    out += end > at ? "    " + code.substr(at, end - at) + "\n" : "\n";
    at = end + 1;
  }
  return out;
}

// What may stand in a cell of a Markdown table.
std::string cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

}  // namespace

std::string page_text(const lua::ReferencePage& page) {
  std::string out = page.signature + "\n  " + wrapped(page.text, 96, "  ") + "\n";
  std::size_t name = 0, type = 0, fallback = 0;
  for (const lua::ReferenceRow& r : page.rows) {
    name = std::max(name, r.name.size()), type = std::max(type, type_text(r).size());
    fallback = std::max(fallback, r.fallback.size());
  }
  name = std::min<std::size_t>(name, 28), type = std::min<std::size_t>(type, 28);
  fallback = std::min<std::size_t>(fallback, 20);
  if (!page.rows.empty()) out += "\n";
  for (const lua::ReferenceRow& r : page.rows) {
    const std::string lead =
        fmt::format("  {:<{}}  {:<{}}  {:<{}}  ", r.name, name, type_text(r), type, r.fallback, fallback);
    const std::string indent(6 + name + type + fallback + 2, ' ');
    out += lead +
           wrapped(meaning(r), std::max<std::size_t>(40, 118 - std::min<std::size_t>(78, indent.size())), indent) +
           "\n";
  }
  if (!page.example.empty()) out += "\n  Example:\n" + indented(page.example);
  return out;
}

std::string line_text(const lua::ReferencePage& page) {
  return page.signature + "\n    " + wrapped(page.text, 96, "    ") + "\n";
}

std::string doc_text(const Pages& all, const std::string& word) {
  const Found found = find_pages(all, word);
  if (found.pages.empty()) {
    std::vector<std::string> known;
    for (const lua::ReferencePage& p : all) known.push_back(p.title), known.push_back(p.name);
    throw Failure(kFailed, "feder doc: nothing about '{}'{}", word, did_you_mean("; ", word, known));
  }
  std::string text, methods;
  for (const lua::ReferencePage& p : found.pages) {
    if (found.exact && !text.empty()) text += "\n";
    text += found.exact ? page_text(p) : line_text(p);
  }
  // and what objects of that name can do
  for (const lua::ReferencePage& p : all)
    if (found.exact && p.owner == word) methods += " " + p.title;
  return methods.empty() ? text : text + "\nMethods (feder doc NAME):" + wrapped(methods, 96, "  ") + "\n";
}

std::string index_text(const Pages& pages) {
  std::string out;
  for (const Owner& owner : owners(pages)) {
    std::string names;
    for (const lua::ReferencePage& p : pages)
      if (p.owner == owner.name) names += (names.empty() ? "" : " ") + p.name;
    out += owner.name + ": " + owner.text + "\n  " + wrapped(names, 96, "  ") + "\n";
  }
  return out + "\nfeder doc WORD shows one of these, an option (density), or what has the word in its text.\n";
}

std::string pages_markdown(const Pages& pages) {
  std::string out = "# feder reference\n\nSI units, radians, y is up. `feder doc --markdown` writes this document.\n";
  for (const Owner& owner : owners(pages)) {
    out += "\n## " + owner.name + "\n\n" + owner.text + ".\n";
    for (const lua::ReferencePage& p : pages) {
      if (p.owner != owner.name) continue;
      out += "\n### " + p.title + "\n\n`" + p.signature + "`\n\n" + p.text + "\n";
      if (!p.rows.empty()) out += "\n| name | type | default | meaning |\n|---|---|---|---|\n";
      for (const lua::ReferenceRow& r : p.rows)
        out += fmt::format("| `{}` | {} | {} | {} |\n", cell(r.name), cell(type_text(r)), cell(r.fallback),
                           cell(meaning(r)));
      if (!p.example.empty()) out += "\n```lua\n" + p.example + "```\n";
    }
  }
  return out;
}

}  // namespace feder::cli
