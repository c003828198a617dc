// A system: it adds passes to the plan and answers the world's questions about its part of the state. A world makes it
// on demand through its descriptor; a host lists the descriptors that its scenes may use. Passes run on the thread that
// steps the world: no exceptions, no logging, no allocation there after warm-up.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "feder/params.h"
#include "feder/plan.h"
#include "feder/snapshot.h"

namespace feder {

struct SurfaceNumbers;

class CommandLog;
class Shape;

struct Energy {
  double kinetic = 0, potential = 0, elastic = 0;  // J
};

struct Momentum {
  double linear[3] = {0, 0, 0};   // kg m/s
  double angular[3] = {0, 0, 0};  // about the world origin, kg m^2/s
};

// One number of World::residuals(): the name says what and in which unit ("rigid.penetration_m").
struct Residual {
  std::string name;
  double value = 0;
};
struct Note {
  ObjectId object;
  std::string text;
};

// Finds the systems a system needs: `find` gives null when absent.
class System;
class SystemFinder {
 public:
  virtual ~SystemFinder() = default;
  virtual System* find_system(std::string_view name) = 0;
};

// What a system is made from.
struct SystemSetup {
  Store& store;
  Objects& objects;
  Events& events;
  const Params& options;  // world option table of that name: world { rigid = { solver = ... } }
  const Params& world;    // top-level choices: broad_phase, narrow_phase
  int dimension;
  SystemFinder& systems;  // those listed in `needs` are there
  CommandLog& commands;
  bool* structure_changed;  // set to true to have the plan rebuilt before the next step
};

class System {
 public:
  virtual ~System() = default;
  virtual void add_passes(StepPlan& plan) = 0;  // only rows that have work: no bodies, no rows
  virtual std::size_t count() const = 0;        // bodies, points ...: what `explain` prints
  virtual void hash(Hash& h) const = 0;         // state that decides the future, in index order
  virtual void save(Writer& w) const = 0;
  virtual void load(Reader& r) = 0;
  // Systems without such a thing inherit the empty answer.
  virtual Energy energy(const Vec3& /*gravity*/) const { return {}; }
  virtual Momentum momentum() const { return {}; }
  virtual void residuals(std::vector<Residual>& /*out*/) const {}
  virtual void notes(std::vector<Note>& /*out*/) const {}  // what it chose for objects, for `explain`
  virtual bool finite() const { return true; }
  // Walks the system's structures and asserts what holds between steps (feder/error.h). After each step where asserts
  // are on: dev, fuzz, asan, tsan.
  virtual void validate() const {}
  // For the watchdog (step/watch.h), asked at the end of a step that has a suspect: upper bounds of the energy that
  // other systems may have drawn from this one (kinetic at the start of the step, work done on it, strain), J; and of
  // the speed of what it moves with infinite mass, m/s.
  virtual double held(const StepContext&) { return 0; }
  virtual double drive(const StepContext&) { return 0; }
};

// What the others ask of a system before there is one.
struct SystemDescriptor {
  const char* name;                         // "rigid"; also the arena's name
  const char* units;                        // what count() counts: "vertices"
  const char* unit = nullptr;               // one of them, for systems with kinds
  std::span<const char* const> needs = {};  // made before it
  // Made by the world as soon as all of these exist (couplings), by name or by what they show; empty for systems that
  // are asked for.
  std::span<const char* const> joins = {};
  const char* shows = nullptr;             // what couplings find in it, whatever it is called: "surface"
  std::span<const ObjectKind> kinds = {};  // of the objects it makes
  std::span<const WakeCause> causes = {};  // of wakes, that it adds
  std::span<const EventKind> events = {};  // that it adds
  std::unique_ptr<System> (*make)(SystemSetup& setup);
};

template <class S>
std::unique_ptr<System> make_system(SystemSetup& setup) {
  return std::make_unique<S>(setup);
}

using Catalog = std::span<const SystemDescriptor* const>;

// The centre-of-mass frame of an owner of colliders in a step: where it starts, how far it goes, and its rotation
// vector, rad.
struct OwnerMotion {
  Pose from;
  Vec3 shift = Vec3::Zero(), turn = Vec3::Zero();
};

struct OwnerImpact {
  Real time = 2;               // fraction of the step; above 1: none
  Vec3 normal = Vec3::Zero();  // unit, world, from a to b
  Vec3 point = Vec3::Zero();   // on b, world
  bool inside = false;         // b was in a's core at the beginning, and is near the middle of a now
};

// The core of a convex shape is so far inside it, of its least half width.
inline constexpr Real kCoreDepth = Real(0.25);

// What owners of colliders (rigid bodies, net points) may ask of collision detection, and what it asks of them.
// The system named "collide" implements it; owners find it by name and know no more of it.
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
  // What is known of a material by its number (Collide::define_material); nothing of most.
  virtual SurfaceNumbers material_numbers(std::uint16_t material) const = 0;

  // Least distance from the surface of a shape to its core, m, kCoreDepth of its least half width: a shape that moves
  // less passes through nothing. Infinite for what is not convex.
  virtual Real core_depth(const Shape& shape) const = 0;

  // Parts of bodies that a collider may meet, with boxes that overlap `box`, ascending; replaces `found`. Fixed ones
  // and kinematic ones at rest; `moving`: also those that move. Between the broad phase of a step and its end.
  virtual void obstacles(std::uint32_t collider, const Aabb& box, bool moving, Array<std::uint32_t>& found) const = 0;
  // When collider `a` of the moving owner has to stop on its way from `begin` to `end`, fractions of the step, lest it
  // passes through b.
  virtual OwnerImpact impact(std::uint32_t a, const OwnerMotion& motion_a, std::uint32_t b, const OwnerMotion& motion_b,
                             Real begin, Real end) const = 0;
};

}  // namespace feder
