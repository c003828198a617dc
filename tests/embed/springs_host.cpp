// A Lua host that knows nets alone: springs_host SCENE SCRIPTS STEPS prints the hash. run.cmake compares it with the
// program's, which has all systems, and looks into this one that nothing of the others was linked.
#include <feder/parts.h>
#include <feder/systems.h>

#include <cstdio>
#include <cstdlib>

int main(int count, char** words) try {
  if (count != 4) return 2;
  const feder::lua::Part* const parts[] = {&feder::lua::springs_part()};
  const feder::SystemDescriptor* const systems[] = {&feder::springs_system()};
  feder::lua::Script script{feder::lua::HostOptions{.parts = parts, .systems = systems, .library_roots = {words[2]}}};
  script.load_file(words[1]);
  script.build();
  for (int i = std::atoi(words[3]); i > 0; --i) script.step();
  std::printf("\"hash\": \"%016llx\"\n", static_cast<unsigned long long>(script.world()->hash()));
  return 0;
} catch (const std::exception& e) {
  return std::fprintf(stderr, "%s\n", e.what()), 1;
}
