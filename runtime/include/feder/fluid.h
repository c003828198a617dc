// Particle fluids: sets of particles with a solver each, fed by emitters, emptied by drains, contained by
// boundaries (bodies, faces of cloths and nets, by couplings). Fluids whose groups and masks let them touch are solved
// as one where they do, without mixing; they need one solver, kernel, integrator, search, support and wall_slip
// (SceneError), and spacings that differ by 1.25 at most (else a warning where they meet). SI units; densities kg/m^3,
// in dimension 2 kg/m^2. SceneError on impossible input, nothing changed. One thread at a time, that of the world;
// queries that fill `out` replace its content.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "feder/shape.h"
#include "feder/system.h"

namespace feder {

inline constexpr ObjectKind kFluidKind{"fluid", "fluids"}, kEmitterKind{"emitter", "emitters"},
    kDrainKind{"drain", "drains"};
inline constexpr WakeCause kFluidCause{"fluid"};
// Of an emitter or drain, and its fluid: how many particles.
inline constexpr EventKind kEmitterDone{"emitter_done", EventKind::kOther | EventKind::kAmount},
    kDrained{"drained", EventKind::kOther | EventKind::kAmount};

struct FluidPool;
struct FluidContactState;
struct Boundary;

// dfsph, its kernel and grid, or the first of this build where those are left out.
std::string default_fluid_solver();
std::string default_fluid_kernel(std::string_view solver);
std::string default_fluid_neighbors();
std::string default_surface_model(std::string_view solver);

struct FluidDesc {
  std::string name;
  TagMask tags = 0;
  Real spacing = Real(0.05);  // between particles at rest, m
  Real density = 1000;        // at rest, kg/m^3 (dimension 2: kg/m^2)
  Real viscosity = 0;         // dynamic, Pa s; acts at boundaries as well, unless wall_slip is "free"
  std::string wall_slip = "none";
  Real surface_tension = 0;   // N/m
  std::string surface_model;  // "color_field" (dfsph), "cohesion"; empty: the first that the solver bears
  Real adhesion = 0;          // work of adhesion to the boundary, N/m: tension times 1 + cos(contact angle); 0: none
  Real friction = 0;   // of particles on cloth and faces of nets, a coefficient of Coulomb; solids: see wall_slip
  Real vorticity = 0;  // confinement, 1/s: adds energy and turns no more than the momentum allows; for pictures
  std::string solver = default_fluid_solver();
  std::string kernel;            // empty: wendland for dfsph, cubic for others
  std::string viscosity_kernel;  // empty: that of `kernel`
  std::string neighbors = default_fluid_neighbors();
  Real support = 0;                     // of the kernel, in spacings; 0: what the kernel proposes
  Real stiffness = 0;                   // bulk modulus, Pa; 0: as stiff as the solver can make it
  int iterations = 4;                   // pbf, per substep
  Real tolerance = Real(0.1);           // dfsph, mean error of the density, per cent
  Real negative_pressure = 0;           // dfsph: suction that it bears, in atmospheres, 0 to 1
  Real compression = 0;                 // wanted: wcsph at the largest pressure, pbf mean; 0: wcsph 0.01, pbf 0.05
  Real artificial_viscosity = 0;        // wcsph, alpha of Monaghan
  std::string integrator = "leapfrog";  // wcsph: or "symplectic_euler"
  int max_substeps = 60;                // largest number of solver substeps in a substep of the world
  std::size_t max_particles = 1000000;
  Real gravity_scale = 1;
  Real kill_height = -kInfinity;  // m; particles below it are removed after each step
  std::uint32_t group = 1, mask = 0xffffffffu;

  // Calls f(field) for all of them, in this order.
  template <class D, class F>
  static void each_field(D& d, F&& f) {
    f(d.name), f(d.tags), f(d.spacing), f(d.density), f(d.viscosity), f(d.wall_slip), f(d.surface_tension),
        f(d.surface_model), f(d.adhesion), f(d.friction), f(d.vorticity), f(d.solver), f(d.kernel),
        f(d.viscosity_kernel);
    f(d.neighbors), f(d.support), f(d.stiffness), f(d.iterations), f(d.tolerance), f(d.negative_pressure),
        f(d.compression), f(d.artificial_viscosity), f(d.integrator);
    f(d.max_substeps), f(d.max_particles), f(d.gravity_scale), f(d.kill_height), f(d.group), f(d.mask);
  }
};

struct EmitterDesc {
  std::string name;
  TagMask tags = 0;
  ObjectId body;                 // that it rides on, or none: position and direction are then in the body's frame
  Vec3 position = Vec3::Zero();  // of the nozzle's middle, m
  Vec3 direction = Vec3(0, -1, 0);
  Real speed = 1;           // m/s
  Real radius = Real(0.1);  // of the nozzle, m
  Real rate = 0;            // particles per second; 0: a full jet (layers one spacing apart)
  std::uint64_t limit = 0;  // particles in all; 0: without end

  template <class D, class F>
  static void each_field(D& d, F&& f) {
    f(d.name), f(d.tags), f(d.body), f(d.position), f(d.direction), f(d.speed), f(d.radius), f(d.rate), f(d.limit);
  }
};

// A body that emitters and drains ride on, for the coupling that knows bodies.
struct FluidCarrier {
  ObjectId body;
  Pose pose;                             // of its frame
  Vec3 center = Vec3::Zero();            // of mass, m
  Vec3 velocity = Vec3::Zero();          // of the centre, m/s
  Vec3 angular_velocity = Vec3::Zero();  // rad/s
};

// A fluid at a point, see Fluid::sample; zero where no particle is near.
struct FluidSample {
  Real density = 0;                       // kg/m^3 (dimension 2: kg/m^2)
  Vec3 velocity = Vec3::Zero();           // m/s
  Real pressure = 0;                      // Pa
  Vec3 density_gradient = Vec3::Zero();   // kg/m^4 (dimension 2: kg/m^3)
  Mat3 velocity_gradient = Mat3::Zero();  // row: component of the velocity, column: axis; 1/s
  Vec3 pressure_gradient = Vec3::Zero();  // Pa/m
};

// What moves in a box, see Fluid::flux.
struct FluidFlux {
  double mass = 0;                 // in the box, kg
  double momentum[3] = {0, 0, 0};  // of it, kg m/s
  double rate[3] = {0, 0, 0};      // mass that flows through the box along each axis, kg/s
};

class Fluid final : public System {
 public:
  static constexpr const char* kName = "fluid";
  static constexpr Rank kQuery = Rank::query_boundary;  // World::query
  static const SystemDescriptor& descriptor();
  explicit Fluid(SystemSetup& setup);
  ~Fluid() override;

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // particles
  void hash(Hash& h) const override;
  void save(Writer& w) const override;
  void load(Reader& r) override;
  Energy energy(const Vec3& gravity) const override;
  Momentum momentum() const override;
  void residuals(std::vector<Residual>& out) const override;  // fluid.density_error_max, fluid.clumping ...
  bool finite() const override;
  void validate() const override;
  double held(const StepContext& c) override;

  ObjectId add_fluid(const FluidDesc& desc);
  void destroy_fluid(ObjectId fluid, std::string where);  // and its emitters and drains
  // Tension between two fluids that may touch, N/m; without, the difference of their tensions.
  void set_interface(ObjectId a, ObjectId b, Real tension);

  // Particles on a lattice of the fluid's spacing whose cells lie in the shape; how many. SceneError beyond
  // max_particles.
  std::size_t fill(ObjectId fluid, const Shape& shape, const Pose& pose, const Vec3& velocity);
  std::size_t fill(ObjectId fluid, std::span<const Vec3> points, const Vec3& velocity);
  ObjectId add_emitter(ObjectId fluid, const EmitterDesc& desc);
  // With a body the pose is in its frame.
  ObjectId add_drain(ObjectId fluid, std::string name, TagMask tags, ShapePtr shape, const Pose& pose,
                     ObjectId body = {});
  void destroy_emitter(ObjectId emitter, std::string where);
  void destroy_drain(ObjectId drain, std::string where);
  void set_running(ObjectId emitter, bool running);
  bool running(ObjectId emitter) const;
  std::uint64_t passed(ObjectId source) const;                              // emitted, or drained, so far
  void aim(ObjectId emitter, const Vec3& position, const Vec3& direction);  // in the frame of its body, if it has one

  // A fluid at rest sleeps as a whole, where the world lets things sleep, until something moves it.
  bool asleep(ObjectId fluid) const;
  void wake(ObjectId fluid, WakeCause cause = WakeCause::script, ObjectId other = {});

  // Queries; particles in the order of their making. Those that need neighbours and the boundary (from densities on)
  // are asked of World::query<Fluid>().
  std::size_t particle_count(ObjectId fluid) const;
  void positions(ObjectId fluid, std::vector<Vec3>& out) const;
  void velocities(ObjectId fluid, std::vector<Vec3>& out) const;
  void set_velocities(ObjectId fluid, std::span<const Vec3> v);         // one per particle
  void set_script_forces(ObjectId fluid, std::span<const Vec3> force);  // N, one per particle, until changed
  void clear_script_forces();
  void densities(ObjectId fluid, std::vector<Real>& out);             // over the density at rest
  void pressures(ObjectId fluid, std::vector<Real>& out);             // Pa
  void density_error(ObjectId fluid, double& mean, double& largest);  // excess over the density at rest, as a share
  double clumping(
      ObjectId fluid);  // share of the pairs within the kernel's support that lie closer than half a spacing
  double pressure_at(ObjectId fluid, const Vec3& point);  // Pa, mean over the particles near; 0 where there are none
  // Interpolated from the particles near, with walls: formulas in fluid/sample.cpp.
  FluidSample sample(ObjectId fluid, const Vec3& point);
  // The rate along an axis is the momentum in the box over its extent along the axis: the mean over all sections of the
  // box across the axis of the mass that crosses them, per second. Particles count by the share of their cell (a cube
  // of the spacing) that lies in the box. Dimension 2: boxes in the xy plane.
  FluidFlux flux(ObjectId fluid, const Vec3& lo, const Vec3& hi) const;
  // Height of the free surface at (x, z): where the smoothed fluid begins, from above. False where there is none.
  bool height_at(ObjectId fluid, Real x, Real z, Real& y);
  // Particles whose middle lies in the shape, when the filters let them collide.
  std::uint32_t count_inside(ObjectId fluid, const Shape& shape, const Pose& pose, std::uint32_t group,
                             std::uint32_t mask) const;
  Real particle_mass(ObjectId fluid) const;
  FluidDesc desc(ObjectId fluid) const;
  // Since the fluid was made: solver substeps, and in them iterations for the pressure; wcsph has none.
  std::uint64_t solver_substeps(ObjectId fluid) const;
  std::uint64_t solver_iterations(ObjectId fluid) const;
  ObjectId fluid_of(ObjectId source) const;  // of an emitter or drain

  // For couplings: the boundary of the coming substep, filled before the fluid's passes, and before queries.
  Boundary& boundary();
  // Bodies that sources ride on: appended, once each. The sources move with them; what they add has the velocity of the
  // body where it leaves the nozzle. They do not push back.
  void list_carriers(Array<FluidCarrier>& out) const;
  void carry(std::span<const FluidCarrier> carriers);
  // Bodies that particles were in contact with since clear_contact_states: appended, by fluid, then body.
  void clear_contact_states();
  void list_contact_states(Array<FluidContactState>& out) const;
  std::size_t pool_count() const;
  FluidPool& pool_at(std::size_t n);  // in the order of their making

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace feder
