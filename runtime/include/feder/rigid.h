// Rigid bodies and joints: the system that owns them ("rigid"), and the solver that moves them.
// SI units, radians, world axes unless stated otherwise. SceneError on impossible input or a destroyed object, nothing
// changed. One thread at a time, that of the world.
#pragma once
#include <memory>
#include <span>
#include <string>

#include "feder/body.h"
#include "feder/joint.h"
#include "feder/system.h"

namespace feder {

struct Bodies;
struct JointKind;

class Rigid final : public System {
 public:
  static constexpr const char* kName = "rigid";
  static const SystemDescriptor& descriptor();
  explicit Rigid(SystemSetup& setup);
  ~Rigid() override;

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // bodies
  void hash(Hash& h) const override;
  void save(Writer& w) const override;
  void load(Reader& r) override;
  Energy energy(const Vec3& gravity) const override;
  Momentum momentum() const override;
  void residuals(std::vector<Residual>& out) const override;  // rigid.joint_error_m, ...
  bool finite() const override;
  void validate() const override;
  double held(const StepContext& c) override;
  double drive(const StepContext& c) override;

  // Bodies. SceneError on impossible input, nothing changed.
  ObjectId add_body(const BodyDesc& desc);
  void destroy_body(ObjectId body, const std::string& where);  // and its joints; end events are queued
  const Bodies& bodies() const;
  std::span<const ObjectId> moved() const;  // awake in the last step, also if destroyed since; none after a load
  std::uint32_t index(ObjectId body) const;

  Pose pose(ObjectId body) const;                    // of the body frame's origin
  void set_pose(ObjectId body, const Pose& origin);  // teleport
  Vec3 velocity(ObjectId body) const;                // of the centre of mass, m/s
  Vec3 angular_velocity(ObjectId body) const;        // rad/s
  BodyType type(ObjectId body) const;
  bool asleep(ObjectId body) const;  // a dynamic or kinematic body that is not awake
  void set_velocity(ObjectId body, const Vec3& v);
  void set_angular_velocity(ObjectId body, const Vec3& w);
  void apply_force(ObjectId body, const Vec3& force, const Vec3* world_point);  // until the end of the next step
  void apply_torque(ObjectId body, const Vec3& torque);
  void apply_impulse(ObjectId body, const Vec3& impulse, const Vec3* world_point);  // now
  void apply_angular_impulse(ObjectId body, const Vec3& impulse);
  void move_to(ObjectId body, const Pose& origin);  // kinematic: pose at the end of the next step
  void set_type(ObjectId body, BodyType type);
  // A solid cut out of a body of one shape, or welded on, at `place` in the body frame; the body's shape becomes a
  // field. Density and the motion of each point stay. Parts that come off become bodies (event "carved"). SceneError
  // when nothing is left.
  void carve(ObjectId body, const ShapePtr& tool, const Pose& place);
  void weld_on(ObjectId body, const ShapePtr& shape, const Pose& place);
  void set_filter(ObjectId body, std::uint32_t group, std::uint32_t mask);
  void set_friction(ObjectId body, Real fixed, Real dynamic);
  void set_restitution(ObjectId body, Real e);
  void set_surface_velocity(ObjectId body, const Vec3& v);
  void set_damping(ObjectId body, Real linear, Real angular);
  void set_gravity_scale(ObjectId body, Real scale);
  void set_sensor(ObjectId body, bool sensor, bool senses_fixed = false);
  void wake(ObjectId body, WakeCause cause = WakeCause::script, ObjectId other = {});  // and its island
  void sleep(ObjectId body);
  void wake_all(WakeCause cause);
  Real mass(ObjectId body) const;
  Mat3 inertia(ObjectId body) const;         // about the centre of mass, body axes
  Vec3 center_of_mass(ObjectId body) const;  // world

  // Joints.
  ObjectId add_joint(const JointDesc& desc);
  void destroy_joint(ObjectId joint, const std::string& where);
  Vec3 joint_force(ObjectId joint) const;       // on b, last step, N
  Vec3 joint_torque(ObjectId joint) const;      // N m
  Real joint_coordinate(ObjectId joint) const;  // hinge angle (rad), distance (m)
  void set_motor(ObjectId joint, Real speed, Real max_force);
  void set_limits(ObjectId joint, Real lower, Real upper);
  Real max_joint_error() const;  // largest violated equality now, m
  std::size_t joint_count() const;
  // Joint geometry now, world: both anchors (equal up to the joint error, unless the kind separates them) and its axis.
  struct JointInfo {
    const JointKind* kind = nullptr;
    ObjectId a, b;  // b none: the world
    Vec3 anchor_a = Vec3::Zero(), anchor_b = Vec3::Zero(), axis = Vec3::Zero();
  };
  JointInfo joint_info(ObjectId joint) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace feder
