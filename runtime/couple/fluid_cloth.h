// Fluids and cloth in one world: two-way contact between particles and the triangles of sheets.
#pragma once
#include "couple/fluid_skins.h"
#include "feder/cloth.h"
#include "feder/system.h"

namespace feder {

class FluidCloth final : public System {
 public:
  static constexpr const char* kName = "fluid_cloth";
  static const SystemDescriptor& descriptor();
  explicit FluidCloth(SystemSetup& setup);

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // particles in contact with surfaces
  void hash(Hash&) const override {}   // its state follows from the two systems
  void save(Writer& w) const override { w.list(pressed_); }
  void load(Reader& r) override { r.list(pressed_), skins_.forget(); }
  void validate() const override;
  void residuals(std::vector<Residual>& out) const override;  // fluid_cloth.impulse_mismatch, .force_n

 private:
  // Impulses of fluid on a cloth in the last step.
  struct Pressed {
    ObjectId cloth;
    Real along = 0;  // impulse along gravity, N s
    Real all = 0;    // sum of the magnitudes of the impulses, N s
    Real near = 0;   // mass of fluid that may reach it, kg
  };

  // Passes.
  void wake(StepContext& c);
  void finish(StepContext& c);

  void find_impact(std::size_t n, StepContext& c);

  Fluid& fluid_;
  Cloth& cloth_;
  FluidSkins& skins_;
  Array<Pressed> pressed_;  // by cloth
  double force_ = 0;        // N, of the last step, along gravity
};

}  // namespace feder
