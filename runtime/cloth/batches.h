// Coloured batches of links and hinges: what the kernels run over. Private to the module.
#pragma once
#include <memory>

#include "base/checks.h"
#include "base/colors.h"
#include "base/jobs.h"
#include "cloth/batch.h"
#include "cloth/bending.h"
#include "cloth/solver.h"
#include "integrate/damping_stages.h"

namespace feder {

// sum |gradient of the angle|^2/mass of a hinge at rest, 1/(kg m^2); all vertices count as free.
double hinge_response(const ClothView& v, const std::uint32_t (&at)[4]);
// Largest sum of stiffness over mass of the links at a vertex, and largest stiffness times hinge_response, 1/s^2; all
// vertices count as free, so that pins do not matter. The latter is a quarter of the square of the fastest bending wave
// of a strip.
double stiffest_link(const ClothView& v);
double stiffest_hinge(const ClothView& v);

class ClothBatches {
 public:
  // quadratic: bend() takes the constant form of bending.h where the cloth is flat at rest.
  explicit ClothBatches(Arena& a, bool quadratic = false)
      : arena_(a), quadratic_(quadratic ? std::make_unique<QuadraticBending>(a) : nullptr) {}
  // Wide kernels where the processor has them; "plain" for tests.
  void pick(bool wide);
  // Colours and batches for this mesh; does nothing for the version it has.
  void build(const ClothView& v);
  void build_long(const ClothView& v);                       // likewise the long links
  void current_position(const ClothView& v, JobPool& jobs);  // edges at the start of the step
  // Which sweep of a solver substep.
  struct Sweep {
    int index = 0, count = 1;
  };
  void solve(const ClothView& v, Real h, bool hinges, Sweep sweep, StepContext& c);
  // Forces of hinges over h into `velocity`.
  void bend(const ClothView& v, Real h, StepContext& c);
  void limit(const ClothView& v, Real h, StepContext& c);  // links without their force, to v.max_strain
  void reach(const ClothView& v, Real h, StepContext& c);  // long links
  void tie(const ClothView& v, Real h, StepContext& c);    // vertices to their anchors
  // Strain rate out of `velocity` over h, see damping.cpp.
  void damp_links(const ClothView& v, Real h, StepContext& c);
  void damp_hinges(const ClothView& v, Real h, StepContext& c);
  // More than one sweep: then it needs velocities of the same time as the positions.
  bool damps_in_stages(const ClothView& v, Real h) const { return stability(v, h) > kOneSweep; }
  void validate(const ClothView& v) const;  // asserts that the batches are those of the mesh; validate.cpp
  // The longest damping that bending gets in a substep of h, s; longer ones act as this one.
  double longest_damping(Real h) const;

 private:
  using Kernel = void (*)(const ClothPass&);
  struct Color {
    unsigned first, last;  // batches
  };
  static constexpr std::size_t kStages = 64;
  ClothPass pass(const ClothView& v, Real h);
  void run(Kernel kernel, const Array<Color>& colors, ClothPass pass, StepContext& c);
  void measure_hinges(const ClothView& v);
  void prepare_stages(const ClothView& v);
  void take_rests(const ClothView& v);
  static constexpr double kOneSweep = 0.05;
  // h tau w^2 of the fastest mode.
  double stability(const ClothView& v, Real h) const { return bending_ * double(v.damping) * double(h); }
  void run_stages(const ClothView& v, Real h, StepContext& c);
  template <class Elements, class Points>
  std::uint32_t color(const Elements& elements, std::uint32_t total, Points&& points);

  Arena& arena_;
  const ClothKernels* kernels_ = &kClothKernelsPlain;
  std::uint64_t version_ = ~std::uint64_t(0), long_version_ = ~std::uint64_t(0), rests_ = 0;
  Array<std::uint32_t> link_lane_{&arena_}, hinge_lane_{&arena_};  // of cloth that flows: elements in lane order
  Array<LinkBatch> links_{&arena_};
  Array<HingeBatch> hinges_{&arena_};
  Array<LinkBatch> long_links_{&arena_};
  Array<Color> link_colors_{&arena_}, hinge_colors_{&arena_}, long_colors_{&arena_};
  std::unique_ptr<QuadraticBending> quadratic_;
  JobPool::Stage stages_[kStages];                        // of the pass that runs: its colours
  mutable Array<std::uint64_t> used_{&arena_};            // by vertex: colours taken; marks of validate()
  Array<std::uint32_t> color_{&arena_}, order_{&arena_};  // by element; the order they are coloured in
  double bending_ = 0;                                    // 1/s^2: no bending mode has a larger square of its frequency
  // stages of damping; empty where one sweep does
  Array<HingeDamping> damping_{&arena_};                                                      // by batch of hinges
  Array<Row4> stage_{&arena_}, last_stage_{&arena_}, first_rate_{&arena_}, pushes_{&arena_};  // by vertex; m/s, and N s
};

}  // namespace feder
