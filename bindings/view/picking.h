// What picking, the camera and a reload do with the objects of one system. One ObjectView per system that has things
// to take hold of (picking_<system>.cpp); objects of other systems are only drawn. Reads the world; what it wants done
// comes back as commands.
#pragma once
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "feder/lua.h"
#include "feder/world.h"

namespace feder::view {

// What somebody does to a running scene between two steps. Errors are exceptions.
using Command = std::function<void(lua::Script&)>;

struct Ray {
  Vec3 origin = Vec3::Zero(), direction = Vec3(0, 0, -1);  // unit
};

// What a ray meets first.
struct Pick {
  ObjectId object;
  std::uint32_t point = kNone;   // of an object made of points
  Vec3 position = Vec3::Zero();  // world, m
  Real depth = 0;                // along the ray, m
  bool movable = false;          // a dynamic body or a point
};

struct Grip {
  ObjectId object;
  std::uint32_t point = kNone;  // it is pinned while it is held
  bool was_pinned = false;
  Vec3 local = Vec3::Zero();   // in the object's frame, m
  Vec3 target = Vec3::Zero();  // where the mouse wants it, world, m
};

// A state that can go on in a new world.
struct Kept {
  std::vector<Vec3> position, velocity;  // m, m/s (of a body the second velocity is angular, rad/s)
  Quat rotation;
};

class ObjectView {
 public:
  virtual ~ObjectView() = default;
  virtual const ObjectKind& kind() const = 0;

  // Puts what the ray meets into `best` and its depth into `depth`, when it is nearer than that. `slack`: radians by
  // which the ray may miss a point.
  virtual void pick(World& world, const Ray& ray, Real slack, Real& depth, std::optional<Pick>& best) const = 0;
  virtual bool has_point(World&, ObjectId, std::uint32_t /*point*/) const { return false; }
  // Of a point (kNone: of the object), or of `local` in its frame.
  virtual Vec3 position(World& world, ObjectId object, std::uint32_t point, const Vec3& local) const = 0;
  // What a name on the screen stands beside.
  virtual std::pair<std::string, Vec3> landmark(World& world, ObjectId object) const = 0;

  virtual Grip grip(World& world, const Pick& pick) const = 0;
  // What has to be done when it is taken, before each step, and when it is let go. Letting go throws: the speed stays.
  virtual Command take(const Grip& grip) const = 0;
  virtual Command pull(World& world, const Grip& grip) const = 0;
  virtual Command release(World& world, const Grip& grip, bool pin) const = 0;
  virtual bool is_pinned(World& world, const Pick& pick) const = 0;
  virtual Command set_pinned(const Pick& pick, bool pinned) const = 0;

  virtual bool keeps(World& world, ObjectId object) const = 0;
  virtual Kept state(World& world, ObjectId object) const = 0;
  // `built` is how the object starts in the old scene; false when the new one starts it in another way.
  virtual bool apply(World& world, ObjectId object, const Kept& built, const Kept& now) const = 0;

  Vec3 away(World& world, const Grip& grip) const;  // from the held place to the target
};

std::span<const ObjectView* const> object_views();
// Null when nothing can be done with such an object.
const ObjectView* view_of(const World& world, ObjectId object);

// What a ray meets, and how a grip pulls; nothing acts unless something is held.
std::optional<Pick> pick(World& world, const Ray& ray, Real slack);
bool alive(World& world, const Grip& grip);
Grip grip(World& world, const Pick& pick);           // of what was picked just now
Vec3 grip_position(World& world, const Grip& grip);  // of the held place now; it must be alive

// Holds a movable thing in its place, or frees it again. Empty for what cannot be pinned.
Command pin_command(World& world, const Pick& pick);
bool is_pinned(World& world, const Pick& pick);

// Lua text that shoots a ball along the ray; `number` makes its name.
std::string shot_text(const World& world, const Ray& ray, Real radius, Real speed, int number);

}  // namespace feder::view
