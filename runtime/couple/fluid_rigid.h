// Fluids and rigid bodies in one world: bodies are the fluid's boundary, and the fluid pushes them in the same substep.
// Buoyancy and drag have no model of their own: they are the sums of pressure and viscosity at the boundary.
#pragma once
#include "feder/fluid.h"
#include "feder/rigid.h"
#include "feder/system.h"
#include "fluid/boundary.h"
#include "state/colliders.h"
#include "state/contact_book.h"
#include "state/solver_bodies.h"

namespace feder {

class FluidRigid final : public System {
 public:
  static constexpr const char* kName = "fluid_rigid";
  static const SystemDescriptor& descriptor();
  explicit FluidRigid(SystemSetup& setup);
  ~FluidRigid() override;

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // boundary shapes
  void hash(Hash& h) const override;
  void save(Writer&) const override {}
  void load(Reader&) override { inside_.clear(), fluid_contacts_.clear(); }
  void validate() const override;
  void residuals(std::vector<Residual>& out) const override;  // fluid_rigid.impulse_mismatch, .impulse_ns

 private:
  // Particles of a fluid in a sensor.
  struct Inside {
    ObjectId sensor, fluid;
    std::uint32_t count = 0;
  };
  void list_boundary();                     // all colliders of bodies that fluids may meet
  void place_boundary(bool between_steps);  // poses and velocities as the solver bodies have them
  void weigh_fluids(const StepContext& c, double (&sum)[3]) const;  // kg m/s of all particles
  // Momentum that the fluids lost since `before_`, without that of gravity over g h m/s and of forces, against what
  // the bodies gained.
  void compare_impulses(const StepContext& c, const Vec3& gravity_seconds);

  // Passes.
  void compare_densities(StepContext& c);  // of bodies that are new, and fluids
  void collect(StepContext& c);
  void carry_emitters(StepContext& c);
  void carry_drains(StepContext& c);
  void place_for_queries(StepContext& c);
  void set_boundary(StepContext& c);
  void weigh(StepContext& c);
  void give_velocities(StepContext& c);  // back to the solver bodies
  void push_again(StepContext& c);
  void follow_stopped(StepContext& c);
  void keep_awake(StepContext& c);
  Real pressed_on(ObjectId body) const;  // N s in this step
  void report_contacts(StepContext& c);
  void report_sensors(StepContext& c);

  Arena& arena_;
  Fluid& fluid_;
  Rigid& rigid_;
  Colliders& colliders_;
  SolverBodies& solver_bodies_;
  Boundary& boundary_;
  Objects& objects_;
  ContactBook& contacts_;
  const std::uint32_t finder_;                        // of contacts and of fluids in sensors
  Array<std::uint32_t> collider_{&arena_};            // by boundary shape
  Array<std::uint32_t> body_{&arena_};                // by boundary body: index in Bodies
  Array<std::uint32_t> index_of_body_{&arena_};       // by body: in Boundary::bodies; kNone: not there
  Array<FluidCarrier> carriers_{&arena_};             // bodies that emitters and drains ride on
  Array<Inside> inside_{&arena_};                     // of this step
  Array<FluidContactState> fluid_contacts_{&arena_};  // of this step, by fluid, then body
  Array<ObjectId> compared_{&arena_};                 // by body: whose density has been compared with the fluids'
  Array<ObjectId> warned_{&arena_};                   // bodies of which there was a warning
  double before_[3] = {0, 0, 0};                      // momentum of the fluids when the boundary was placed, kg m/s
  double mismatch_ = 0, given_ = 0;                   // N s, of the last step: largest of a substep, and sum
  double pushed_ = 0;                                 // N s, on bodies that move
};

}  // namespace feder
