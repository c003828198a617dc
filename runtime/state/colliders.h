// Colliders: a shape on an owner (a body, or a net point). Indexed by a stable collider index. A compound body has
// one collider per child. The owner writes pose and box in `bounds`; collide reads.
#pragma once
#include <algorithm>
#include <cmath>
#include <memory>

#include "feder/memory.h"
#include "feder/object.h"
#include "feder/shape.h"
#include "feder/types.h"
#include "state/arrays.h"

namespace feder {

enum class ColliderOwner : std::uint8_t { body, point };                       // point: of a surface
enum class ColliderMotion : std::uint8_t { none, fixed, kinematic, dynamic };  // none: a free index
inline constexpr std::uint8_t kSensesAll = 1, kSensesMoving = 2;               // of a sensor; moving: no fixed bodies

// What the part of the shape states itself, so that edits of the body do not reach it.
enum SurfaceBits : std::uint8_t {
  kStatesStatic = 1,
  kStatesDynamic = 2,
  kStatesRestitution = 4,
  kStatesRolling = 8,
  kStatesVelocity = 16,
};

inline std::uint8_t sensing(bool sensor, bool senses_fixed) {
  return !sensor ? std::uint8_t(0) : senses_fixed ? kSensesAll : kSensesMoving;
}

struct Colliders {
  explicit Colliders(Arena& a) : arena(a) {}

  Arena& arena;
  Array<ColliderMotion> motion{&arena};
  Array<std::uint8_t> awake{&arena};   // owner awake (kinematic: moving)
  Array<std::uint8_t> sensor{&arena};  // 0: none
  Array<std::uint8_t> bullet{&arena};
  Array<const Shape*> shape{&arena};  // kept alive by `shapes`
  Array<ColliderOwner> owner{&arena};
  Array<std::uint32_t> owner_index{&arena};   // body index, or particle index
  Array<std::uint32_t> solver_slot{&arena};   // slot in SolverBodies; kNone for fixed
  Array<ObjectId> object{&arena};             // reported in events
  Array<std::uint32_t> sub{&arena};           // point number within the object (nets), else 0
  Array<std::uint32_t> next_of_body{&arena};  // next collider of the same body
  Array<Pose> local{&arena};                  // in the owner's centre-of-mass frame
  Array<Pose> pose{&arena};                   // world, start of the step
  Array<Aabb> box{&arena};                    // world, with margin and this step's motion; unbounded for planes
  Array<Vec3> center{&arena};                 // owner's centre of mass, world, m
  Array<Vec3> velocity{&arena};               // owner's, m/s
  Array<Vec3> angular_velocity{&arena};       // owner's, rad/s
  Array<Real> friction_static{&arena}, friction_dynamic{&arena}, restitution{&arena}, rolling_friction{&arena};
  Array<Vec3> surface_velocity{&arena};              // in the owner's frame, m/s (conveyor)
  Array<std::uint8_t> stated{&arena};                // SurfaceBits
  Array<std::uint16_t> material{&arena};             // 0 = none; index into the world's material names
  Array<std::uint32_t> group{&arena}, mask{&arena};  // collide when (group_a & mask_b) and (group_b & mask_a)
  Array<std::uint32_t> free_list{&arena};
  // Since the last step, in any order, also more than once. What is awake is looked at in every step; all else only
  // when it is in one of these lists, so that colliders at rest cost nothing.
  Array<std::uint32_t> changed{&arena};                // filter, type or pose changed by script: pairs are re-examined
  Array<std::uint32_t> touched{&arena};                // woken, removed, or another surface or box
  Array<std::shared_ptr<const Shape>> shapes{&arena};  // by collider index

  std::uint32_t size() const { return static_cast<std::uint32_t>(motion.size()); }
  std::uint32_t add();  // index with defaults: fixed, group 1, mask all
  void set_awake(std::uint32_t i, bool is) {
    if (awake[i] == std::uint8_t(is)) return;
    awake[i] = is;
    touched.push_back(i);
  }
  void remove(std::uint32_t i);
  void validate() const;  // asserts what holds of the arrays by themselves

  // The body that owns it; kNone: none does.
  std::uint32_t body_of(std::uint32_t i) const { return owner[i] == ColliderOwner::body ? owner_index[i] : kNone; }
  bool meets_nothing(std::uint32_t i) const { return group[i] == 0 || mask[i] == 0; }
  // A part of a body that a filter of these bits collides with.
  bool meets(std::uint32_t i, std::uint32_t its_group, std::uint32_t its_mask) const {
    return motion[i] != ColliderMotion::none && !sensor[i] && owner[i] == ColliderOwner::body &&
           (group[i] & its_mask) != 0 && (its_group & mask[i]) != 0;
  }
  Real fastest() const {  // m/s, of all owners
    Real most = 0;
    for (std::uint32_t i = 0; i < size(); ++i)
      if (motion[i] > ColliderMotion::fixed) most = std::max(most, dot(velocity[i], velocity[i]));
    return std::sqrt(most);
  }
  // Box of its motion within `seconds`, for times longer than the step that `box` includes.
  Aabb swept(std::uint32_t i, Real seconds) const {
    Aabb all = box[i];
    if (motion[i] == ColliderMotion::fixed) return all;
    const Vec3 travel = seconds * velocity[i];
    all.include(Aabb{box[i].lo + travel, box[i].hi + travel});
    return all;
  }

  // Shapes stay in memory while a snapshot may need them: a snapshot belongs to the world that made it.
  mutable std::vector<std::shared_ptr<const Shape>> pinned;

  // Calls f(array) for each of the plain arrays that have an entry per collider.
  template <class C, class F>
  static void each_array(C& c, F&& f) {
    for_each_of(f, c.motion, c.awake, c.sensor, c.bullet, c.owner, c.owner_index, c.solver_slot, c.object, c.sub,
                c.next_of_body, c.local, c.pose, c.box, c.center, c.velocity, c.angular_velocity, c.friction_static,
                c.friction_dynamic, c.restitution, c.rolling_friction, c.surface_velocity, c.stated, c.material,
                c.group, c.mask);
  }
  // Calls f(member) for what snapshots hold as it is; shapes go by their index in `pinned`.
  template <class C, class F>
  static void each_saved(C& c, F&& f) {
    each_array(c, f);
    for_each_of(f, c.free_list, c.changed);
  }
  void save(Writer& w) const;
  void load(Reader& r);
};

}  // namespace feder
