// A folder with scene files, and a LiveScene on one of them, stepped without a clock.
#pragma once
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "feder/profile.h"
#include "support/catch.h"
#include "view/live_scene.h"

namespace feder::test {

class SceneFolder {
 public:
  SceneFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "feder_live_XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  ~SceneFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  SceneFolder(const SceneFolder&) = delete;
  SceneFolder& operator=(const SceneFolder&) = delete;

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline double now() { return static_cast<double>(clock_nanoseconds()) * 1e-9; }

inline view::LiveOptions live_options() {
  view::LiveOptions options;
  options.host.library_roots = {FEDER_SOURCE_DIR "/scripts"};
  options.host.print = [](std::string_view) {};
  options.max_stride = 1;  // a busy machine records every step, too
  return options;
}

// Runs to a step count, however long that takes.
inline void run_to(view::LiveScene& live, std::uint64_t step) {
  live.stop_at(step);
  live.set_paused(false);
  for (int i = 0; i < 100000 && (!live.stopped() || live.catching_up() || live.in_past()); ++i)
    live.tick(1.0 / 60, now());
  REQUIRE(live.world_step() == step);
}

// The hash of a file's scene after some steps, without any viewer.
inline std::uint64_t plain_hash(const std::filesystem::path& file, std::uint64_t steps) {
  lua::HostOptions host = live_options().host;
  lua::Script script(host);
  script.load_file(file);
  script.build();
  for (std::uint64_t i = 0; i < steps; ++i) script.step();
  return script.world()->hash();
}

// Crates, a net, and a script with a memory of its own: timers, random numbers, variables, things made and destroyed.
inline const char* const kBusyScene = R"(local feder = require "feder"
local count = feder.param("count", 3, { min = 1, max = 10 })
return feder.scene {
  title = "Busy", seconds = 4,
  build = function(world, scene)
    world:body { name = "ground", type = "static", shape = feder.plane() }
    for i = 1, count do
      world:body { name = "crate" .. i, shape = feder.box(1, 1, 1), position = { 0, i * 1.2, 0 } }
    end
    world:net { name = "rope", points = { { 3, 3, 0 }, { 3.5, 3, 0 }, { 4, 3, 0 } }, masses = 0.1,
                springs = { { 1, 2, stiffness = 200, damping = 1 }, { 2, 3, stiffness = 200, damping = 1 } } }:pin(1)
    local thrown = 0
    world:every(0.2, function()
      thrown = thrown + 1
      local ball = world:body { name = "ball" .. thrown, shape = feder.sphere(0.2),
                                position = { -4 + math.random(), 2, 0 }, velocity = { 5 + thrown, 0, math.random() } }
      if thrown > 2 then world:find("ball" .. (thrown - 2)):destroy() end
    end)
    world:task(function()
      while true do
        feder.wait(0.33)
        world:find("crate1"):apply_impulse(0, 300, 0)
      end
    end)
    world:on("hit", { min_speed = 1 }, function(e) e.b:apply_impulse(0, 1 + thrown, 0) end)
  end,
}
)";

}  // namespace feder::test
