#include "cli/test_source.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "cli/check_tokens.h"

namespace feder::cli {
namespace {

constexpr std::size_t kLineWidth = 200;  // characters of a line

std::vector<Token> tokens_of(const std::string& line) {
  LuaTokens reader(line);
  std::vector<Token> tokens;
  while (reader.now().kind != TokenKind::end) tokens.push_back(reader.take());
  tokens.push_back({.offset = line.size()});
  return tokens;
}

bool is_sign(const Token& t, std::string_view any) {
  return t.kind == TokenKind::sign && t.text.size() == 1 && any.find(t.text) != std::string_view::npos;
}

// Index of the token that closes the bracket at `open`; the end of the line when it is on another.
std::size_t closing(const std::vector<Token>& tokens, std::size_t open) {
  int depth = 0;
  for (std::size_t i = open; i + 1 < tokens.size(); ++i) {
    depth += is_sign(tokens[i], "({[") ? 1 : is_sign(tokens[i], ")}]") ? -1 : 0;
    if (depth == 0) return i;
  }
  return tokens.size() - 1;
}

// "^~~~" under each call of `name`, from the start of "a.b:name" on. Lua knows lines, not columns: of two calls of one
// name in a line both are marked.
std::string call_marks(const std::string& line, const std::string& name) {
  const std::vector<Token> tokens = tokens_of(line);
  std::string marks;
  for (std::size_t i = 0; i + 1 < tokens.size(); ++i) {
    const bool called = is_sign(tokens[i + 1], "({") || tokens[i + 1].kind == TokenKind::string;
    if (tokens[i].kind != TokenKind::name || tokens[i].text != name || !called) continue;
    std::size_t first = i;
    while (first >= 2 && is_sign(tokens[first - 1], ".:") && tokens[first - 2].kind == TokenKind::name) first -= 2;
    const std::size_t from = tokens[first].offset, end = tokens[closing(tokens, i + 1)].offset;
    marks.resize(std::max(marks.size(), from), ' ');
    if (marks.size() == from) marks += '^' + std::string(end > from ? std::min(end, line.size() - 1) - from : 0, '~');
  }
  return marks;
}

// Names of functions in front of a message, the last first: "world:body.density: expected ..." -> density, body, world.
std::vector<std::string> names_in_front(const std::string& message) {
  const std::string front = message.substr(0, message.find(": "));
  if (front.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789.:") != std::string::npos) return {};
  std::vector<std::string> names(1);
  for (const char c : front) c == '.' || c == ':' ? names.emplace_back().clear() : names.back().push_back(c);
  std::ranges::reverse(names);
  return names;
}

std::string line_of(const std::string& where, const std::vector<std::string>& files) {
  const std::size_t colon = where.rfind(':');
  if (colon == std::string::npos) return {};
  const auto file = std::ranges::find_if(files, [&](const auto& f) { return f.ends_with(where.substr(0, colon)); });
  if (file == files.end()) return {};
  std::ifstream in(*file);
  std::string line;
  for (int n = std::atoi(where.c_str() + colon + 1); n > 0; --n)
    if (!std::getline(in, line)) return {};
  const std::size_t first = line.find_first_not_of(" \t");
  return first == std::string::npos ? "" : line.substr(first, kLineWidth);
}

}  // namespace

void add_source(report::TestFailure& f, const std::vector<std::string>& files, const std::string& call) {
  f.source = line_of(f.where, files);
  for (const std::string& name : call.empty() ? names_in_front(f.message) : std::vector{call})
    if (f.marks = call_marks(f.source, name); !f.marks.empty()) return;
}

}  // namespace feder::cli
