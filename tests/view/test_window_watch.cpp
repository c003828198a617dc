// Saved files are noticed once, by inotify and by polling; what did not change is not.
#include <unistd.h>

#include "live.h"
#include "view/file_watch.h"

using namespace feder;
namespace fs = std::filesystem;

namespace {
// Seconds until the change is noticed; negative when it is not within `limit`.
double wait_for_change(view::FileWatch& watch, double limit) {
  const double start = test::now();
  while (test::now() - start < limit) {
    if (watch.changed(test::now())) return test::now() - start;
    usleep(5000);
  }
  return -1;
}
}  // namespace

TEST_CASE("a saved file is noticed in time", "[view][watch]") {
  const bool polling = GENERATE(false, true);
  CAPTURE(polling);
  const test::SceneFolder folder;
  const fs::path a = folder.write("a.lua", "one"), b = folder.write("b.yaml", "two");
  view::FileWatch watch(polling);
  CHECK(watch.polling() == polling);
  watch.set({a, b, folder / "later.lua"});
  CHECK(wait_for_change(watch, 0.25) < 0);

  folder.write("a.lua", "one more");
  const double seconds = wait_for_change(watch, 2);
  CHECK(seconds >= 0);
  CHECK(seconds < 0.3);
  CHECK(wait_for_change(watch, 0.25) < 0);

  // the same text again, and a file that nobody asked about
  folder.write("b.yaml", "two");
  folder.write("c.lua", "three");
  CHECK(wait_for_change(watch, 0.25) < 0);

  // editors write beside the file and rename
  fs::rename(folder.write("b.tmp", "two more"), b);
  CHECK(wait_for_change(watch, 2) >= 0);

  fs::remove(a);
  CHECK(wait_for_change(watch, 0.25) < 0);
  folder.write("a.lua", "back again");
  CHECK(wait_for_change(watch, 2) >= 0);

  folder.write("later.lua", "now it exists");
  CHECK(wait_for_change(watch, 2) >= 0);
}

TEST_CASE("a save between reading and watching again is not lost", "[view][watch]") {
  const test::SceneFolder folder;
  const fs::path a = folder.write("a.lua", "one");
  view::FileWatch watch;
  watch.set({a});
  folder.write("a.lua", "two");
  CHECK(wait_for_change(watch, 2) >= 0);
  folder.write("a.lua", "three");  // saved while the scene is being built
  watch.set({a});
  CHECK(wait_for_change(watch, 2) >= 0);
}
