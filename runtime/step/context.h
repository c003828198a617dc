// What a row gets to see of the step it runs in.
#pragma once
#include "base/arena.h"
#include "base/jobs.h"
#include "state/events.h"
#include "state/objects.h"
#include "step/store.h"

namespace feder {

struct StepContext {
  Real dt = 0;  // s, the whole step
  Real h = 0;   // s, one substep: dt / substeps
  int substeps = 1;
  int substep = 0;         // 0 .. substeps-1 inside the inner plan
  std::uint64_t step = 0;  // steps done before this one
  double time = 0;         // s, simulated, at the start of the step
  int dimension = 3;
  bool sleeping = true;         // bodies may fall asleep
  Vec3 gravity = Vec3::Zero();  // m/s^2
  Store* store = nullptr;
  Objects* objects = nullptr;
  Events* events = nullptr;
  JobPool* jobs = nullptr;
  Scratch* scratch = nullptr;
};

}  // namespace feder
