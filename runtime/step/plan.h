// The step plan: the rows that run, in order. Built when the scene's structure changes, run every step.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "base/profile.h"
#include "step/context.h"
#include "step/stage.h"

namespace feder {

using RowFunction = void (*)(void* self, StepContext& context);

struct StepRow {
  Stage stage = Stage::begin;
  When when = When::each_substep;  // advance and solve only
  int rank = 0;                    // order within a stage; equal ranks run in the order they were added
  const char* name = "";           // "integrate", "find pairs": unique within a system
  const char* system = "";
  RowFunction run = nullptr;
  void* self = nullptr;
  Counter counter;
};

class StepPlan {
 public:
  void clear();
  void add(const StepRow& row);
  // Member function form: plan.add<&Rigid::integrate>(Stage::advance, When::each_substep, 10, "integrate", "rigid",
  // this)
  template <auto Method, class T>
  void add(Stage stage, When when, int rank, const char* name, const char* system, T* self) {
    add(StepRow{
        stage, when, rank, name, system, [](void* s, StepContext& c) { (static_cast<T*>(s)->*Method)(c); }, self, {}});
  }
  void finish();  // sorts; counters of rows that were there before are kept
  void run(StepContext& context);

  std::span<const StepRow> rows() const { return rows_; }
  void reset_counters();

 private:
  std::vector<StepRow> rows_, old_;
};

}  // namespace feder
