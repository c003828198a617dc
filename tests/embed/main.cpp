// feder in a program of one's own: load a scene, step it, read events.
#include <feder/lua.h>

#include <cstdio>

static const char* const kScene = R"(
local feder = require "feder"
return feder.scene {
  world = { dt = 1 / 120 },
  build = function(world)
    world:body { name = "floor", type = "static", shape = feder.plane() }
    world:body { name = "ball", shape = feder.sphere(0.5), position = { 0, 2, 0 }, restitution = 0.5 }
  end,
})";

int main() try {
  feder::lua::Script script{feder::lua::HostOptions{}};
  script.load_string(kScene, "scene.lua");
  script.build();
  feder::World& world = *script.world();
  for (int i = 0; i < 120; ++i) {
    script.step();
    for (const feder::Event& e : world.events().list())
      if (e.kind == feder::EventKind::contact_begin)
        std::printf("%.3f s: %s meets %s\n", world.time(), world.objects().describe(e.a).c_str(),
                    world.objects().describe(e.b).c_str());
  }
  std::printf("%.3f s: hash %016llx\n", world.time(), static_cast<unsigned long long>(world.hash()));
  return world.is_finite() ? 0 : 1;
} catch (const std::exception& e) {
  return std::fprintf(stderr, "%s\n", e.what()), 1;
}
