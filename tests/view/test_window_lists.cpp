// What the panels show, without drawing it: the scene picker's list, curves, rows of time.
#ifdef FEDER_HAS_WINDOW
#include "live.h"
#include "view/sampler.h"
#include "view/scene_list.h"

using namespace feder;

TEST_CASE("the picker lists the scenes beside a scene and finds words in them", "[view][picker]") {
  const auto list = view::scenes_beside(FEDER_SOURCE_DIR "/scenes/rigid/tower.lua");
  const auto find = [&](const std::string& name) {
    for (const auto& e : list)
      if (e.name == name) return &e;
    return static_cast<const view::SceneEntry*>(nullptr);
  };
  REQUIRE(find("rigid/tower"));
  CHECK(find("rigid/tower")->title == "Tower");
  CHECK(find("yaml/tower"));
  CHECK(find("springs/jelly"));
  CHECK(view::matches(*find("rigid/tower"), "TOW rig"));
  CHECK_FALSE(view::matches(*find("rigid/tower"), "tow springs"));
  CHECK(view::matches(*find("rigid/tower"), ""));

  // no folder called scenes: the file's own; files that are no scenes are left out
  const test::SceneFolder folder;
  folder.write("part.lua", "return {}");
  const auto file = folder.write("busy.lua", test::kBusyScene);
  const auto own = view::scenes_beside(file);
  REQUIRE(own.size() == 1);
  CHECK(own[0].name == "busy");
  CHECK(own[0].title == "Busy");
}

TEST_CASE("curves and times follow the scene", "[view][sampler]") {
  const test::SceneFolder folder;
  view::LiveScene live(test::live_options());
  REQUIRE(live.open(folder.write("busy.lua", test::kBusyScene)));
  view::Sampler sampler;
  for (std::uint64_t step = 0; step <= 60; ++step) {
    test::run_to(live, step);
    sampler.sample(live, true);
  }
  const auto& energy = sampler.curves()[0].points();
  REQUIRE(energy.size() == 61);
  const Energy e = live.world().energy();
  CHECK(energy.back().value == Approx(e.kinetic + e.potential + e.elastic));
  CHECK(energy.back().time == Approx(1));
  bool lua = false, row = false;
  for (const view::TimeRow& r : sampler.rows()) {
    lua = lua || (r.detail == "Lua" && r.label.find("busy.lua:") != std::string::npos);
    row = row || (r.detail == "collide" && r.ms > 0);
  }
  CHECK(lua);
  CHECK(row);
  // another world: the old curves go
  live.restart();
  sampler.sample(live, true);
  CHECK(sampler.curves()[0].points().size() == 1);
}
#endif
