// One fluid: its particles as arrays, sorted by cell of its grid so that neighbours are near in memory; their
// constants; and work arrays. Private to the module and to couplings.
#pragma once
#include "base/jobs.h"
#include "bounds/cell_grid.h"
#include "feder/fluid.h"
#include "feder/plan.h"
#include "fluid/boundary.h"
#include "fluid/images.h"
#include "neighbors/neighbor_search.h"
#include "sph/boundary_table.h"
#include "sph/kernel.h"
#include "state/surface.h"

namespace feder {

// Particles per job, with sums over neighbours and without.
inline constexpr JobGrain kFluidGrain{512, 30'000}, kParticleGrain{2048, 8'000};

struct FluidPool {
  FluidPool(Arena& a, const FluidDesc& desc, int dimension);

  Arena& arena;
  ObjectId object;
  FluidDesc desc;
  int dimension;

  // Constants of the particles.
  Real support;            // of the kernel, m
  Real volume;             // m^3 (2D: m^2): spacing^D
  Real mass;               // kg
  Real unit;               // weight of a particle in the density sum, m^D: the sum over a lattice at rest is 1
  Real value_factor;       // unit * norm / support^D: from sums of value(u) to density over density at rest
  Real slope_factor;       // unit * norm / support^(D+2): likewise from sums of slope(u) x to its gradient
  Real viscous_factor;     // likewise with the norm of the kernel of viscosity
  Real own_value;          // what a particle adds to its own density
  Real least_squares;      // lower bound of the squared gradients of a density, 1/m^2
  Real viscous_scale;      // correction of viscosity, see pool.cpp
  Real cohesion;           // largest force between two particles that gives the surface tension, N
  Real force_of_tension;   // that over the tension, m
  bool colored;            // the colour field gives the tension; these four are of it, see tension.cpp
  Real color_unit;         // what a neighbour in the same place adds to a colour
  Real color_energy;       // of a volume that has no colour, Pa
  Real energy_of_tension;  // that over the tension, 1/m
  Real wetting;            // over the work of adhesion: the potential in which the boundary holds a volume, 1/m
  Real inward;             // pressure inside that balances it, Pa
  bool slips;              // no friction at the boundary
  Real clearance;          // least distance of a particle from the boundary, m
  const Kernel* kernel;    // of the table, or mixed_kernel; likewise its sums
  const Sweeps* sweeps;
  Kernel mixed_kernel;  // that of densities with the viscosity of another one
  Sweeps mixed_sweeps;
  std::unique_ptr<BoundaryTable> table;
  std::unique_ptr<NeighborSearch> search;
  std::unique_ptr<BoundaryImages> images;  // dfsph: of the boundary, in densities; null: the table is

  // State.
  std::uint32_t count = 0;
  // Position, m, and in w the weight of the particle in the pair sums of a running sweep (sweep_table.h), else 0. One
  // more than there are particles: the sentinel of padded lists, far away.
  Array<Row4> x{&arena};
  Array<Row4> v{&arena};  // m/s
  // Pressure variable of the solver. dfsph: multiplier of the last substep, kg m^2/s; pbf: multiplier of the last
  // substep, kg m^2, read by queries only; wcsph: pressure that is added to Tait's, Pa.
  Array<Real> lambda{&arena};
  Array<std::uint32_t> id{&arena};  // in the order of making
  std::uint32_t next_id = 0;
  Real last_h = 0;        // s, of the substep that left lambda
  Real sound = 0;         // wcsph: speed of sound of the last substep, m/s
  Real sound_before = 0;  // wcsph: of the one before; 0: none. Work
  Real settling = 0;      // wcsph: time in which pressure settles after a rise of it, s. Work
  Real head = 0;          // dfsph: g H of its column, m^2/s^2. Work
  Real pace = 0;          // dfsph: typical speed, m/s. Work
  Real compliance = 0;    // dfsph: growth of the density ratio that a multiplier is left, 1/(kg m^2). Work
  Real excess = 0;        // dfsph: of the density over that at rest, on average, in the last substep
  Real too_dense = 0;     // pbf, dfsph: s, for which it has been denser than wanted
  Real unsolved = 0;      // dfsph: s, for which velocities have missed their tolerance
  std::uint64_t steps = 0,
                iterations = 0;       // solver substeps, and those of their solves, since it was made; for reports
  bool frozen = false;                // quarantined
  bool asleep = false;                // sleep.cpp, these five
  Real calm = 0;                      // s, for which it has been slow; 0: is not
  double rest_center[3] = {0, 0, 0};  // m, of mass, when it began to be calm
  std::uint64_t rest_key = 0;         // of what it rests against
  std::uint64_t faces_near = 0;       // number of the last step in which faces of sheets or nets were, set by couplings
  std::uint32_t group = 0;            // in the loop of fluid substeps of this substep; work
  bool mixed = false;                 // solved as a part of a mixture now; work
  bool touches = false;               // was, in this substep; likewise
  bool layered = false;               // then: of those that touched, what is heavier lay below
  bool fresh = false;                 // filled since the last step
  bool warned_budget = false, warned_full = false, warned_viscosity = false;
  Real filled_width = 0;  // m, of a fill since the last step that was narrower than the spacing; 0: none
  bool warned_spacing = false, warned_density = false;  // of another fluid that it touches

  // For the watchdog; `kinetic` includes particles added since.
  double kinetic = 0, kinetic_before = 0;  // J: at the end of the last step, at the start of the step
  double crowded = 0;                      // s, for which new particles may still be closer than at rest

  // Of external_forces.cpp. Forces of scripts, N, empty until there are any; surface that wind acts on: its area times
  // its normal outwards, m^2, and in w the section of a particle alone, empty without wind.
  Array<Row4> script_force{&arena}, surface{&arena};
  Vec3 pressing = Vec3::Zero();  // mean acceleration by them in this substep, m/s^2; work, zero without any
  Real squeeze = 0;  // pressure over density in the middle, by those that hold it together, m^2/s^2; likewise
  double pushed[3] = {0, 0, 0};  // momentum by forces since a coupling set it to zero, kg m/s
  double worked = 0;             // kinetic energy that forces added in this step, J

  // Set by couplings with thin things (sheets, nets), see couple/fluid_faces.h.
  Array<Real> screen{&arena};  // their term of density over density at rest
  Array<Row4> origin{&arena};  // position at the start of the substep, m; empty until such a coupling asks for it
  std::uint64_t screened = 0;  // number of the substep for which both were set

  // Work.
  Array<Row4> start{&arena};      // x where contacts are found: at the start of the solver substep, or now
  Array<Row4> listed_at{&arena};  // wcsph: x where the lists were made; empty until it asks for it
  Array<Row4> move{&arena};       // sums of the sweeps, and the displacement or acceleration from them
  Array<Row4> extra{&arena};  // further rows: changes of velocity by viscosity; displacements of dfsph and relax.cpp
  Array<Real> sum{&arena}, squares{&arena};  // density sums, sums of squared gradients
  Array<Real> diagonal{&arena};              // of the system of pbf and dfsph
  Array<Real> ratio{&arena};                 // density over density at rest
  // dfsph, these four empty until it asks for them: growth of densities, less what is allowed; what is allowed; share
  // of the kernel that lies in the air; multipliers of displacements.
  Array<Real> residual{&arena}, allowed{&arena}, air{&arena}, shifts{&arena};
  Array<Real> least{&arena};        // dfsph with negative_pressure: lower bounds of the multipliers, else empty; work
  Array<Real> next_weight{&arena};  // becomes the weight in x before the next sweep
  Array<std::uint8_t> isolated{&arena};  // 1: meets no other particle in this substep, see components.h
  Array<std::uint8_t> inside{&arena};    // work of project_out: 1: the boundary has to move it
  Array<std::uint32_t> order{&arena};
  Array<Row4> swap4{&arena};  // these three: work of sort_by_cell, which exchanges them with what it sorts
  Array<Real> swap1{&arena};
  Array<std::uint32_t> swap_id{&arena};
  CellGrid grid{arena};
  NeighborLists lists{arena};
  bool lists_stale = true;                  // wcsph, in a substep
  bool half_kicks = false;                  // wcsph, as a leapfrog: a substep begins with half a kick and ends with one
  Array<BoundaryContact> contacts{&arena};  // by particle
  Array<std::uint32_t> contact_first{&arena};       // of a particle; one more than particles
  Array<std::uint32_t> block_first{&arena};         // work of find_contacts: of a block of particles
  Array<std::uint32_t> dynamic_contacts{&arena};    // indices of contacts with bodies that the fluid moves
  Array<Pose> found_pose{&arena};                   // by shape of the boundary: when contacts were found
  Array<Aabb> swept_shape{&arena};                  // work of project_out, by shape: over its motion since then
  Array<std::uint32_t> fast_shapes{&arena};         // likewise: those that moved far
  Array<FluidContactState> contact_states{&arena};  // by body of the boundary; sums in point and normal
  std::uint64_t ids_there = 0;  // of validate(): sum of id_key over the particles added and not removed

  // Of a mixture (mixture.cpp): the fluids that are solved as one, and by particle which it is of. Else empty.
  // The lightest one's density over the heaviest one's, which is desc.density: pressure moves it by so much more.
  Real lightest = 1;
  std::vector<FluidPool*> phases;
  Array<std::uint32_t> phase{&arena};
  // Of a mixture of unlike spacings (uneven.cpp), else empty.
  std::vector<Real> shares;  // by fluid: what one of its particles counts in a density, over one of the widest spacing
  std::vector<std::unique_ptr<BoundaryTable>> tables;  // by fluid
  Array<Real> share{&arena};                           // likewise by particle
  Array<Row4> skew{&arena};                            // what its neighbours count more than it does, times the slopes
  Real finest = desc.spacing;                          // of its spacings, m
  std::vector<Real> pull;            // of two phases, by both: largest force, N, that gives their tension
                                     // (cohesion); share by which one fills the colour of the other (color_field)
  std::vector<Real> color_energies;  // color_energy of phases
  std::vector<Real> wettings;        // wetting of phases

  std::uint32_t capacity() const { return static_cast<std::uint32_t>(id.size()); }
  bool active() const { return count > 0 && !frozen && !asleep && !mixed; }
  bool is_mixture() const { return !phases.empty(); }
  // Whose constants those of particle i are.
  const FluidPool& fluid_of(std::uint32_t i) const { return phases.empty() ? *this : *phases[phase[i]]; }
  Real mass_of(std::uint32_t i) const { return fluid_of(i).mass; }
  bool uneven() const { return !shares.empty(); }
  const BoundaryTable& table_of(std::uint32_t i) const { return shares.empty() ? *table : *tables[phase[i]]; }
  Real share_of(std::uint32_t i) const { return shares.empty() ? Real(1) : share[i]; }
  Real pull_between(std::uint32_t a, std::uint32_t b) const { return pull[a * phases.size() + b]; }
  bool drowsy() const;                                    // asleep or about to
  void grow(std::uint32_t wanted);                        // outside steps; all arrays by particle
  void keep_origins();                                    // origin is kept from now on, and grows with the others
  void keep_script_forces();                              // likewise script_force
  void keep_shares();                                     // what a mixture of unlike spacings needs, likewise
  void keep_solved();                                     // likewise what dfsph needs
  void keep_listed();                                     // likewise listed_at
  void add(const Vec3& position, const Vec3& velocity);   // below capacity()
  void remove_marked(const Array<std::uint8_t>& marked);  // keeps the order
  static std::uint64_t id_key(std::uint32_t id);          // the same ids have the same sum of keys; validate.cpp
  std::uint64_t id_sum() const;
  void validate() const;
  void validate_order() const;                 // after sort_by_cell: each particle lies in its cell
  void validate_neighbors(Real radius) const;  // a sample of the rows
  void find_tension();
  void kernel_with_viscosity(const Kernel& named, const Kernel& viscous);
  void put_sentinel();

  // Sorts the particles (and `start`) by the cells of find_neighbors with the same skin; particles in another order
  // would be searched one by one.
  void sort_by_cell(JobPool& jobs, Real skin = 0);
  void find_neighbors(JobPool& jobs, Real skin);
  void copy(const Array<Row4>& from, Array<Row4>& to, JobPool& jobs) const;
  SweepInput sweep_input() const;
  std::span<const BoundaryContact> contacts_of(std::uint32_t i) const {
    return {contacts.data() + contact_first[i], contact_first[i + 1] - contact_first[i]};
  }
  std::span<BoundaryContact> contacts_of(std::uint32_t i) {
    FEDER_ASSERT(i < count && contact_first[i] <= contact_first[i + 1] && contact_first[i + 1] <= contacts.size());
    return {contacts.data() + contact_first[i], contact_first[i + 1] - contact_first[i]};
  }
  // Factor of the energy of a surface and of what wets, for particles of that spacing with the support of this pool.
  Real energy_unit(Real spacing) const;
  Real wetting_unit(Real spacing) const;
  // Of a mixture of unlike spacings, uneven.cpp. Lists must be fresh.
  void set_shares(JobPool& jobs);                            // by phases, after a sort
  void find_skew(JobPool& jobs);                             // leaves shares in the weights
  void find_skew_from(const SweepInput& in, JobPool& jobs);  // of other positions, as push_from
  // Corrects the sums in `move`, for particles that count what they do: of slopes, and of push by the weights as they
  // are.
  void even_slopes(std::uint32_t first, std::uint32_t last);
  void even_push(std::uint32_t first, std::uint32_t last);
  void share_out(const Array<Row4>& from, Array<Row4>& to, JobPool& jobs) const;  // times the shares
  // Density over density at rest of all particles where they are; lists must be fresh.
  void find_ratios(const Boundary& boundary, JobPool& jobs);
  // Sets the weights of the positions to weight(i), for the next sweep.
  template <class F>
  void weigh(JobPool& jobs, F&& weight) {
    jobs.for_blocks(count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) x[i].w = weight(i);
    });
  }
  void clear_weights(JobPool& jobs) {
    weigh(jobs, [](std::uint32_t) { return Real(0); });
  }
  // Acceleration of its column in this substep, m/s^2.
  Vec3 weight(const Vec3& gravity) const { return desc.gravity_scale * gravity + pressing; }
  Aabb bounds() const;
  Real max_speed() const;
  double kinetic_energy() const;  // J; in blocks, as Fluid::Impl::check sums it

  // boundary.cpp. `speculative_time`: s, for whose approach contacts are made, until they are made again.
  void find_contacts(JobPool& jobs, const Boundary& boundary, Real speculative_time, const Vec3& gravity,
                     bool push_out);
  void record_contact_states(const Boundary& boundary);
  void share_bodies(Boundary& boundary);  // sums the contact weights of each body
  // Adds the impulses of this iteration to bodies that the fluid does not move.
  void weigh_fixed(Boundary& boundary, const StepContext& c) const;
  // Non-penetration projection: moves every particle out of the boundary, swept from where its contact was made, and
  // ends closing velocities, or leaves velocities to the next substep.
  void project_out(Boundary& boundary, JobPool& jobs, bool velocities = true);
  void move_out(std::uint32_t i, Boundary& boundary, bool velocities);  // one of them
  Real safe_travel() const;
  void find_fast_shapes(const Boundary& boundary);
  template <class F>
  void each_missed(std::uint32_t i, const Boundary& boundary, F&& f) const;

  bool meets(const BoundaryShape& w) const { return (desc.group & w.mask) && (w.group & desc.mask); }
  bool meets(const FluidPool& o) const { return (desc.group & o.desc.mask) && (o.desc.group & desc.mask); }
};

// Of a fluid over that of a body, or the other way round; of two fluids: FluidSolver::most_density_ratio().
inline constexpr Real kMaxDensityRatio = 10000;
inline constexpr Real kMostSpacings = Real(1.2501);  // ratio of two spacings up to which fluids are solved as one

}  // namespace feder
