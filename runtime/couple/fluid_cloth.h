// Fluids and cloth in one world: two-way contact between particles and the triangles of sheets.
#pragma once
#include "couple/face_contact_states.h"
#include "couple/fluid_faces.h"
#include "feder/cloth.h"
#include "feder/system.h"
#include "state/contact_book.h"
#include "state/solver_bodies.h"
#include "state/surface.h"

namespace feder {

class FluidCloth final : public System {
 public:
  static constexpr const char* kName = "fluid_cloth";
  static const SystemDescriptor& descriptor();
  explicit FluidCloth(SystemSetup& setup);

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // particles in contact with cloth
  void hash(Hash&) const override {}   // its state follows from the two systems
  void save(Writer& w) const override { w.list(pressed_); }
  void load(Reader& r) override { r.list(pressed_), contact_states_.clear(); }
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
  // A fluid particle in contact, as a solver body for the surface substeps of a substep.
  struct ParticleBody {
    std::uint32_t pool = 0, particle = 0, solver_index = 0;
    Vec3 given = Vec3::Zero();   // velocity, m/s
    Vec3 pushed = Vec3::Zero();  // impulse of the rows, N s
  };

  // Passes.
  void wake(StepContext& c);
  void connect(StepContext& c);
  void begin(StepContext& c);
  void make_rows(StepContext& c);
  void read_back(StepContext& c);
  void finish(StepContext& c);

  bool wet(const Aabb& box, Real seconds) const;
  void list_surfaces();
  void find_impact(std::size_t n, StepContext& c);
  void drop_rows();
  Vec3 slip(const FaceContact& k, const Real (&weight)[3], Real& response) const;
  void exchange(const FaceContact& k, const Real (&weight)[3], const Vec3& impulse);
  void rub(const FaceContact& k, const Real (&weight)[3], const Vec3& normal, Real pressing);
  void project_out(const FaceContact& k, const FaceHit& hit, StepContext& c);
  ObjectId fluid_of(std::uint32_t pool) const;
  void record(const FaceContact& k, Real impulse, Real speed, const Vec3& normal);

  Arena& arena_;
  Fluid& fluid_;
  Cloth& cloth_;
  Surfaces& surfaces_;
  SolverBodies& solver_bodies_;
  Objects& objects_;
  ContactBook& contacts_;
  const std::uint32_t finder_;
  FluidFaces faces_;
  Array<ParticleBody> particle_bodies_{&arena_};
  Array<std::uint32_t> next_row_{&arena_};  // by group of cloths
  struct Pressing {
    Real impulse = 0;  // N s
    Vec3 normal = Vec3::Zero();
  };
  Array<Pressing> pressing_{&arena_};  // by contact, of the running substep
  Array<Pressed> pressed_{&arena_};    // by cloth
  FaceContactStates contact_states_{arena_};
  std::uint32_t own_bodies_ = 0;     // number of solver bodies without those of particles
  double mismatch_ = 0, given_ = 0;  // N s, of the last step
  double force_ = 0;                 // N, of the last step, along gravity
  std::uint64_t projected_ = 0;      // corrections of the last step
};

}  // namespace feder
