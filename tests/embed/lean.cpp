// A host that lists two systems; run.cmake looks into the program that nothing of the others was linked.
#include <feder/rigid.h>
#include <feder/systems.h>
#include <feder/world.h>

#include <cstdio>

int main() {
  const feder::SystemDescriptor* const catalog[] = {&feder::collide_system(), &feder::rigid_system()};
  feder::World world(feder::WorldDesc{}, catalog);
  world.need<feder::Rigid>();
  world.step();
  std::printf("lean: %zu systems, time %.4f s\n", world.report().size(), world.time());
  return 0;
}
