// feder repl: Lua, line by line, in a world of its own or in a scene between two steps. A line that is not whole goes
// on in the next one. On a terminal with line editing where libedit is there: history, and Tab completes.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <iostream>

#include "cli/command.h"
#include "cli/doc_pages.h"
#include "cli/session.h"
#include "cli/stop.h"
#include "lua/completion.h"

#ifdef FEDER_HAS_EDIT
#include <editline/readline.h>
#endif

namespace feder::cli {
namespace {

constexpr const char* kHelp =
    "Lua: world, feder and, of a scene, scene are there; an expression prints its value.\n"
    "  .step [N]   N steps of a scene (1); without a scene world:step(N) does\n"
    "  .check      the scene's check, now\n"
    "  .doc WORD   what the reference says of it\n"
    "  .quit       or the end of input\n";

#ifdef FEDER_HAS_EDIT
const Pages* completed_pages = nullptr;  // libedit's callbacks carry nothing of their own

char** complete_line(const char* word, int, int end) {
  const std::string line(rl_line_buffer, static_cast<std::size_t>(end));
  const lua::Completion found = lua::complete(*completed_pages, line);
  rl_attempted_completion_over = 1;
  rl_completion_append_character = '\0';
  if (found.words.empty()) return nullptr;
  // what stands between libedit's word and ours is kept
  const std::size_t start = line.size() - std::char_traits<char>::length(word);
  const std::string kept = line.substr(std::min(start, found.from), found.from - std::min(start, found.from));
  const bool many = found.words.size() > 1;
  char** const list = static_cast<char**>(std::calloc(found.words.size() + 2, sizeof(char*)));
  std::size_t n = 0;
  list[n++] = strdup((kept + found.common()).c_str());
  for (const std::string& w : found.words)
    if (many) list[n++] = strdup((kept + w).c_str());
  return list;
}
#endif

class Repl final : public Command {
 public:
  void declare(Arguments& a) override { a.text("SCENE", scene_, "a .lua or .yaml file (default: an empty world)"); }

  int run(const Options& options) override {
    const StopSignals signals;
    pages_ = all_pages(options.build);
    const bool terminal = isatty(STDIN_FILENO) != 0;
    open(options);
    if (terminal && !options.quiet) fmt::print("feder {}: .help lists what there is beside Lua\n", FEDER_VERSION);
    std::string text, line;
    while (read_line(terminal, text.empty() ? "> " : ">> ", line)) {
      if (text.empty() && line.starts_with(".")) {
        if (line == ".quit" || line == ".exit") break;
        command(line);
      } else if (!(text += line).empty()) {
        if (!evaluate(text))
          text += '\n';
        else
          text.clear();
      }
      if (!session_->goes_on()) return session_->end_status();
    }
    if (!text.empty()) return print_error("feder repl: the last lines are not whole"), kFailed;
    // a script on standard input has failed when one of its lines has
    return failed_ && !terminal ? kFailed : kPass;
  }

 private:
  void open(const Options& options) {
    lua::HostOptions host = host_options(options);
    host.print = [](std::string_view said) { std::fwrite(said.data(), 1, said.size(), stdout); };
    session_ = std::make_unique<Session>(std::move(host), [](const std::string& error) { print_error(error); });
    if (!scene_.empty())
      session_->load(scene_);
    else
      session_->script().load_string("feder = require 'feder'; world = feder.world {}", "repl");
  }

  bool read_line(bool terminal, const char* prompt, std::string& line) {
#ifdef FEDER_HAS_EDIT
    if (terminal) {
      completed_pages = &pages_;
      rl_attempted_completion_function = complete_line;
      char* const got = readline(prompt);
      if (!got) return false;
      line = got;
      if (!line.empty()) add_history(got);
      std::free(got);
      return true;
    }
#endif
    if (terminal) fmt::print("{}", prompt), std::fflush(stdout);
    return static_cast<bool>(std::getline(std::cin, line));
  }

  // False when the text goes on in the next line.
  bool evaluate(const std::string& text) {
    try {
      const std::string said = session_->script().run_string(text, "repl");
      if (!said.empty()) fmt::print("{}\n", said);
    } catch (const lua::ScriptError& e) {
      if (std::string_view(e.what()).ends_with("near <eof>")) return false;
      report(e.what());
    }
    std::fflush(stdout);
    return true;
  }

  void command(const std::string& line) {
    const std::string word = line.substr(0, line.find(' '));
    const std::string rest = line.size() > word.size() ? line.substr(word.size() + 1) : "";
    try {
      if (word == ".step")
        step(rest.empty() ? 1 : static_cast<int>(read_number(rest, ".step")));
      else if (word == ".check")
        check();
      else if (word == ".doc")
        fmt::print("{}", doc_text(pages_, rest));
      else if (word == ".help")
        fmt::print("{}", kHelp);
      else
        report(fmt::format("feder repl: unknown command '{}'; .help lists them", word));
    } catch (const Failure& e) {
      report(e.what());
    }
  }

  void step(int count) {
    if (!session_->is_scene()) return report("feder repl: no scene; world:step(n) steps a world of your own");
    for (int k = 0; k < count && session_->goes_on(); ++k) session_->step();
    fmt::print("{:.6g} s\n", session_->world()->time());
  }

  void check() {
    if (!session_->is_scene()) return report("feder repl: no scene that has a check");
    const lua::CheckResult result = session_->script().check();
    for (const auto& f : result.failures) report(f.where + ": " + f.message);
    fmt::print("{} checks passed, {} failed\n", result.passed, result.failures.size());
  }

  void report(const std::string& error) {
    failed_ = true;
    print_error(error);
  }

  std::string scene_;
  Pages pages_;
  std::unique_ptr<Session> session_;
  bool failed_ = false;
};

}  // namespace

Row cli_repl() { return command_row<Repl>("repl", "Lua line by line, in an empty world or in a scene"); }

}  // namespace feder::cli
