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

namespace feder {

enum class ColliderOwner : std::uint8_t { body, point };                       // point: of a surface
enum class ColliderMotion : std::uint8_t { none, fixed, kinematic, dynamic };  // none: a free index

struct Colliders {
  explicit Colliders(Arena& a)
      : motion(&a), awake(&a), sensor(&a), bullet(&a), shape(&a), owner(&a), owner_index(&a), solver_slot(&a),
        object(&a), sub(&a), next_of_body(&a), local(&a), pose(&a), box(&a), center(&a), velocity(&a),
        angular_velocity(&a), friction_static(&a), friction_dynamic(&a), restitution(&a), rolling_friction(&a),
        surface_velocity(&a), material(&a), group(&a), mask(&a), free_list(&a), changed(&a), shapes(&a) {}

  Array<ColliderMotion> motion;
  Array<std::uint8_t> awake;  // owner awake (kinematic: moving)
  Array<std::uint8_t> sensor;
  Array<std::uint8_t> bullet;
  Array<const Shape*> shape;  // kept alive by `shapes`
  Array<ColliderOwner> owner;
  Array<std::uint32_t> owner_index;   // body index, or particle index
  Array<std::uint32_t> solver_slot;   // slot in SolverBodies; kNone for fixed
  Array<ObjectId> object;             // reported in events
  Array<std::uint32_t> sub;           // point number within the object (nets), else 0
  Array<std::uint32_t> next_of_body;  // next collider of the same body
  Array<Pose> local;                  // in the owner's centre-of-mass frame
  Array<Pose> pose;                   // world, start of the step
  Array<Aabb> box;                    // world, with margin and this step's motion; unbounded for planes
  Array<Vec3> center;                 // owner's centre of mass, world, m
  Array<Vec3> velocity;               // owner's, m/s
  Array<Vec3> angular_velocity;       // owner's, rad/s
  Array<Real> friction_static, friction_dynamic, restitution, rolling_friction;
  Array<Vec3> surface_velocity;      // in the owner's frame, m/s (conveyor)
  Array<std::uint16_t> material;     // 0 = none; index into the world's material names
  Array<std::uint32_t> group, mask;  // collide when (group_a & mask_b) and (group_b & mask_a)
  Array<std::uint32_t> free_list;
  Array<std::uint32_t> changed;  // filter, type or pose changed by script since the last step: pairs are re-examined
  Array<std::shared_ptr<const Shape>> shapes;  // by collider index

  std::uint32_t size() const { return static_cast<std::uint32_t>(motion.size()); }
  std::uint32_t add();  // index with defaults: fixed, group 1, mask all
  void remove(std::uint32_t i);
  void validate() const;  // asserts what holds of the arrays by themselves

  // Is it a part of a body that something with this filter collides with?
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
  // Where it may be within so much time: `box` may look less far ahead than a fast owner comes.
  Aabb swept(std::uint32_t i, Real seconds) const {
    Aabb all = box[i];
    if (motion[i] == ColliderMotion::fixed) return all;
    const Vec3 travel = seconds * velocity[i];
    all.include(Aabb{box[i].lo + travel, box[i].hi + travel});
    return all;
  }

  // Shapes stay in memory while a snapshot may need them: a snapshot belongs to the world that made it.
  mutable std::vector<std::shared_ptr<const Shape>> pinned;

  void save(Writer& w) const;
  void load(Reader& r);
};

}  // namespace feder
