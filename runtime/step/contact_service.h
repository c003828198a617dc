// What owners of colliders (rigid bodies, net points) may ask of collision detection, and what it asks of them.
// The system named "collide" implements it; owners find it by name and know no more of it.
#pragma once
#include <string_view>

#include "geom/shape.h"
#include "state/objects.h"

namespace feder {

class ContactService {
 public:
  static constexpr const char* kSystem = "collide";  // also the arena of Colliders and Contacts
  virtual ~ContactService() = default;

  // Pairs of objects that never touch, whatever their filters (joined bodies). Counted: exclude twice, include twice.
  virtual void exclude(ObjectId a, ObjectId b) = 0;
  virtual void include(ObjectId a, ObjectId b) = 0;

  // A collider is about to go, to be switched to another filter or type, or to be teleported: its contacts are
  // removed now, and their end events queued.
  virtual void forget(std::uint32_t collider) = 0;

  // SceneError when this build has no test for the shape with one that is there already. Before its collider is added.
  virtual void check_shape(const Shape& shape) const = 0;

  // The number of a named material, made on first use. Number 0 is "no material".
  virtual std::uint16_t material(std::string_view name) = 0;
};

}  // namespace feder
