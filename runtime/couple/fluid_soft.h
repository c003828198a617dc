// Fluids and soft bodies in one world: two-way contact between particles and skins (fluid_skins.h), from outside.
#pragma once
#include "couple/fluid_skins.h"
#include "feder/soft.h"
#include "feder/system.h"

namespace feder {

class FluidSoft final : public System {
 public:
  static constexpr const char* kName = "fluid_soft";
  static const SystemDescriptor& descriptor();
  explicit FluidSoft(SystemSetup& setup);

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // particles in contact with surfaces
  void hash(Hash&) const override {}   // its state follows from the two systems
  void save(Writer& w) const override { w.list(pressed_), w.list(skins_.warned); }
  void load(Reader& r) override { r.list(pressed_), r.list(skins_.warned), skins_.forget(); }
  void validate() const override;
  // fluid_soft.impulse_mismatch, .force_n, .guarded
  void residuals(std::vector<Residual>& out) const override;

 private:
  // Of a soft body in the last step.
  struct Pressed {
    ObjectId soft;
    Real all = 0;  // sum of the magnitudes of the impulses of fluid, N s
  };

  // Passes.
  void wake(StepContext& c);
  void finish(StepContext& c);

  Fluid& fluid_;
  Soft& soft_;
  FluidSkins& skins_;
  Array<Pressed> pressed_;
  double force_ = 0;  // N, of the last step, along gravity: less than 0 what floats
};

}  // namespace feder
