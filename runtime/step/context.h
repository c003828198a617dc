// What a pass gets to see of the step it runs in.
#pragma once
#include <span>

#include "base/arena.h"
#include "base/jobs.h"
#include "state/events.h"
#include "state/objects.h"
#include "step/order.h"
#include "step/store.h"

namespace feder {

// How often a loop of solver substeps runs: one count per group, written before the loop by a pass of its system. A
// group runs its whole loop before the next.
struct LoopCounts {
  std::vector<int> count;  // by group
};

// Where an inner loop is.
struct InnerLoop {
  int group = 0;
  int index = 0;  // of the iteration, from 0
  int count = 1;  // iterations of this group
  bool last() const { return index + 1 == count; }
};

struct StepContext {
  Real dt = 0;  // s, the whole step
  Real h = 0;   // s, one substep: dt / substeps
  int substeps = 1;
  int substep = 0;         // 0 .. substeps-1 inside the substep loop
  InnerLoop inner;         // inside a loop of solver substeps
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
  LoopCounts* loops = nullptr;  // by Loop

  LoopCounts& counts(Loop loop) const { return loops[static_cast<int>(loop)]; }
};

}  // namespace feder
