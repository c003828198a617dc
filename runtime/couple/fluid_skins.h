// Particles of fluids at surfaces whose solver runs in the loop of surface substeps: sheets of cloth and the closed
// skins of soft bodies. One for the couplings with both, as a particle may lie between a sheet and a block; it then is
// one solver body with a contact to each. The first owner's coupling makes its passes.
#pragma once
#include <string_view>

#include "couple/face_contact_states.h"
#include "couple/fluid_faces.h"
#include "feder/fluid.h"
#include "feder/system.h"
#include "state/contact_book.h"
#include "state/solver_bodies.h"
#include "state/surface.h"

namespace feder {

class FluidSkins {
 public:
  explicit FluidSkins(Arena& arena) : warned(&arena), arena_(arena), faces_(arena) {}
  // That of the store, made with the first coupling.
  static FluidSkins& of(SystemSetup& setup, const char* coupling);

  // Impulses of fluid on a surface in the step.
  struct Pressed {
    ObjectId object;
    Real along = 0;  // impulse along gravity, N s
    Real all = 0;    // sum of the magnitudes of the impulses, N s
  };
  // Particles of a fluid that were inside a soft body.
  struct Expelled {
    ObjectId object, fluid;
    std::uint32_t count = 0;
  };
  Array<Expelled> warned;  // whose warning was sent; saved

  // Of the coupling with that owner of surfaces; where it is the first that has some, its names are those of the
  // passes.
  struct Names {
    const char *screen, *rows, *connect;
  };
  void add_passes(StepPlan& plan, std::string_view owner, const char* coupling, const Names& names);
  Pressed pressed(ObjectId object) const;                                  // from Rank::cloth_load on
  void report();                                                           // events; there
  std::size_t count() const { return particle_bodies_.size(); }            // particles in contact
  void forget() { contact_states_.clear(); }                               // after a snapshot
  double mismatch() const { return given_ > 0 ? mismatch_ / given_ : 0; }  // of impulses, relative
  double projected() const { return static_cast<double>(projected_); }     // corrections of the last step
  void validate() const;

 private:
  // A fluid particle in contact, as a solver body for the surface substeps of a substep.
  struct ParticleBody {
    std::uint32_t pool = 0, particle = 0, solver_index = 0;
    Vec3 given = Vec3::Zero();   // velocity, m/s
    Vec3 pushed = Vec3::Zero();  // impulse of the rows, N s
    bool held = false;           // against a wall
  };

  // Passes.
  void connect(StepContext& c);
  void begin(StepContext& c);
  void make_rows(StepContext& c);
  void read_back(StepContext& c);

  void expel(StepContext& c);
  bool leans(const FluidPool& p, const FaceContact& k) const;
  static bool takes(const Surface& s) { return !s.coasts && !s.triangles.empty(); }
  bool wet(const Aabb& box, Real seconds) const;
  void list_surfaces();
  void drop_rows();
  Vec3 slip(const FaceContact& k, const Real (&weight)[3], Real& response) const;
  void exchange(const FaceContact& k, const Real (&weight)[3], const Vec3& impulse);
  void rub(const FaceContact& k, const Real (&weight)[3], const Vec3& normal, Real pressing);
  void project_out(const FaceContact& k, const FaceHit& hit, StepContext& c);
  void record(const FaceContact& k, Real impulse, Real speed, const Vec3& normal);

  Arena& arena_;
  Fluid* fluid_ = nullptr;
  Surfaces* surfaces_ = nullptr;
  SolverBodies* solver_bodies_ = nullptr;
  Objects* objects_ = nullptr;
  ContactBook* contacts_ = nullptr;
  std::uint32_t finder_ = 0;
  FluidFaces faces_;
  Array<ParticleBody> particle_bodies_{&arena_};
  Array<std::uint32_t> next_row_{&arena_};  // by group of surfaces
  struct Pressing {
    Real impulse = 0;  // N s
    Vec3 normal = Vec3::Zero();
  };
  Array<Pressing> pressing_{&arena_};  // by contact, of the running substep
  Array<Pressed> pressed_{&arena_};    // by surface of faces_
  FaceContactStates contact_states_{arena_};
  Array<Expelled> expelled_{&arena_};  // of the step
  std::uint32_t own_bodies_ = 0;       // number of solver bodies without those of particles
  double mismatch_ = 0, given_ = 0;    // N s, of the last step
  std::uint64_t projected_ = 0;        // corrections of the last step
};

}  // namespace feder
