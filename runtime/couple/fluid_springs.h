// Fluids and nets in one world: two-way contact between particles and the faces of a net. Nets without faces let fluid
// through.
#pragma once
#include "couple/face_contact_states.h"
#include "couple/fluid_faces.h"
#include "feder/net.h"
#include "feder/system.h"
#include "state/contact_book.h"
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
  void load(Reader&) override { contact_states_.clear(); }
  void validate() const override;
  void residuals(std::vector<Residual>& out) const override;  // fluid_springs.impulse_mismatch

 private:
  // Passes.
  void remember(StepContext& c);
  void begin(StepContext& c);
  void solve(StepContext& c);
  void report(StepContext& c);

  void list_surfaces();
  // Of a contact in a substep.
  struct Push {
    Real impulse = 0, speed = 0;  // N s; closing, the largest, m/s
    Vec3 normal = Vec3::Zero();   // of the last impulse
    Real moved = 0;               // of the particle, m
  };
  void push_apart(const FaceContact& k, Push& total);
  void exchange(const FaceContact& k, const Real (&weight)[3], const Vec3& normal, Push& total);
  void record(const FaceContact& k, const Push& total);

  Fluid& fluid_;
  Springs& springs_;
  Particles& points_;
  Objects& objects_;
  ContactBook& contacts_;
  const std::uint32_t finder_;
  FluidFaces faces_;
  FaceContactStates contact_states_;
  Array<Push> pushes_;               // by contact, of the running substep
  double mismatch_ = 0, given_ = 0;  // N s, of the last step
  std::uint64_t projected_ = 0;
};

}  // namespace feder
