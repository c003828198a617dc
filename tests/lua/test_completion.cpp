// What Tab offers behind a line.
#include <algorithm>

#include "lua/completion.h"
#include "support/script.h"

using namespace feder;

namespace {

std::vector<std::string> offered(const std::string& line) {
  static const std::vector<lua::ReferencePage> pages = lua::reference(lua::parts(), catalog());
  const lua::Completion c = lua::complete(pages, line);
  for (const std::string& w : c.words) CHECK(w.starts_with(line.substr(c.from)));
  return c.words;
}

bool offers(const std::string& line, const std::string& word) {
  const std::vector<std::string> words = offered(line);
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace

TEST_CASE("a line is completed by what may stand there", "[lua][reference]") {
  CHECK(offered("world:bo") == std::vector<std::string>{"bodies", "body"});
  CHECK(offered("feder.sp") == std::vector<std::string>{"sphere"});
  CHECK(offers("world:find(\"wheel\"):pos", "position"));
  CHECK_FALSE(offers("world:find(\"wheel\"):", "raycast"));
  CHECK(offered("world:body { fri") == std::vector<std::string>{"friction ="});
  CHECK(offered("local door = world:joint{ type = \"hinge\", limits = { 0, 1 }, mot") ==
        std::vector<std::string>{"motor ="});
  CHECK(offers("world:joint { motor = { ", "max_force ="));
  CHECK_FALSE(offers("world:joint { motor = { ", "anchor ="));
  CHECK(offered("world:on(\"sensor_") == std::vector<std::string>{"sensor_enter", "sensor_leave"});
  CHECK(offers("world:on(\"hit\", function(e) print(e.sp", "speed"));
  CHECK(offered("wor") == std::vector<std::string>{"world"});
  CHECK(offered("world:body { name = \"fri").empty());  // the inside of a text is one's own
  CHECK(offered("nothing:like.this").empty());
}
