// The reference as users meet it: every page says what it is, every example runs, every form of it is whole.
#include <map>
#include <regex>
#include <set>

#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;
using Json = nlohmann::json;

namespace {

const Json& pages() {
  static const Json all = Program().run("doc --json").json();
  return all;
}

std::set<std::string> matches(const std::string& text, const char* pattern) {
  std::set<std::string> out;
  const std::regex expression(pattern);
  for (std::sregex_iterator m(text.begin(), text.end(), expression), end; m != end; ++m) out.insert((*m)[1]);
  return out;
}

// Arguments in a signature: those in parentheses, a table in braces as one.
std::size_t arity(std::string signature) {
  signature = signature.substr(0, signature.find(" -> "));
  const std::size_t open = signature.find_first_of("({");
  if (open == std::string::npos || signature[open + 1] == ')') return 0;
  std::size_t count = 1;
  int depth = 0;
  for (const char c : signature.substr(open)) {
    depth += c == '(' || c == '{' ? 1 : c == ')' || c == '}' ? -1 : 0;
    count += c == ',' && depth == 1 && signature[open] == '(';
  }
  return count;
}

}  // namespace

TEST_CASE("every page has a title of its own and says what it is, and so does every row", "[cli][doc]") {
  CHECK(pages().size() > 200);
  std::set<std::string> titles;
  for (const Json& page : pages()) {
    const std::string title = page["title"];
    CAPTURE(title);
    CHECK(titles.insert(title).second);
    CHECK(page["text"] != "");
    CHECK(page["signature"] != "");
    for (const Json& row : page["rows"]) {
      CAPTURE(row["name"].get<std::string>());
      CHECK(row["text"] != "");
      CHECK((page["owner"] == "command" || row["type"] != ""));
    }
  }
}

TEST_CASE("feder doc answers with every option or field, unit and default", "[cli][doc]") {
  const Program p;
  const Outcome cloth = p.run("doc cloth");
  CHECK(cloth.status == 0);
  for (const char* word : {"world:cloth{", "area_density", "kg/m2", "0.2", "cloth:attach", "tear_strain"})
    CHECK_THAT(cloth.out, Catch::Contains(word));
  CHECK_THAT(p.run("doc world:joint").out,
             Catch::Contains("max_force") && Catch::Contains("N m") && Catch::Contains("hertz"));
  CHECK_THAT(p.run("doc hit").out,
             Catch::Contains("e.speed") && Catch::Contains("m/s") && Catch::Contains("filter.min_speed"));
  CHECK_THAT(p.run("doc run").out, Catch::Contains("--seconds"));
  CHECK_THAT(p.run("doc density").out, Catch::Contains("world:body{") && Catch::Contains("world:fluid{"));
  CHECK_THAT(p.run("doc World.Joint").out, Catch::Contains("world:joint{"));  // as one remembers it
  const Outcome unknown = p.run("doc clooth");
  CHECK(unknown.status == 1);
  CHECK_THAT(unknown.err, Catch::Contains("nothing about 'clooth'; did you mean 'cloth'?"));
}

TEST_CASE("every example of the reference runs", "[cli][doc]") {
  const std::string text = read_file(FEDER_SOURCE_DIR "/bindings/lua/examples.lua");
  const std::string opening = text.substr(0, text.find("\n--: "));
  const Program p;
  int count = 0;
  for (const Json& page : pages()) {
    const std::string example = page["example"];
    if (example.empty()) continue;
    const bool scene = example.starts_with("return");
    p.write("example.lua", scene ? "local feder = require \"feder\"\n" + example : opening + "\n" + example);
    const Outcome out = p.run(std::string(scene ? "test" : "run --quiet") + " example.lua");
    CAPTURE(page["title"].get<std::string>(), out.err);
    CHECK(out.status == 0);
    ++count;
  }
  // each has its page
  CHECK(count == static_cast<int>(matches(text, "\n--: ([^\n]+)").size()));
  CHECK(count >= 35);
}

TEST_CASE("the page to search has a place for every link", "[cli][doc]") {
  const Program p;
  REQUIRE(p.run("doc --html out").status == 0);
  const std::string html = p.read("out/index.html");
  const std::set<std::string> targets = matches(html, "href=\"#([^\"]+)\""), places = matches(html, "id=\"([^\"]+)\"");
  CHECK(targets.size() == pages().size());
  for (const std::string& target : targets) CHECK(places.count(target));
  CHECK(matches(html, "(https?://[^\"< ]+)").empty());  // it loads nothing
}

TEST_CASE("stubs have every function with its arguments and a type for each of them", "[cli][doc]") {
  const std::string stubs = Program().run("doc --luacats").out;
  CHECK(stubs.find("unknown") == std::string::npos);
  std::map<std::string, std::string> arguments;
  const std::regex expression("\nfunction ([a-z_]+[.:][a-z_]+)\\(([^)]*)\\) end");
  for (std::sregex_iterator m(stubs.begin(), stubs.end(), expression), end; m != end; ++m) arguments[(*m)[1]] = (*m)[2];
  for (const Json& page : pages()) {
    if (page["owner"] == "command" || page["owner"] == "options" || page["owner"] == "yaml" ||
        (page["owner"] == "event" && page["title"] != "event:copy"))
      continue;
    const std::string title = page["title"];
    CAPTURE(title, page["signature"].get<std::string>());
    REQUIRE(arguments.count(title));
    const std::string& list = arguments[title];
    const auto count = list.empty() ? 0 : static_cast<std::size_t>(std::count(list.begin(), list.end(), ',')) + 1;
    CHECK(count == arity(page["signature"]));
  }
  const Program p;  // and they are Lua
  p.write("stubs.lua", stubs);
  CHECK(p.run("check stubs.lua").err.find("stubs.lua:") == std::string::npos);
}

TEST_CASE("man page and completion of shells have every option of every command", "[cli][doc]") {
  const Program p;
  const std::string man = p.run("doc --man").out, bash = p.run("doc --completion bash").out,
                    zsh = p.run("doc --completion zsh").out, fish = p.run("doc --completion fish").out;
  for (const Json& page : pages()) {
    if (page["owner"] != "command") continue;
    for (const Json& row : page["rows"]) {
      const std::string name = row["name"];
      const std::size_t at = name.find("--");
      if (at == std::string::npos) continue;
      const std::string word = name.substr(at, name.find(',', at) - at);
      CAPTURE(name, word);
      CHECK(bash.find(word) != std::string::npos);
      CHECK(zsh.find("'" + word + "[") != std::string::npos);
      CHECK(fish.find("-l " + word.substr(2)) != std::string::npos);
      std::string dashes;
      for (const char c : word) dashes += c == '-' ? std::string("\\-") : std::string(1, c);
      CHECK(man.find(dashes) != std::string::npos);
    }
  }
  p.write("completion.bash", bash);
  const char* const first =
      "bash -c 'source ./completion.bash; COMP_WORDS=(feder ru) COMP_CWORD=1; _feder; test ${COMPREPLY[0]} = run'";
  CHECK(p.shell(first).status == 0);
  CHECK(p.run("doc --completion tcsh").status == 2);
}

TEST_CASE("feder repl runs lines, goes on where one is not whole, and steps a scene", "[cli][repl]") {
  const Program p;
  const auto typed = [&](const std::string& text, const std::string& scene = "") {
    p.write("lines.txt", text);
    return p.shell("export S; sh -c '" FEDER_BINARY_DIR "/feder repl " + scene + " < lines.txt'");
  };
  const Outcome plain = typed(
      "ball = world:body { shape = feder.sphere(1),\n  position = { 0, 5, 0 } }\nworld:step(60)\n"
      "ball:position()\n1 + 1\n");
  CHECK(plain.status == 0);
  CHECK_THAT(plain.out, Catch::Contains("2\n"));
  const Outcome wrong = typed("world:bdy {}\nprint('goes on')\n");
  CHECK(wrong.status == 1);
  CHECK_THAT(wrong.err, Catch::Contains("did you mean 'body'"));
  CHECK_THAT(wrong.out, Catch::Contains("goes on"));
  const Outcome scene = typed(".step 60\nworld:time()\n.doc hit\n.check\n.quit\n", "$S/rigid/tower.lua");
  CHECK_THAT(scene.out, Catch::Contains("1 s") && Catch::Contains("e.speed") && Catch::Contains("checks passed"));
  CHECK(typed("for i = 1, 2 do\n").status == 1);
}
