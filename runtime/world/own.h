// Private members of a world that need private headers.
#pragma once
#include "base/jobs.h"
#include "base/rng.h"
#include "feder/world.h"

namespace feder {

struct World::Own {
  Own(const WorldDesc& desc, const Executor& executor, Store& store)
      : jobs(executor.call ? std::make_shared<JobPool>(executor) : std::make_shared<JobPool>(desc.threads)),
        scratch(store.arena("scratch")), rng(desc.seed) {}
  std::shared_ptr<JobPool> jobs;  // helpers of an executor may outlive the world
  Scratch scratch;
  Rng rng;
};

}  // namespace feder
