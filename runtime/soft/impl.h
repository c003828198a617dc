// The parts of the system of soft bodies that its files share. Private to the module.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "feder/error.h"
#include "feder/force.h"
#include "feder/soft.h"
#include "forces/work_bound.h"
#include "soft/solver.h"
#include "soft/tetrahedra.h"
#include "state/arrays.h"
#include "state/command_log.h"
#include "state/surface.h"
#include "state/surface_links.h"
#include "step/watch.h"

namespace feder {

// What decides a soft body's motion beside its points; plain data, saved as it is.
struct SoftSettings {
  Real density = 0, young = 0, poisson = 0;  // kg/m^3, Pa
  Real damping = 0;                          // s
  Real thickness = 0, friction = 0;          // m
  Real gravity_scale = 1;
  std::uint32_t group = 1, mask = 0xffffffffu;
  std::uint32_t self_collision = 1;
  std::int32_t substeps = 0, max_substeps = 0;
  Real yield = kInfinity, flow = 0;  // strain; 1/s
  Real fracture_stress = kInfinity;  // Pa
  bool flows() const { return flow > 0 && yield < kInfinity; }
  bool fractures() const { return fracture_stress < kInfinity; }
};

// What changes from step to step; saved too.
struct SoftState {
  // m/s^2: gravity while the last step was free fall, else 0; velocities are then those at the end of a solver
  // substep, where the method's own are half of one behind
  Real flight[3] = {0, 0, 0};
  Real sleep_energy = kInfinity;  // moving average of kinetic energy per mass, m^2/s^2
  std::uint32_t sleep_steps = 0;
  std::uint32_t fresh = 1, frozen = 0, asleep = 0;  // 1: not stepped yet; quarantined; asleep
  std::int32_t substeps = 1;                        // as last chosen for it
  std::uint32_t warned = 0;                         // 1: the cap of solver substeps was reported
  std::uint32_t warned_shortfall = 0;               // 1: so was a solver that did not reach its tolerance
  std::uint32_t warned_limits = 0;                  // 1: so was what of the material its solver does not have
  std::uint32_t warned_inverted = 0;                // 1: so were inverted tetrahedra that its law does not turn back
  std::uint32_t warned_flow = 0;                    // 1: so was a shape that flowed as far as it may
};

// Of a soft body whose energy jumped.
inline constexpr const char* kSoftCure = "take more substeps or weaker forces";

// Sum over tetrahedra of volume times Cauchy stress, and of volume.
struct StressSum {
  Mat3d stress = Mat3d::Zero();  // J
  double volume = 0;             // m^3
};

// The largest principal stress at a point.
struct Tension {
  double stress = 0;     // Pa
  Vec3 across{1, 0, 0};  // unit normal of the plane that it pulls at
};

struct SoftBody {
  explicit SoftBody(Arena& a) : arena(a), mesh(a) {}

  Arena& arena;
  ObjectId object;
  SoftSettings settings;
  SoftState state;
  SoftMesh mesh;
  Array<Vec3> position{&arena}, velocity{&arena};  // m, world; m/s
  Array<Vec3> script_force{&arena};                // N
  Array<Real> mass{&arena}, inv_mass{&arena};      // kg; 1/kg, 0: pinned
  // Acceleration by contacts in the last solver substep, and what it and the one before have in common, m/s^2.
  Array<Vec3> contact{&arena}, steady_contact{&arena};
  std::string search_name;                     // of self-contact, in box_searches(); empty: none of its own
  const Variant<BoxSearch>* search = nullptr;  // follows from it
  std::string solver_name;
  Params solver_options;
  std::unique_ptr<SoftSolver> solver;
  const ElasticLaw* law = nullptr;  // saved by its name

  // follow from those
  SoftMaterial material;
  std::uint64_t version = 1;  // of mesh and material
  std::uint64_t shape = 0;    // of what flowed
  Real total_mass = 0;        // kg
  bool any_pin = false;
  double share = 1;  // of its stiffness that it acts with, as last chosen
  // of a step
  Array<Vec3> acceleration{&arena};  // gravity, scripts, generators, m/s^2
  Array<Real> kept{&arena};          // by point, of its velocity in a solver substep against drag; empty: all of it
  std::uint32_t surface = 0;         // in Surfaces::list
  std::uint32_t bad_point = kNone;
  bool touched = false, linked = false, prepared = false;  // contact moved it; held to something; its solver is ready
  Array<Vec3> began{&arena};                               // m: where the step began, for the watchdog
  double kinetic_before = 0;                               // J, then

  std::uint32_t size() const { return static_cast<std::uint32_t>(position.size()); }
  bool active() const { return !state.frozen && !state.asleep; }
  Vec3 flight() const { return Vec3(state.flight[0], state.flight[1], state.flight[2]); }
  void set_flight(const Vec3& a) {
    for (int k = 0; k < 3; ++k) state.flight[k] = a[k];
  }
  void derive();                                              // all that follows
  void derive_mass();                                         // what follows from pins
  void share_mass();                                          // that of tetrahedra by their points
  Mat3d gradient(std::size_t k, const Array<Vec3>& x) const;  // elastic deformation gradient
  Tension tension(std::uint32_t i) const;
  void find_search() {
    search = search_name.empty() ? nullptr : &find_variant(box_searches(), search_name, "search of self-contact");
  }
  double elastic_energy(const Array<Vec3>& x) const;  // J, above that at rest, with its points there
  double kinetic_energy() const;                      // J
  // Calls f(member) for what snapshots hold beside mesh and solver.
  template <class B, class F>
  static void each_saved(B& b, F&& f) {
    for_each_of(f, b.object, b.settings, b.state, b.position, b.velocity, b.script_force, b.mass, b.inv_mass, b.contact,
                b.steady_contact);
  }
  Corners corners(std::size_t k) const { return corners(k, position); }
  Corners corners(std::size_t k, const Array<Vec3>& x) const {
    const TetrahedronPoints& t = mesh.tetrahedra[k];
    return {wide(x[t[0]]), wide(x[t[1]]), wide(x[t[2]]), wide(x[t[3]])};
  }
};

struct Soft::Impl {
  explicit Impl(SystemSetup& setup);

  Arena& arena;
  Store& store;
  Objects& objects;
  CommandLog& commands;
  Events& events;
  Watch& watched;
  bool* structure_changed;
  Surfaces& surfaces;
  std::vector<std::unique_ptr<SoftBody>> bodies;  // by object index
  std::size_t force_count = 0;                    // forces known when the passes were made
  bool gravity_known = false;
  Vec3 gravity = Vec3::Zero();  // of the last step: a change wakes all
  Array<MassPoint> points{&arena};
  Array<Vec3> forces{&arena};                             // N
  Array<Real> skin_area{&arena};                          // by point, m^2
  Array<StressSum> stress{&arena};                        // by point, of the body that is looked at
  Array<std::pair<Tension, std::uint32_t>> torn{&arena};  // beyond its fracture stress, and the point
  Array<Vec3> as_is{&arena}, faster{&arena};              // N, of one force, and on points that are faster

  SoftBody& body(ObjectId id) const {
    FEDER_ASSERT(objects.alive(id) && objects.kind(id) == kSoftKind);
    return *bodies[objects.index(id)];
  }
  std::uint32_t point(ObjectId id, std::size_t i) const;  // SceneError when there is none
  void declare_surfaces();
  // SceneError when the solver does not have the law; `owner` begins it.
  void attach_solver(SoftBody& b, const std::string& name, const Params& options, const std::string& law,
                     const std::string& owner);
  SoftView view(SoftBody& b);
  void wake(SoftBody& b, WakeCause cause, ObjectId other);
  void put_to_sleep(SoftBody& b);
  void drain_wakes();

  // passes
  void show(StepContext& c);
  void gather(StepContext& c);
  void begin_substep(StepContext& c);
  void advance(StepContext& c);
  void read_velocities(StepContext& c);
  void wake_touched(StepContext& c);
  void commit(StepContext& c);

  void choose_substeps(SoftBody& b, StepContext& c);
  void check_shortfall(SoftBody& b);
  void check_inverted(SoftBody& b);
  void warn_of_limits(SoftBody& b);
  void warn_of_cap(SoftBody& b, double wanted, int cap);
  void add_forces(SoftBody& b, StepContext& c);
  void add_resistance(SoftBody& b, const Force& force, double time);
  void update_sleep(SoftBody& b, StepContext& c);
  void flow(SoftBody& b, StepContext& c);  // plastic.cpp
  void fracture(SoftBody& b);              // fracture.cpp
  // watch.cpp
  double work(const SoftBody& b, const StepContext& c) const;
  double given(const SoftBody& b, const StepContext& c) const;
  void watch(const SoftBody& b, const StepContext& c);

  SurfaceGroup& group(const StepContext& c) const { return *surfaces.groups[static_cast<std::size_t>(c.inner.group)]; }
  template <class F>
  void each_active(const SurfaceGroup& g, F&& f) {
    for (const std::uint32_t n : g.members)
      if (objects.kind(surfaces.list[n].object) == kSoftKind) {
        SoftBody& b = body(surfaces.list[n].object);
        if (b.active() && b.prepared) f(b);
      }
  }
  template <class F>
  void each_force(const SoftBody& b, F&& f) const {
    each_acting(store.find<Forces>(), b.object, objects.tags(b.object), f);
  }
  void add_wind(const SoftBody& b, const Force& wind, double time, Real h);  // wind.cpp
  // A point as generators see it, with the volume of its share of the tetrahedra and the area of a ball of it.
  MassPoint mass_point(const SoftBody& b, std::uint32_t i) const;
};

}  // namespace feder
