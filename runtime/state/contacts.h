// Contacts: one slot per pair of colliders with overlapping boxes (and per extra manifold against meshes), as long as
// the boxes overlap. Its impulses are the warm start of the next step. Contacts of which no side moves are resting: no
// pass of a step sees them.
#pragma once
#include "feder/error.h"
#include "feder/memory.h"
#include "feder/object.h"
#include "feder/snapshot.h"
#include "feder/types.h"

namespace feder {

inline constexpr int kMaxContactPoints = 4;

struct ContactPoint {
  Vec3 arm_a =
      Vec3::Zero();  // from the owner's centre of mass to the point, world, at the time of the fresh manifold, m
  Vec3 arm_b = Vec3::Zero();
  Real separation = 0;      // at the start of this step, m
  Real normal_impulse = 0;  // accumulated in the last substep, N s; warm start
  Real total_impulse = 0;   // sum over the substeps of the last step, N s; for events
  Real approach_speed = 0;  // relative normal speed when it was tested (negative = closing), m/s
  std::uint32_t feature = 0;
#ifdef FEDER_REAL_DOUBLE
  std::uint32_t unused = 0;  // no padding: contacts are written to snapshots as bytes
#endif
};

struct Contact {
  std::uint32_t collider_a = kNone, collider_b = kNone;  // a < b
  std::uint16_t sub = 0;                                 // number of the manifold within the pair
  SurfaceNumber surface = 0;  // of the mesh's triangles that it is on; 0: that of the collider
  std::uint8_t touching = 0;  // has points with separation below the margin, which are solved
  std::uint8_t sensor = 0;
  std::uint8_t fresh = 0;  // new manifold this step (not recycled)
  std::uint8_t point_count = 0;
  Vec3 normal = Vec3::Zero();  // a to b, world
  ContactPoint points[kMaxContactPoints];
  Real friction_static = 0, friction_dynamic = 0, restitution = 0, rolling_friction = 0;  // mixed; rolling in m (arm)
  Vec3 surface_velocity = Vec3::Zero();  // wanted tangential velocity of b against a, world, m/s
  Real tangent_impulse[2] = {0, 0};      // friction at the manifold's centre along tangent_frame(normal), N s
  Real twist_impulse = 0;                // N m s
  Vec3 rolling_impulse = Vec3::Zero();   // N m s
};

struct ColliderPair {
  std::uint32_t a, b;
};

// Slots of resting contacts in one list per collider, linked both ways: nodes 2 slot and 2 slot + 1 are in the lists of
// the slot's colliders a and b. The order within a list is that of coming to rest: sort before it matters.
struct RestingContacts {
  explicit RestingContacts(Arena& a) : head(&a), next(&a), prev(&a) {}

  Array<std::uint32_t> head;        // by collider: node, or kNone
  Array<std::uint32_t> next, prev;  // by node
  std::uint32_t count = 0;          // contacts

  void reserve(std::size_t colliders, std::size_t slots) {
    if (head.size() < colliders) head.resize(colliders, kNone);
    if (next.size() < 2 * slots) next.resize(2 * slots, kNone), prev.resize(2 * slots, kNone);
  }
  void clear() { head.clear(), next.clear(), prev.clear(), count = 0; }
  void add(std::uint32_t slot, std::uint32_t a, std::uint32_t b) { link(2 * slot, a), link(2 * slot + 1, b), ++count; }
  void remove(std::uint32_t slot, std::uint32_t a, std::uint32_t b) {
    FEDER_ASSERT(count > 0);
    unlink(2 * slot, a), unlink(2 * slot + 1, b), --count;
  }
  // Calls f(slot); f may remove that slot.
  template <class F>
  void each_of(std::uint32_t collider, F&& f) const {
    for (std::uint32_t n = collider < head.size() ? head[collider] : kNone; n != kNone;) {
      const std::uint32_t slot = n / 2;
      n = next[n];
      f(slot);
    }
  }

 private:
  void link(std::uint32_t node, std::uint32_t collider) {
    const std::uint32_t first = head[collider];
    prev[node] = kNone, next[node] = first;
    if (first != kNone) prev[first] = node;
    head[collider] = node;
  }
  void unlink(std::uint32_t node, std::uint32_t collider) {
    FEDER_ASSERT(prev[node] != kNone || head[collider] == node);
    (prev[node] == kNone ? head[collider] : next[prev[node]]) = next[node];
    if (next[node] != kNone) prev[next[node]] = prev[node];
  }
};

struct Contacts {
  explicit Contacts(Arena& a)
      : slots(&a), order(&a), free_list(&a), arrivals(&a), active(&a), active_pairs(&a), resting(a) {}

  Array<Contact> slots;
  Array<std::uint32_t> order;  // slots of contacts that do not rest, sorted by (collider_a, collider_b, sub)
  Array<std::uint32_t> free_list;
  Array<ColliderPair>
      arrivals;  // into contact, of this step, in `order`, between narrow and contact_list: owners wake those asleep
  Array<std::uint32_t>
      active;  // written by contact_list each step, in `order`: touching, no sensor, one side awake and movable
  Array<ColliderPair> active_pairs;  // of those: a slot lies far from others in memory
  RestingContacts resting;
};

}  // namespace feder
