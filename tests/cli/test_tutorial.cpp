// The tutorial, scenes/README.md: every command of its lessons and of its cookbook runs as printed there. A viewer
// needs a display: in its place the scene is checked.
#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

namespace {

struct Command {
  std::string printed, arguments;  // of the feder program
  int status = 0;                  // "# exit status N" behind the command
};

// `scripts/run` and `scripts/gallery` as arguments of the program.
std::string arguments_of(const std::string& line) {
  std::istringstream in(line);
  std::string script, first, rest;
  in >> script >> first;
  std::getline(in, rest, '#');
  if (script == "scripts/gallery") return "render" + rest + " -o " + first;
  if (script != "scripts/run") return "";
  if (first.ends_with(".lua")) return "run " + first + rest;
  return (first == "view" ? "check" : first) + rest;
}

std::vector<Command> commands_of(const std::string& page) {
  const std::size_t begin = page.find("## Ten lessons"), end = page.find("## A scene file");
  std::istringstream in(page.substr(begin, end - begin));
  std::vector<Command> commands;
  bool inside = false;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("```")) {
      inside = !inside;
    } else if (inside) {
      const std::size_t at = line.find("# exit status ");
      commands.push_back({line, arguments_of(line), at == std::string::npos ? 0 : std::stoi(line.substr(at + 14))});
    }
  }
  return commands;
}

}  // namespace

TEST_CASE("every command of the tutorial does what is printed", "[cli][tutorial]") {
  const Program p;
  REQUIRE(p.shell("ln -s \"$S\" scenes && mkdir build").status == 0);
  const std::vector<Command> commands = commands_of(read_file(FEDER_SOURCE_DIR "/scenes/README.md"));
  CHECK(commands.size() >= 30);
  for (const Command& c : commands) {
    CAPTURE(c.printed);
    REQUIRE(!c.arguments.empty());
    const Outcome done = p.run(c.arguments);
    CAPTURE(done.err);
    CHECK(done.status == c.status);
  }
}

TEST_CASE("a lesson is named in the tutorial, and has a check", "[cli][tutorial]") {
  const std::string page = read_file(FEDER_SOURCE_DIR "/scenes/README.md");
  for (const char* folder : {"lessons", "cookbook"}) {
    for (const auto& file : std::filesystem::directory_iterator(std::string(FEDER_SOURCE_DIR "/scenes/") + folder)) {
      const std::string name = std::string(folder) + "/" + file.path().filename().string();
      CAPTURE(name);
      CHECK(page.substr(0, page.find("## A scene file")).find("(" + name + ")") != std::string::npos);
      CHECK(read_file(file.path()).find("\n  check = function") != std::string::npos);
    }
  }
}
