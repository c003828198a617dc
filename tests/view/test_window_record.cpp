// The viewer's worlds in a recording: what hands and the console do, looking back, acting in the past and saved files.
#include "feder/record.h"
#include "feder/rigid.h"
#include "live.h"

using namespace feder;

TEST_CASE("what is done in the viewer is played again", "[view][live][record]") {
  const test::SceneFolder folder;
  const auto file = folder.write("busy.lua", test::kBusyScene);
  std::string bytes;
  std::vector<std::uint64_t> last;  // hash of each world in the end
  {
    Recorder recorder([&](std::string_view more) { bytes += more; }, {});
    view::LiveOptions options = test::live_options();
    options.host.made = [&](World& world) { recorder.add(world), recorder.note(world, "script", "text"); };
    view::LiveScene live(options);
    REQUIRE(live.open(file));
    test::run_to(live, 30);
    live.run_text("world:find('crate2'):set_velocity(1, 2, 0)", [](const std::string&, bool good) { CHECK(good); });
    test::run_to(live, 50);
    for (int k = 0; k < 10; ++k) live.step_back();
    live.scrub(20);
    test::run_to(live, 60);
    last.push_back(live.world().hash());
    // a past that is changed is another world
    live.scrub(40);
    live.act([](lua::Script& s) { s.world()->find<Rigid>()->wake_all(WakeCause::script); }, "wake");
    test::run_to(live, 70);
    last.push_back(live.world().hash());
    live.restart();
    test::run_to(live, 20);
    last.push_back(live.world().hash());
    recorder.finish("finished");
  }
  const Recording recording(bytes);
  REQUIRE(recording.world_count() == last.size());
  for (std::size_t k = 0; k < last.size(); ++k) {
    CAPTURE(k);
    Replay replay(recording, k, catalog());
    std::vector<RecordedCommand> commands;
    bool noted = false;
    while (replay.step(&commands))
      for (const RecordedCommand& c : commands) noted = noted || c.name == "note";
    CHECK(replay.same());
    CHECK((k == 0 || replay.world().hash() == last[k]));  // the first ends in the past
    CHECK(noted);
  }
}
