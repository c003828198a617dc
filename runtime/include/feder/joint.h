// Description of a joint between two bodies, or a body and the world, for Rigid::add_joint. Plain data.
#pragma once
#include <string>

#include "feder/events.h"
#include "feder/object.h"
#include "feder/types.h"

namespace feder {

inline constexpr ObjectKind kJointKind{"joint", "joints"};
inline constexpr EventKind kJointBreak{"joint_break", EventKind::kForce};

// Options of all kinds of joints; a kind refuses (SceneError) those that it does not use.
struct JointOptions {
  Real lower = -kInfinity, upper = kInfinity;  // limits, m or rad
  bool has_limits = false;
  Real motor_speed = 0, motor_max = 0;  // m/s or rad/s; N or N m
  bool has_motor = false;
  Real spring_hertz = 0, spring_damping = 1;  // 0 hertz: rigid
  Real rest_length = -1;                      // distance; < 0: as built

  template <class O, class F>
  static void each_field(O& o, F&& f) {
    f(o.lower), f(o.upper), f(o.has_limits), f(o.motor_speed), f(o.motor_max), f(o.has_motor), f(o.spring_hertz);
    f(o.spring_damping), f(o.rest_length);
  }
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

  // Calls f(field) for all of them, in this order.
  template <class D, class F>
  static void each_field(D& d, F&& f) {
    f(d.name), f(d.tags), f(d.type), f(d.a), f(d.b), f(d.anchor_a), f(d.anchor_b), f(d.axis), f(d.options);
    f(d.break_force), f(d.collide);
  }
};

}  // namespace feder
