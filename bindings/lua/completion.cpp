#include "lua/completion.h"

#include <algorithm>
#include <set>

namespace feder::lua {
namespace {

bool of_word(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; }

// The word that ends before `end`.
std::string_view word_before(std::string_view line, std::size_t end) {
  std::size_t from = end;
  while (from > 0 && of_word(line[from - 1])) --from;
  return line.substr(from, end - from);
}

// The brackets that are open at the end of a line, innermost last, and whether a text is.
struct Opened {
  std::vector<std::size_t> brackets;
  std::size_t text = std::string_view::npos;
};
Opened opened(std::string_view line) {
  Opened out;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (out.text != std::string_view::npos) {
      if (c == '\\')
        ++i;
      else if (c == line[out.text])
        out.text = std::string_view::npos;
    } else if (c == '"' || c == '\'') {
      out.text = i;
    } else if (c == '(' || c == '{' || c == '[') {
      out.brackets.push_back(i);
    } else if ((c == ')' || c == '}' || c == ']') && !out.brackets.empty()) {
      out.brackets.pop_back();
    }
  }
  return out;
}

// The function whose bracket opens at `at`: "body" of "world:body {".
std::string_view function_before(std::string_view line, std::size_t at) {
  while (at > 0 && line[at - 1] == ' ') --at;
  return word_before(line, at);
}

// Options of the table that is being written: of its function, or of the option that it is the value of.
void add_options(const std::vector<ReferencePage>& pages, std::string_view line, const Opened& open,
                 std::set<std::string>& out) {
  const std::size_t last = open.brackets.back();
  std::string path;
  std::string_view name = function_before(line, last);
  if (name.empty() && open.brackets.size() > 1) {  // { limits = { ...
    std::size_t at = line.find_last_not_of(" =", last - 1);
    if (at == std::string_view::npos) return;
    path = std::string(word_before(line, at + 1)) + ".";
    name = function_before(line, open.brackets[open.brackets.size() - 2]);
  }
  for (const ReferencePage& page : pages)
    if (page.kind != PageKind::event && page.kind != PageKind::command && page.kind != PageKind::yaml &&
        page.name == name)
      for (const ReferenceRow& row : page.rows)
        if (row.name.starts_with(path) && row.name.find('.', path.size()) == std::string::npos)
          out.insert(row.name.substr(path.size()) + " =");
}

}  // namespace

Completion complete(const std::vector<ReferencePage>& pages, std::string_view line) {
  const std::string_view word = word_before(line, line.size());
  Completion result{line.size() - word.size(), {}};
  const char before = result.from > 0 ? line[result.from - 1] : ' ';
  const Opened open = opened(line);
  std::set<std::string> known;
  const auto add_owner = [&](std::string_view owner) {
    for (const ReferencePage& page : pages)
      if (page.owner == owner && page.kind != PageKind::event) known.insert(page.name);
  };
  if (open.text != std::string_view::npos) {
    const std::string_view function = open.brackets.empty() ? "" : function_before(line, open.brackets.back());
    if (function == "on" || function == "events" || function == "wait_for")
      for (const ReferencePage& page : pages)
        if (page.kind == PageKind::event) known.insert(page.name);
  } else if (before == ':') {
    const std::string_view self = word_before(line, result.from - 1);
    for (const ReferencePage& page : pages)
      if (page.kind == PageKind::method && (self == "world") == (page.owner == "world")) known.insert(page.name);
  } else if (before == '.') {
    if (word_before(line, result.from - 1) == "feder") add_owner("feder");
    if (word_before(line, result.from - 1) == "e")
      for (const ReferencePage& page : pages)
        for (const ReferenceRow& row : page.rows)
          if (page.kind == PageKind::event && row.name.starts_with("e.")) known.insert(row.name.substr(2));
  } else {
    if (!open.brackets.empty() && line[open.brackets.back()] == '{') add_options(pages, line, open, known);
    if (known.empty())
      known = {"feder", "world", "scene", "print", "for", "function", "local", "math", "string", "table"};
  }
  for (const std::string& candidate : known)
    if (candidate.starts_with(word)) result.words.push_back(candidate);
  return result;
}

}  // namespace feder::lua
