// Fluids and cloth in one world: sheets hold, catch and shed fluid, and are moved by it.
#pragma once
#include "cloth/cloth.h"
#include "couple/fluid_faces.h"
#include "state/movers.h"
#include "step/system.h"

namespace feder {

class FluidCloth final : public System {
 public:
  static constexpr const char* kName = "fluid_cloth";
  static const SystemDescriptor& descriptor();
  explicit FluidCloth(SystemSetup& setup);

  void add_rows(StepPlan& plan) override;
  std::size_t count() const override;  // particles that touch cloth
  void hash(Hash&) const override {}   // what it keeps follows from the two systems
  void save(Writer& w) const override { w.list(pressed_); }
  void load(Reader& r) override { r.list(pressed_); }
  void residuals(std::vector<Residual>& out) const override;  // fluid_cloth.impulse_mismatch, .force_n

 private:
  // What fluid did to a cloth in the last step.
  struct Pressed {
    ObjectId cloth;
    Real along = 0;  // impulse along gravity, N s
    Real all = 0;    // sum of the sizes of the impulses, N s
  };
  // A particle that stands among the movers for the length of the cloth's row.
  struct Guest {
    std::uint32_t pool = 0, particle = 0, mover = 0;
    Vec3 given = Vec3::Zero();   // velocity, m/s
    Vec3 pushed = Vec3::Zero();  // by the rows, N s
  };

  // Rows.
  void wake(StepContext& c);
  void begin(StepContext& c);
  void make_rows(StepContext& c);
  void read_back(StepContext& c);
  void finish(StepContext& c);

  void list_surfaces();
  void place_vertices();
  void drop_rows();
  void hold_back(const FaceContact& k, const FaceHit& hit, StepContext& c);
  ObjectId fluid_of(std::uint32_t pool) const;

  Fluid& fluid_;
  Cloth& cloth_;
  Movers& movers_;
  SystemFinder& systems_;
  FluidFaces faces_;
  Array<Guest> guests_;
  Array<Pressed> pressed_;           // by cloth
  std::uint32_t own_movers_ = 0;     // how many there were without the guests
  double mismatch_ = 0, given_ = 0;  // N s, of the last step
  double force_ = 0;                 // N, of the last step, along gravity
  std::uint64_t guarded_ = 0;        // corrections of the last step
};

}  // namespace feder
