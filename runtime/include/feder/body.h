// Description of a rigid body, for Rigid::add_body. Plain data: no errors before it is used there.
#pragma once
#include <string>

#include "feder/events.h"
#include "feder/object.h"
#include "feder/shape.h"
#include "feder/types.h"

namespace feder {

inline constexpr ObjectKind kBodyKind{"body", "bodies"};
// A body was carved or welded; b: what came off as a body of its own, one event each.
inline constexpr EventKind kCarved{"carved", EventKind::kOther};

enum class BodyType : std::uint8_t { free, fixed, kinematic, dynamic };  // fixed = "static" in Lua

// Locked degrees of freedom, world axes.
enum LockBits : std::uint8_t { kLockX = 1, kLockY = 2, kLockZ = 4, kLockRx = 8, kLockRy = 16, kLockRz = 32 };

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
  bool bullet = false;    // passes through no moving body either; fixed ones stop all, however fast
  bool sleeping = false;  // starts asleep
  bool can_sleep = true;
  Real sleep_threshold = Real(0.04);  // m/s: what stays slower falls asleep
  std::uint8_t lock = 0;              // LockBits
  std::uint32_t group = 1, mask = 0xffffffffu;
  bool sensor = false;
  bool senses_fixed = false;  // of a sensor: static bodies too
  std::string material;

  // Calls f(field) for all of them, in this order.
  template <class D, class F>
  static void each_field(D& d, F&& f) {
    f(d.name), f(d.tags), f(d.type), f(d.shape), f(d.position), f(d.rotation), f(d.velocity), f(d.angular_velocity);
    f(d.density), f(d.mass), f(d.has_center), f(d.center_of_mass), f(d.friction_static), f(d.friction_dynamic);
    f(d.restitution), f(d.rolling_friction), f(d.surface_velocity), f(d.linear_damping), f(d.angular_damping);
    f(d.gravity_scale), f(d.bullet), f(d.sleeping), f(d.can_sleep), f(d.sleep_threshold), f(d.lock), f(d.group),
        f(d.mask);
    f(d.sensor), f(d.senses_fixed), f(d.material);
  }
};

}  // namespace feder
