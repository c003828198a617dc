// Rigid bodies and joints: the system that owns them, and the solver that moves them.
#pragma once
#include <string>

#include "constrain/joint.h"
#include "geom/shape.h"
#include "state/bodies.h"
#include "state/colliders.h"
#include "step/system.h"

namespace feder {

inline constexpr ObjectKind kJointKind{"joint", "joints"};
inline constexpr EventKind kJointBreak{"joint_break", EventKind::kForce};

struct BodyDesc {
  std::string name;
  TagMask tags = 0;
  BodyType type = BodyType::dynamic;
  ShapePtr shape;                // required
  Vec3 position = Vec3::Zero();  // of the body frame's origin, m
  Quat rotation;
  Vec3 velocity = Vec3::Zero();          // of the centre of mass, m/s
  Vec3 angular_velocity = Vec3::Zero();  // rad/s
  Real density = 1000;                   // kg/m^3 (dimension 2: kg/m^2), used unless mass > 0
  Real mass = 0;                         // kg; > 0 overrides the density (inertia scales along)
  bool has_center = false;
  Vec3 center_of_mass = Vec3::Zero();  // body frame, when has_center
  Real friction_static = Real(0.5), friction_dynamic = Real(0.5);
  Real restitution = 0;
  Real rolling_friction = 0;                     // lever arm, m
  Vec3 surface_velocity = Vec3::Zero();          // body frame, m/s
  Real linear_damping = 0, angular_damping = 0;  // 1/s
  Real gravity_scale = 1;
  bool bullet = false;
  bool sleeping = false;  // starts asleep
  bool can_sleep = true;
  std::uint8_t lock = 0;  // LockBits
  std::uint32_t group = 1, mask = 0xffffffffu;
  bool sensor = false;
  std::string material;
};

struct JointDesc {
  std::string name;
  TagMask tags = 0;
  std::string type;                                       // a name of joint_kinds()
  ObjectId a, b;                                          // b none: the world
  Vec3 anchor_a = Vec3::Zero(), anchor_b = Vec3::Zero();  // world, m (kinds with one anchor use anchor_a)
  Vec3 axis = Vec3(0, 0, 1);                              // world, for kinds with an axis
  JointOptions options;
  Real break_force = kInfinity;  // N
  bool collide = false;          // joined bodies collide with each other
};

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
  std::uint32_t index(ObjectId body) const;

  Pose pose(ObjectId body) const;                    // of the body frame's origin
  void set_pose(ObjectId body, const Pose& origin);  // teleport
  void set_velocity(ObjectId body, const Vec3& v);
  void set_angular_velocity(ObjectId body, const Vec3& w);
  void apply_force(ObjectId body, const Vec3& force, const Vec3* world_point);  // until the end of the next step
  void apply_torque(ObjectId body, const Vec3& torque);
  void apply_impulse(ObjectId body, const Vec3& impulse, const Vec3* world_point);  // now
  void apply_angular_impulse(ObjectId body, const Vec3& impulse);
  void move_to(ObjectId body, const Pose& origin);  // kinematic: pose at the end of the next step
  void set_type(ObjectId body, BodyType type);
  void set_filter(ObjectId body, std::uint32_t group, std::uint32_t mask);
  void set_friction(ObjectId body, Real fixed, Real dynamic);
  void set_restitution(ObjectId body, Real e);
  void set_surface_velocity(ObjectId body, const Vec3& v);
  void set_damping(ObjectId body, Real linear, Real angular);
  void set_gravity_scale(ObjectId body, Real scale);
  void set_sensor(ObjectId body, bool sensor);
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
  // Where a joint is now, world: both anchors (equal while it holds, unless its kind keeps them apart) and its axis.
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
