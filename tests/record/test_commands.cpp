// Commands: every edit that the public headers offer is kept by the command log and can be done again by its name; a
// world of random edits is the same in its replay.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "feder/record.h"
#include "feder/rigid.h"
#include "record/commands.h"
#include "support/catch.h"

using namespace feder;
namespace fs = std::filesystem;

namespace {

std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::set<std::string> all_matches(const std::string& text, const std::string& pattern) {
  std::set<std::string> found;
  const std::regex r(pattern);
  for (std::sregex_iterator i(text.begin(), text.end(), r), end; i != end; ++i) found.insert((*i)[1]);
  return found;
}

}  // namespace

TEST_CASE("what is logged can be done again, and nothing else", "[record][commands]") {
  std::string sources;
  for (const auto& entry : fs::recursive_directory_iterator(FEDER_SOURCE_DIR "/runtime"))
    if (entry.path().extension() == ".cpp") sources += text_of(entry.path());
  const std::set<std::string> logged = all_matches(sources, R"re(const Command command\([^"]*"([a-z_.]+)")re");
  const std::vector<std::string> known = command_names();
  CHECK(logged.size() > 70);
  CHECK(logged == std::set<std::string>(known.begin(), known.end()));
}

TEST_CASE("every method of a system that changes it is a command", "[record][commands]") {
  // those that steps, couplings or queries call, or that read
  const std::set<std::string> others = {"descriptor",
                                        "add_passes",
                                        "load",
                                        "held",
                                        "drive",
                                        "colliders",
                                        "contacts",
                                        "raycast",
                                        "boundary",
                                        "raycast_all",
                                        "overlap",
                                        "densities",
                                        "shape_cast",
                                        "clear_contact_states",
                                        "forget",
                                        "removed",
                                        "set_load",
                                        "pool_at",
                                        "surface",
                                        "pressures",
                                        "density_error",
                                        "pressure_at",
                                        "height_at",
                                        "set_impact",
                                        "set_beside_body",
                                        "push",
                                        "sample",
                                        "clumping",
                                        "carry"};
  struct Header {
    const char *file, *system;
  };
  const std::vector<std::string> known = command_names();
  for (const Header& h :
       {Header{"rigid.h", "rigid"}, Header{"net.h", "springs"}, Header{"cloth.h", "cloth"}, Header{"rope.h", "rope"},
        Header{"soft.h", "soft"}, Header{"fluid.h", "fluid"}, Header{"query.h", "collide"}}) {
    CAPTURE(h.file);
    std::string text = text_of(fs::path(FEDER_SOURCE_DIR "/runtime/include/feder") / h.file);
    const std::size_t begin = text.find(" final : public System");
    REQUIRE(begin != std::string::npos);
    text = std::regex_replace(text.substr(begin, text.find(" private:", begin) - begin), std::regex(R"(//[^\n]*)"), "");
    // members that end in `);` or `override;`, without const
    int found = 0;
    const std::regex method(R"(\n  [A-Za-z_:<>0-9&*, ]*?[&* ]([a-z_]+)\(([^;{]*)\)( const)?( override)?;)");
    for (std::sregex_iterator i(text.begin(), text.end(), method), end; i != end; ++i) {
      const std::string name = (*i)[1];
      if ((*i)[3].matched || others.count(name)) continue;
      CAPTURE(name);
      ++found;
      CHECK(std::find(known.begin(), known.end(), std::string(h.system) + "." + name) != known.end());
    }
    CHECK(found >= 4);
  }
}

TEST_CASE("a command that fails, and what a command calls, are not kept", "[record][commands]") {
  std::string bytes;
  {
    World world(WorldDesc{}, catalog());
    Recorder recorder([&](std::string_view more) { bytes += more; }, {});
    recorder.add(world);
    Rigid& rigid = world.need<Rigid>();
    BodyDesc body;
    body.name = "ball";
    CHECK_THROWS_AS(rigid.add_body(body), SceneError);  // no shape
    body.shape = make_sphere(1);
    const ObjectId ball = rigid.add_body(body);
    CHECK_THROWS_AS(rigid.set_velocity(ball, Vec3(NAN, 0, 0)), SceneError);
    CHECK_THROWS_AS(rigid.set_velocity(ObjectId{77, 1}, Vec3(1, 0, 0)), SceneError);
    rigid.set_velocity(ball, Vec3(1, 0, 0));
    world.step();
    rigid.destroy_body(ball, "here");
    recorder.finish("finished");
  }
  const Recording recording(bytes);
  REQUIRE(recording.world_count() == 1);
  CHECK(recording.steps(0) == 1);
  CHECK(recording.how() == "finished");
  Replay replay(recording, 0, catalog());
  std::vector<RecordedCommand> list;
  std::vector<std::string> names;
  while (replay.step(&list))
    for (const RecordedCommand& c : list) names.push_back(c.name);
  CHECK(names == std::vector<std::string>{"world.need_system", "rigid.add_body", "rigid.set_velocity"});
  REQUIRE(list.size() == 1);
  CHECK(list[0].text == "rigid.destroy_body body \"ball\", \"here\"");
  CHECK(replay.same());
  CHECK(!replay.step());
}
