// A host that lists two systems; run.cmake looks into the program that nothing of the others was linked.
#include <collide/collide.h>
#include <rigid/rigid.h>
#include <world/world.h>

#include <cstdio>

int main() {
  const feder::SystemDescriptor* const catalog[] = {&feder::Collide::descriptor(), &feder::Rigid::descriptor()};
  feder::World world(feder::WorldDesc{}, catalog);
  world.need<feder::Rigid>();
  world.step();
  std::printf("lean: %zu systems, time %.4f s\n", world.report().size(), world.time());
  return 0;
}
