// Fluids and nets in one world: two-way contact between particles and the faces of a net. Nets without faces let fluid
// through.
#pragma once
#include "couple/fluid_faces.h"
#include "feder/net.h"
#include "feder/system.h"
#include "state/particles.h"

namespace feder {

class FluidSprings final : public System {
 public:
  static constexpr const char* kName = "fluid_springs";
  static const SystemDescriptor& descriptor();
  explicit FluidSprings(SystemSetup& setup);

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // faces of nets
  void hash(Hash&) const override {}   // all state is that of the two systems
  void save(Writer&) const override {}
  void load(Reader&) override {}
  void validate() const override;
  void residuals(std::vector<Residual>& out) const override;  // fluid_springs.impulse_mismatch

 private:
  // Passes.
  void remember(StepContext& c);
  void begin(StepContext& c);
  void solve(StepContext& c);

  void list_surfaces();
  void push_apart(const FaceContact& k);
  void exchange(const FaceContact& k, const Real (&weight)[3], const Vec3& normal);

  Fluid& fluid_;
  Springs& springs_;
  Particles& points_;
  FluidFaces faces_;
  double mismatch_ = 0, given_ = 0;  // N s, of the last step
  std::uint64_t projected_ = 0;
};

}  // namespace feder
