// Private members of a world that need private headers.
#pragma once
#include "base/jobs.h"
#include "base/rng.h"
#include "feder/world.h"

namespace feder {

struct World::Own {
  Own(const WorldDesc& desc, const Executor& executor, Store& store)
      : jobs(make_jobs(desc.threads, executor)), scratch(store.arena("scratch")), rng(desc.seed) {}
  static std::shared_ptr<JobPool> make_jobs(int threads, const Executor& executor) {
    if (!executor.call) return std::make_shared<JobPool>(threads);
    const auto call = [call = executor.call](const std::shared_ptr<JobPool>& jobs, int helpers) {
      call(Helper(jobs), helpers);
    };
    return std::make_shared<JobPool>(threads, call);
  }
  std::shared_ptr<JobPool> jobs;  // helpers of an executor may outlive the world
  Scratch scratch;
  Rng rng;
};

}  // namespace feder
