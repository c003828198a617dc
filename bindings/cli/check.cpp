// feder check: finds mistakes without running a scene: syntax, and names that neither `feder` nor a world has.
// It reads words, not meanings: `feder.name` and `world:name(` outside comments and strings. What the names are, the
// binding itself is asked.
#include <algorithm>
#include <cstdio>
#include <map>
#include <set>
#include <sstream>

#include "cli/command.h"
#include "cli/session.h"
#include "report/json.h"

namespace feder::cli {
namespace {

struct Finding {
  int line;
  std::string message;
};

bool is_word(char c) { return c == '_' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

// Length of "[[", "[=[" ... at `at`, or 0.
std::size_t long_bracket(const std::string& s, std::size_t at) {
  if (s[at] != '[') return 0;
  std::size_t end = at + 1;
  while (end < s.size() && s[end] == '=') ++end;
  return end < s.size() && s[end] == '[' ? end + 1 - at : 0;
}

// Lua source with comments and strings replaced by blanks; line ends stay.
std::string code_only(std::string s) {
  const auto blank = [&s](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to && i < s.size(); ++i)
      if (s[i] != '\n') s[i] = ' ';
  };
  for (std::size_t i = 0; i < s.size();) {
    const bool comment = s.compare(i, 2, "--") == 0;
    const std::size_t text = comment ? i + 2 : i;
    std::size_t end = i + 1;
    if (const std::size_t open = text < s.size() ? long_bracket(s, text) : 0) {
      std::string close(open, '=');  // as long as the opening one
      close.front() = close.back() = ']';
      end = s.find(close, text + open);
      end = end == std::string::npos ? s.size() : end + close.size();
    } else if (comment) {
      end = s.find('\n', i);
      if (end == std::string::npos) end = s.size();
    } else if (s[i] == '"' || s[i] == '\'') {
      while (end < s.size() && s[end] != s[i] && s[end] != '\n') end += s[end] == '\\' ? 2 : 1;
      ++end;
    } else {
      ++i;
      continue;
    }
    blank(i, end);
    i = end;
  }
  return s;
}

// The words after `prefix` ("feder.", "world:") and the lines they stand in.
std::vector<std::pair<int, std::string>> words_after(const std::string& code, const std::string& prefix) {
  std::vector<std::pair<int, std::string>> found;
  int line = 1;
  for (std::size_t i = 0; i < code.size(); ++i) {
    if (code[i] == '\n') ++line;
    const bool starts = code.compare(i, prefix.size(), prefix) == 0 &&
                        (i == 0 || (!is_word(code[i - 1]) && code[i - 1] != '.' && code[i - 1] != ':'));
    if (!starts) continue;
    std::size_t end = i + prefix.size();
    while (end < code.size() && is_word(code[end])) ++end;
    if (end > i + prefix.size()) found.emplace_back(line, code.substr(i + prefix.size(), end - i - prefix.size()));
  }
  return found;
}

// Asks the binding itself: what it says about looking up each of the words in `object`, a Lua expression. Empty for the
// words that are there.
std::map<std::string, std::string> ask(const Options& options, const std::string& object,
                                       const std::set<std::string>& words) {
  std::string script = "local object = " + object + R"(
local function ask(word)
  local found, value = pcall(function() return object[word] end)
  if not found then print(word, (tostring(value):gsub('^[^:]*:%d+: ', '')))
  elseif value == nil then print(word, '') end
end
if type(object) == 'table' then for name in pairs(object) do print('', name) end end
)";
  for (const std::string& word : words) script += fmt::format("ask '{}'\n", word);
  std::string text;
  lua::HostOptions host = host_options(options);
  host.set.clear();
  host.world.clear();
  host.print = [&text](std::string_view more) { text += more; };
  lua::Script(std::move(host)).load_string(script, "check");
  std::map<std::string, std::string> answers;
  std::vector<std::string> known;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const std::size_t tab = line.find('\t');
    if (tab == 0)
      known.push_back(line.substr(1));
    else if (tab != std::string::npos)
      answers[line.substr(0, tab)] = line.substr(tab + 1);
  }
  for (auto& [word, answer] : answers) {
    if (!answer.empty()) continue;
    answer = fmt::format("there is no '{}'{}", word, did_you_mean("; ", word, known));
  }
  return answers;
}

class Check final : public Command {
 public:
  void declare(Arguments& a) override {
    a.list("SCENE", scenes_, "one or more .lua or .yaml files");
    a.require("SCENE");
  }

  int run(const Options& options) override {
    report::Json all = report::Json::array();
    int findings = 0;
    for (const std::string& scene : scenes_) {
      for (const Finding& f : check(scene, options)) {
        ++findings;
        all.push_back({{"file", scene}, {"line", f.line}, {"message", f.message}});
        if (!options.json) fmt::print(stderr, "{}:{}: {}\n", scene, f.line, f.message);
      }
    }
    if (options.json) {
      print_json({{"files", scenes_.size()}, {"findings", all}});
    } else if (!options.quiet && findings == 0) {
      fmt::print("{} file{}: nothing found\n", scenes_.size(), scenes_.size() == 1 ? "" : "s");
    }
    return findings ? kFailed : kPass;
  }

 private:
  static std::vector<Finding> check(const std::string& scene, const Options& options) {
    check_syntax(scene, {});
    std::vector<Finding> findings;
    if (is_yaml(scene)) return findings;
    const std::string code = code_only(read_text(scene));
    check_words(code, "feder.", "require 'feder'", options, findings);
    check_words(code, "world:", "require 'feder'.world {}", options, findings);
    std::ranges::stable_sort(findings, [](const Finding& a, const Finding& b) { return a.line < b.line; });
    return findings;
  }

  static void check_words(const std::string& code, const std::string& prefix, const std::string& object,
                          const Options& options, std::vector<Finding>& findings) {
    const auto used = words_after(code, prefix);
    if (used.empty()) return;
    std::set<std::string> words;
    for (const auto& [line, word] : used) words.insert(word);
    const auto answers = ask(options, object, words);
    for (const auto& [line, word] : used)
      if (const auto answer = answers.find(word); answer != answers.end()) findings.push_back({line, answer->second});
  }

  std::vector<std::string> scenes_;
};

}  // namespace

Row cli_check() { return command_row<Check>("check", "looks for mistakes without running: syntax and unknown names"); }

}  // namespace feder::cli
