// Coloured batches of tetrahedra: what the kernels run over. Private to the module.
#pragma once
#include "base/colors.h"
#include "base/jobs.h"
#include "soft/batch.h"
#include "soft/solver.h"

namespace feder {

class SoftBatches {
 public:
  explicit SoftBatches(Arena& a) : arena_(a) {}
  // Wide kernels where the processor has them; "plain" for tests.
  void pick(bool wide);
  // Colours and batches of this mesh; does nothing for the version it has.
  void build(const SoftView& v);
  void current_position(const SoftView& v);  // edges at the start of the step
  // Bound of w^2 of all modes at rest of the whole body, 1/s^2, and of its stiffest tetrahedron alone (of those that
  // make up all but kSpared of the volume).
  double fastest() const { return fastest_; }
  // Stress and damping act by a share, and pushes of h carry what they can: up to kCarried of what the stiffest
  // tetrahedron may have at rest.
  void set_step(const SoftView& v, Real h, double share);
  // Impulses of the stress over `time`; true when some of it was left to `solve_remainder`.
  bool push(const SoftView& v, Real time, StepContext& c);
  void solve_remainder(const SoftView& v, Real h, StepContext& c);
  void damp(const SoftView& v, Real time, StepContext& c);  // strain rate out of velocities, see damping.cpp
  void validate(const SoftView& v) const;

 private:
  using Kernel = void (*)(const TetPass&);
  struct Color {
    unsigned first, last;  // batches
  };
  static constexpr std::size_t kStages = 64;
  TetPass pass(const SoftView& v, Real h);
  void run(Kernel kernel, const TetPass& pass, StepContext& c);
  std::uint32_t color(const SoftView& v);
  void measure(const SoftView& v);
  void reshape(const SoftView& v);

  Arena& arena_;
  const TetKernels* kernels_ = &kTetKernelsPlain;
  std::uint64_t version_ = ~std::uint64_t(0), shape_ = 0;
  Array<TetBatch> tets_{&arena_};
  Array<unsigned char> flagged_{&arena_};  // by batch
  Array<Color> colors_{&arena_};
  JobPool::Stage stages_[kStages];               // of the pass that runs: its colours
  Array<std::uint32_t> color_{&arena_};          // by tetrahedron
  Array<std::uint32_t> lane_{&arena_};           // the tetrahedron of each lane, or kNone
  mutable Array<std::uint32_t> marks_{&arena_};  // of validate(), by point
  Array<double> rate_{&arena_};                  // by tetrahedron: w^2 of it alone per stiffness, 1/(s^2 Pa)
  double at_first_ = 0;                          // 1/s^2: w^2 of the body before anything of it flowed
  double fastest_ = 0, stiffest_ = 0;            // 1/s^2: of the body, and of a tetrahedron of it alone
  double share_ = 1, carried_ = 0;               // Pa: of the stiffest tetrahedron, by a push
  // stages of damping; empty where there is none
  Array<TetDamping> damping_{&arena_};
  Array<Row4> stage_{&arena_}, last_stage_{&arena_}, first_rate_{&arena_}, pushes_{&arena_};  // by point; m/s, and N s
};

}  // namespace feder
