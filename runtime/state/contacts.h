// Contacts: one slot per manifold with points, so that pairs whose boxes merely overlap take none. Its impulses are the
// warm start of the next step. Contacts of pairs of which no side moves are resting: no pass of a step sees them.
#pragma once
#include "feder/error.h"
#include "feder/memory.h"
#include "feder/object.h"
#include "feder/snapshot.h"
#include "feder/types.h"

namespace feder {

inline constexpr int kMaxContactPoints = 4;
inline constexpr int kMaxContacts = 4;  // of a pair's number; a pair with a distance field has two

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
  std::uint8_t fresh = 0;     // new manifold this step (not recycled)
  std::uint8_t point_count = 0;
  std::uint8_t unused = 0;     // no padding
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

// A pair of which no side moves. No padding: written to snapshots as bytes.
struct RestingPair {
  std::uint32_t a = kNone, b = kNone;  // colliders; kNone: the pair of that number does not rest
  std::uint32_t contact[kMaxContacts] = {kNone, kNone, kNone, kNone};  // slots
  std::uint16_t bits[kMaxContacts] = {0, 0, 0, 0};                     // for the finder of contacts; 0: no such contact
};
static_assert(sizeof(RestingPair) == 8 + 6 * kMaxContacts);

// Resting pairs in one list per collider, linked both ways: nodes 2 pair and 2 pair + 1 are in the lists of its
// colliders a and b. The order within a list is that of coming to rest: sort before it matters.
struct RestingPairs {
  explicit RestingPairs(Arena& a) : pairs(&a), head(&a), next(&a), prev(&a) {}

  Array<RestingPair> pairs;         // by number of the pair; empty as long as nothing rests
  Array<std::uint32_t> head;        // by collider: node, or kNone
  Array<std::uint32_t> next, prev;  // by node
  std::uint32_t count = 0;          // pairs

  // Makes room for pairs below `pair_count`.
  void reserve(std::size_t colliders, std::size_t pair_count) {
    if (head.size() < colliders) head.resize(colliders, kNone);
    if (pairs.size() < pair_count) pairs.resize(pair_count);
    if (next.size() < 2 * pair_count) next.resize(2 * pair_count, kNone), prev.resize(2 * pair_count, kNone);
  }
  void add(std::uint32_t pair, const RestingPair& data) {
    FEDER_ASSERT(pairs[pair].a == kNone && data.a < data.b);
    pairs[pair] = data;
    link_pair(pair);
  }
  void remove(std::uint32_t pair) {
    FEDER_ASSERT(count > 0);
    unlink(2 * pair, pairs[pair].a), unlink(2 * pair + 1, pairs[pair].b), --count;
    pairs[pair] = {};
  }
  // After a load: the lists, from the pairs.
  void relist(std::size_t colliders) {
    head.clear(), next.clear(), prev.clear(), count = 0;
    if (pairs.empty()) return;
    reserve(colliders, pairs.size());
    for (std::uint32_t pair = 0; pair < pairs.size(); ++pair)
      if (pairs[pair].a != kNone) link_pair(pair);
  }
  // Calls f(pair); f may remove that pair.
  template <class F>
  void each_of(std::uint32_t collider, F&& f) const {
    for (std::uint32_t n = collider < head.size() ? head[collider] : kNone; n != kNone;) {
      const std::uint32_t pair = n / 2;
      n = next[n];
      f(pair);
    }
  }
  // Calls f(pair) for all of them, in the order of their numbers.
  template <class F>
  void each(F&& f) const {
    for (std::uint32_t pair = 0; pair < pairs.size(); ++pair)
      if (pairs[pair].a != kNone) f(pair);
  }

 private:
  void link_pair(std::uint32_t pair) { link(2 * pair, pairs[pair].a), link(2 * pair + 1, pairs[pair].b), ++count; }
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
  Array<std::uint32_t> order;  // slots in use that do not rest, sorted by (collider_a, collider_b, sub)
  Array<std::uint32_t> free_list;
  Array<ColliderPair>
      arrivals;  // into contact, of this step, in `order`, between narrow and contact_list: owners wake those asleep
  Array<std::uint32_t>
      active;  // written by contact_list each step, in `order`: touching, no sensor, one side awake and movable
  Array<ColliderPair> active_pairs;  // of those: a slot lies far from others in memory
  RestingPairs resting;
};

}  // namespace feder
