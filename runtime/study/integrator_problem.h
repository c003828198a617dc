// Problems that every integrator runs: their methods and ladders, and what an integrator reports. Private to the
// module.
#pragma once
#include "base/rng.h"
#include "integrate/integrator.h"
#include "study/options.h"
#include "study/reference.h"

namespace feder {

class IntegratorProblem : public StudyProblem {
 public:
  // `finest_tolerance`: of adaptive methods in a double build.
  IntegratorProblem(const char* family, int tolerance_steps, double finest_tolerance)
      : tolerance_steps_(tolerance_steps), finest_tolerance_(sizeof(Real) == 4 ? 1e-6 : finest_tolerance) {
    info_.family = family;
  }
  std::vector<MethodInfo> methods() const override;
  std::vector<RunSpec> ladder(const MethodInfo& method) const override;
  bool has_twins() const override { return true; }

 protected:
  std::vector<int> steps_, implicit_steps_;  // of the ladder, coarse to fine; implicit_steps_ empty: as the others
  int tolerance_steps_;                      // calls adaptive methods get

 private:
  double finest_tolerance_;
};

// first, 2 first, 4 first ... `rungs` of them.
std::vector<int> doubling(int first, int rungs);

// One to four last places away, in each coordinate that is not 0.
Vec3 nearby(const Vec3& x, Rng& rng);

std::unique_ptr<Integrator> make_integrator(Arena& arena, const RunSpec& spec);
StudyCounters counters_of(const IntegratorStats& stats, bool adaptive, std::int64_t steps);

}  // namespace feder
