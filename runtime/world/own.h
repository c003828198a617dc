// Private members of a world that need private headers.
#pragma once
#include "base/jobs.h"
#include "base/rng.h"
#include "feder/world.h"

namespace feder {

struct World::Own {
  Own(const WorldDesc& desc, Store& store) : jobs(desc.threads), scratch(store.arena("scratch")), rng(desc.seed) {}
  JobPool jobs;
  Scratch scratch;
  Rng rng;
};

}  // namespace feder
