// Elements in colours of eight: what the kernels run over. Private to the module.
#pragma once
#include "cloth/batch.h"
#include "cloth/solver.h"

namespace feder {

class ClothBatches {
 public:
  explicit ClothBatches(Arena& a)
      : links_(&a), hinges_(&a), link_colors_(&a), hinge_colors_(&a), used_(&a), color_(&a), order_(&a) {}
  // Wide kernels where the processor has them; "plain" for tests.
  void pick(const std::string& width);
  // Colours and batches for this mesh; nothing when its version is known.
  void build(const ClothView& v);
  void place(const ClothView& v);   // edges at the start of the step
  void solve(const ClothView& v, Real h, bool hinges, bool again, StepContext& c);  // one sweep of a small step
  void bend(const ClothView& v, Real h, StepContext& c);  // forces of hinges over h into `speed`
  void damp(const ClothView& v, Real h, StepContext& c);

 private:
  using Kernel = void (*)(const ClothPass&);
  struct Color {
    unsigned first, last;  // batches
  };
  static constexpr std::size_t kStages = 64;
  void run(Kernel kernel, const Array<Color>& colors, ClothPass pass, StepContext& c);
  template <class Elements, class Points>
  std::uint32_t color(const Elements& elements, std::uint32_t total, Points&& points);

  const ClothKernels* kernels_ = &kClothKernelsPlain;
  std::uint64_t version_ = ~std::uint64_t(0);
  Array<LinkBatch> links_;
  Array<HingeBatch> hinges_;
  Array<Color> link_colors_, hinge_colors_;
  JobPool::Stage stages_[kStages];  // of the pass that runs: its colours
  Array<std::uint64_t> used_;       // by vertex: colours taken
  Array<std::uint32_t> color_, order_;  // by element; the order they are coloured in
};

}  // namespace feder
