// One cloth: its run of vertices, mesh, solver and settings. Private to the module.
#pragma once
#include <algorithm>
#include <memory>
#include <string>

#include "base/double3.h"
#include "bounds/box_search.h"
#include "cloth/solver.h"
#include "cloth/still_air.h"
#include "feder/cloth.h"

namespace feder {

// What decides a cloth's motion beside vertices and mesh; plain data, saved as it is.
struct ClothSettings {
  ClothStiffness stiffness{};
  Real area_density = 0;  // kg/m^2
  Real damping = 0;       // s
  Real thickness = 0;     // m
  Real friction = 0;
  Real drag = 1, lift = 1;
  Real tear_strain = kInfinity, max_strain = kInfinity;
  Real gravity_scale = 1;
  Real stretch_error = 0;
  std::int32_t substeps = 0, max_substeps = 0;
  std::uint32_t group = 1, mask = 0xffffffffu;
  std::uint32_t self_collision = 1, wind = 1;
  std::uint32_t ignores_inside = 0;
  std::uint32_t limit_free = 0;  // max_strain was set: it also applies to cloth that nothing holds
  Real pressure = 0;             // Pa
  Real yield = kInfinity;        // strain
  Real flow = 0;                 // 1/s
  bool flows() const { return yield < kInfinity && flow > 0; }
};

// What changes from step to step; saved too.
struct ClothState {
  // m/s^2: gravity while the last step was free fall, else 0; velocities are then corrected by the solver's lead
  Real flight[3] = {0, 0, 0};
  Real sleep_energy = kInfinity;  // moving average of kinetic energy per mass, m^2/s^2
  std::uint32_t sleep_steps = 0;
  std::uint32_t fresh = 1;   // 1: not stepped yet
  std::uint32_t frozen = 0;  // 1: quarantined
  std::uint32_t asleep = 0;
  std::int32_t substeps = 1;           // as last chosen for it; its group takes the largest number of its members
  std::uint32_t warned = 0;            // 1: the cap of solver substeps was reported
  std::uint32_t warned_damping = 0;    // 1: so was a damping time that is too long
  std::uint32_t warned_shortfall = 0;  // 1: so was a solver that did not reach its tolerance
  std::uint32_t warned_lost = 0;       // 1: so was pressure that leaves through holes
  std::uint32_t warned_pressure = 0;   // 1: so was pressure beyond what the solver substep carries
  Real load = 0;                       // kg, that rests on it
  Real pull = 0;                       // m/s^2: mean acceleration by gravity, wind and scripts in the last step
  // Crossings with itself that the last search left (where released: at least), and fewest since their number was last
  // given up or vertices were put somewhere
  std::uint32_t tangles = 0, least_tangles = 0;
  std::uint32_t tangled_steps = 0;   // steps of search since there were fewest
  std::uint32_t tangles_rest = 0;    // steps until the next search for ways out
  std::uint32_t tangles_rests = 0;   // how often it rested
  std::uint32_t released = 0;        // 1: too many of them: no self-contact
  std::uint32_t warned_tangles = 0;  // 1: it was reported that they stay
  std::uint32_t edited = 0;          // 1: vertices were put somewhere since the last step
  std::uint32_t suspect_steps = 0;   // steps in which it is searched because it tore or points were put somewhere
};

// Ties of vertices to pins and attachments; made anew when those change, see ties.cpp.
struct ClothTies {
  explicit ClothTies(Arena& a) : batches(&a), anchor(&a), rest(&a), layers(&a), to_body(&a), pins(&a) {}
  // to pins
  Array<TieBatch> batches;
  Array<std::uint32_t> anchor;  // by lane of the batches
  Array<Real> rest;             // likewise: distance along the cloth, m
  Array<std::uint32_t> layers;  // where layers of batches end
  // to attached vertices, solved one after another
  struct ToBody {
    std::uint32_t vertex = 0, anchor = 0;
    Real rest = 0;      // m
    bool body = false;  // reversed: `vertex` is the pin that the attached `anchor` hangs from
  };
  Array<ToBody> to_body;      // in the order of the attachments
  Real limit = kInfinity;     // over rest, at which they act in this step
  Array<std::uint32_t> pins;  // a sample of pins that lie far from each other, also where nothing is tied
};

// Gas in a closed mesh, see pressure.cpp; follows from mesh and positions.
struct ClothGas {
  explicit ClothGas(Arena& a) : outer(&a) {}
  std::uint64_t version = 0;  // of the mesh that `closed` and `outward` are of
  bool closed = false;
  double outward = 1;                // -1: normals of its triangles point inwards
  double rest_volume = 0, skin = 0;  // m^3; Pa, the most that its skin carries
  double rate = 0;                   // 1/(s^2 Pa): bound of w^2 of the pressure's stiffness, per pressure
  double pressure = 0;               // Pa, that acts in this substep, along the normals of the triangles
  Double3 momentum{0, 0, 0};         // kg m/s, of a free cloth after the solver substep, as forces have it
  Array<Vec3> outer;                 // by vertex: acceleration by everything else, m/s^2
};

struct Sheet {
  Sheet(Arena& a) : mesh(a), ties(a), gas(a), still_air(a), edited(&a) {}

  static constexpr std::uint32_t kSuspectSteps = 30;  // until contact keeps apart what touches

  ObjectId object;
  std::uint32_t first = 0, points = 0, total = 0;  // run in ClothVertices: visible, with hidden ones
  ClothMesh mesh;
  ClothSettings settings;
  ClothState state;
  std::string search_name;                     // of self-contact, in box_searches()
  const Variant<BoxSearch>* search = nullptr;  // null: the default
  std::string solver_name;
  Params solver_options;
  std::unique_ptr<ClothSolver> solver;
  std::uint64_t version = 1;  // of mesh and indices
  bool paths_stale = true;    // pins, attachments or mesh changed
  Real rows = 1, path = 1;    // links from the pins (or the middle) to the farthest vertex, and their length, m
  Real impact = 0, approach_speed = 0;  // m/s^2 and m/s, of this step, by approaching bodies
  ClothTies ties;
  ClothGas gas;
  StillAir still_air;
  std::uint64_t rests = 1;   // changes with rest lengths and angles
  double bend_substeps = 1;  // ClothSolver::wanted_substeps, as last asked
  Real bend_step = -1;       // s, substep of that answer
  std::uint32_t bad_vertex = kNone;
  // Where crossings may have arisen: all of it, or at the vertices that were put somewhere since the last step.
  bool suspect = false;
  Array<std::uint32_t> edited;
  Real mass = 0;                        // kg
  Vec3 gained_momentum = Vec3::Zero();  // kg m^2/s, angular momentum error of its solver in this substep
  Real lacking = 1;                     // solver substeps that it would need in this step, by its cap
  bool any_pin = false;
  bool framed = false;        // its pins are farther apart than the cloth is at rest
  bool beside_body = false;   // bodies may touch it in this step
  bool prepared = false;      // its solver, for this step
  bool gusty = true;          // still air is not known for this step, or changes within it
  double kinetic = -1;        // J, at the end of the last step; < 0: unknown, a velocity was edited
  double kinetic_before = 0;  // J, at the start of the step

  Vec3 flight() const { return Vec3(state.flight[0], state.flight[1], state.flight[2]); }
  void find_search() {
    const auto& found = find_variant(box_searches(), search_name, "search of self-contact");
    search = search_name == default_box_search() ? nullptr : &found;
  }
  void set_flight(const Vec3& a) {
    for (int k = 0; k < 3; ++k) state.flight[k] = a[k];
  }
  // 1 for a cloth that bears nothing, 0 for one that bears its own weight or more, or may touch bodies.
  Real unladen() const { return beside_body ? Real(0) : mass > 0 ? std::max(1 - state.load / mass, Real(0)) : Real(1); }
  // Strain of links is limited to max_strain.
  bool limited() const { return settings.limit_free || !ties.batches.empty() || !ties.to_body.empty(); }
  bool active() const { return !state.frozen && !state.asleep; }
};

}  // namespace feder
