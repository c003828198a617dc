// Nets and rigid bodies in one world: contact of net points that have a radius, and attachments of points to bodies.
// Exists as soon as a world has both. Two-way: momentum passes both ways in the same substep.
#pragma once
#include "feder/net.h"
#include "feder/query.h"
#include "feder/rigid.h"
#include "feder/system.h"
#include "state/colliders.h"
#include "state/particles.h"
#include "state/solver_bodies.h"

namespace feder {

class SpringsRigid final : public System {
 public:
  static constexpr const char* kName = "springs_rigid";
  static const SystemDescriptor& descriptor();
  explicit SpringsRigid(SystemSetup& setup);

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // coupled points
  void hash(Hash&) const override {}   // all state is that of the two systems
  void save(Writer&) const override {}
  void load(Reader&) override {}
  void validate() const override;
  void residuals(std::vector<Residual>& out) const override;  // springs_rigid.attachment_error_m

 private:
  // A net point that collides or is attached.
  struct Coupled {
    std::uint32_t particle = 0;
    std::uint32_t solver_index = 0;  // in SolverBodies this step; 0 = pinned
    Vec3 before = Vec3::Zero();      // position before the substep, m
    Vec3 given = Vec3::Zero();       // velocity that the solver started with, m/s
    Vec3 given_delta_position = Vec3::Zero();
    Real added = 0;         // inertia of the bodies it carries in this step, kg
    bool implicit = false;  // net's integrator
    bool attached = false;
  };
  // An attachment this step.
  struct Attachment {
    std::uint32_t coupled = 0;       // index in coupled_
    std::uint32_t body = 0;          // index in Bodies
    std::uint32_t solver_index = 0;  // body's slot in SolverBodies; 0 = does not move
    Vec3 local = Vec3::Zero();       // from the centre of mass, body axes, m
    Mat3 mass = Mat3::Zero();        // effective, of the three rows, kg
    Vec3 arm = Vec3::Zero();         // world, now, m
  };

  // Structure: colliders, solver bodies and the list of coupled points brought up to date.
  void sync();
  void sync_collider(std::uint32_t particle, const Springs::NetInfo& net, bool attached);
  void release_removed();
  std::uint32_t find_coupled(std::uint32_t particle) const;

  // Passes.
  void update_boxes(StepContext& c);
  void append(StepContext& c);
  void before_integrate(StepContext& c);
  void after_integrate(StepContext& c);
  void hand_over(StepContext& c);
  void read_back(StepContext& c);
  void read_back_velocities(StepContext& c);
  void keep_awake(StepContext& c);

  void find_attachments();
  void add_carried_mass();
  void center_contacts(StepContext& c);
  void warn_soft_contact(std::uint32_t collider, StepContext& c);
  // Velocity projection of all attachments; `rate` times the position error is taken out as velocity (1/s).
  void solve_attachments(int rounds, Real rate);
  Vec3 attachment_error(const Attachment& k) const;  // point minus anchor, m
  Mat3 body_response(const Attachment& k) const;     // velocity of the anchor per impulse on it, 1/kg

  Arena& arena_;
  Springs& springs_;
  Rigid& rigid_;
  Collide& collide_;
  Colliders& colliders_;
  SolverBodies& solver_bodies_;
  Particles& particles_;
  Objects& objects_;
  bool* structure_changed_;
  Array<Coupled> coupled_{&arena_};  // ascending by particle
  Array<Attachment> attachments_{&arena_};
  Array<std::uint32_t> attached_to_{&arena_};  // attachments by body
  bool warned_ = false;                        // "implicit_contact"
};

}  // namespace feder
