// The page "Lua in feder", bindings/lua/README.md: every block of it runs, prints what its comments say behind "-->",
// and ends in the error that it says behind "--> error:", in that line.
#include <fstream>
#include <sstream>

#include "support/script.h"

using namespace feder;
using namespace feder::test;

namespace {

constexpr const char* kName = "page.lua";

// Words with single spaces between: print writes tabs, comments are aligned.
std::string words_of(const std::string& line) {
  std::istringstream in(line);
  std::string out;
  for (std::string word; in >> word;) out += (out.empty() ? "" : " ") + word;
  return out;
}

std::string lines_of(const std::string& text) {
  std::istringstream in(text);
  std::string out;
  for (std::string line; std::getline(in, line);) out += words_of(line) + "\n";
  return out;
}

struct Block {
  int line = 0;  // of the page
  std::string text;
  std::string output;  // what its comments promise
  std::string error;
};

// What the line's comment promises, as the `number`th line of the block.
void read_promise(const std::string& line, int number, Block& block) {
  const std::string arrow = "-->", error = "error: ";
  const std::size_t at = line.find(arrow);
  if (at == std::string::npos) return;
  const std::string said = words_of(line.substr(at + arrow.size()));
  if (said.starts_with(error))
    block.error = kName + (":" + std::to_string(number)) + ": " + said.substr(error.size());
  else
    block.output += said + "\n";
}

std::vector<Block> read_blocks(std::istream& page) {
  std::vector<Block> blocks;
  bool inside = false;
  int number = 0, first = 0;
  for (std::string line; std::getline(page, line);) {
    ++number;
    if (inside && line == "```") {
      inside = false;
    } else if (inside) {
      blocks.back().text += line + "\n";
      read_promise(line, number - first, blocks.back());
    } else if (line == "```lua") {
      inside = true, first = number;
      blocks.emplace_back().line = number;
    }
  }
  return blocks;
}

Ran run_block(const Block& block) {
  Ran ran;
  lua::HostOptions options;
  options.print = [&ran](std::string_view more) { ran.output += more; };
  options.library_roots = {FEDER_SOURCE_DIR "/scripts"};
  lua::Script script(std::move(options));
  try {
    script.load_string(block.text, kName);
  } catch (const lua::ScriptError& e) {
    ran.error = e.what();
  }
  ran.errors = script.handler_errors();
  return ran;
}

}  // namespace

TEST_CASE("every block of the page Lua in feder does what its comments say", "[lua][page]") {
  std::ifstream page(FEDER_SOURCE_DIR "/bindings/lua/README.md");
  REQUIRE(page);
  const std::vector<Block> blocks = read_blocks(page);
  CHECK(blocks.size() >= 20);
  for (const Block& block : blocks) {
    CAPTURE(block.line, block.text);
    CHECK((!block.output.empty() || !block.error.empty()));
    const Ran ran = run_block(block);
    CHECK(lines_of(ran.output) == block.output);
    CHECK(words_of(ran.error) == block.error);
    CHECK(ran.errors.empty());
  }
}

TEST_CASE("a promise of the page that does not hold is seen", "[lua][page]") {
  std::istringstream page("# page\n```lua\nprint(1,  2)  --> 1 2\nerror('x', 2)\nerror 'y'  --> error: y\n```\n");
  const std::vector<Block> blocks = read_blocks(page);
  REQUIRE(blocks.size() == 1);
  CHECK(blocks[0].line == 2);
  CHECK(blocks[0].output == "1 2\n");
  CHECK(blocks[0].error == "page.lua:3: y");
  const Ran ran = run_block(blocks[0]);
  CHECK(lines_of(ran.output) == blocks[0].output);
  CHECK(words_of(ran.error) != blocks[0].error);
}
