// State and functions of collision detection. One file per part: pairs.cpp (boxes -> list of contacts), update.cpp
// (narrow tests and recycling), resting.cpp (contacts at rest), contact_states.cpp (contact states and events),
// queries.cpp, validate.cpp (invariants), collide.cpp (system, filters, snapshots). Private to the module.
#pragma once
#include <algorithm>
#include <iterator>
#include <tuple>

#include "broad/broad_phase.h"
#include "feder/error.h"
#include "feder/query.h"
#include "narrow/narrow_phase.h"
#include "state/colliders.h"
#include "state/command_log.h"
#include "state/contact_book.h"
#include "state/contacts.h"

namespace feder {

struct Sweep;
int find_field_kind();

// Distances of a pair, all in proportion to its margin, so that tiny shapes get tiny tolerances.
//  - margin: contacts exist (and are solved) below this separation. 2 cm catches a body at 1 m/s in the step before
//    contact; a tenth of the smaller shape keeps a 1 cm die from being solved against all its neighbours.
//  - contact begins at half a millimetre and ends at two (for margin 2 cm): contacts at rest vary by less.
//  - recycling: while the relative motion since the manifold was made stays below an eighth of the margin, no feature
//  from
//    outside the margin can have come near the surface.
inline constexpr Real kSpeculative = Real(0.02);        // m
inline constexpr Real kSpeculativeShare = Real(0.1);    // of the smaller shape's extent
inline constexpr Real kContactBegin = Real(1) / 40;     // of the margin
inline constexpr Real kContactEnd = Real(1) / 10;       // of the margin
inline constexpr Real kRecycleDistance = Real(1) / 8;   // of the margin
inline constexpr Real kRecycleOnField = Real(1) / 100;  // of the margin: its normals change along the surface
// Recycled arms keep their directions in the world, so a pair that rotates together must be tested again: 0.01 rad
// shifts the load of a point by a hundredth. The normal is rotated along from a smaller angle on: it decides what
// slides on a slope, and 1e-4 rad moves the limit of friction on a slope of 5 degrees by a thousandth.
inline constexpr Real kRecycleAngle = Real(0.01);  // rad
inline constexpr Real kRotateNormal = Real(1e-4);  // rad

// A manifold that a pair has or may have, in the sorted list. What the serial passes read stays in these 20 bytes.
struct ContactEntry {
  std::uint32_t a = kNone, b = kNone;  // colliders
  std::uint32_t pair = kNone;          // number in `memory`, the same for kMaxContacts entries of a pair
  std::uint32_t slot = kNone;          // in Contacts::slots and `bases`; kNone while it has no points
  std::uint16_t sub = 0;
  std::uint16_t bits = 0;
};
inline bool in_order(const ContactEntry& x, const ContactEntry& y) {
  return std::tie(x.a, x.b, x.sub) < std::tie(y.a, y.b, y.sub);
}
enum EntryBits : std::uint16_t {
  kSensorPair = 1,
  kTouching = 2,   // has points, or overlaps (sensors)
  kReported = 4,   // counted in the contact book
  kNear = 8,       // in contact, or predicted to be within the step, at its last test
  kNew = 16,       // never tested
  kTested = 32,    // in this step
  kWatch = 64,     // its contact state depends on the impulse of this step
  kArrived = 128,  // kNear became true in this step
  kMany = 256,     // the pair has kMeshManifolds entries
  kSensorIsB = 512,
  kAgainstScenery = 2048,  // one side is dynamic, the other is not
  kResting = 1024,         // set in Contacts::resting, never in `entries`
  kFieldPair = 4096,       // the pair has kMaxManifolds entries
  kSecond = 8192,          // one of the second four entries of a pair; set in Contacts::resting alone
};
inline std::uint32_t entries_of_pair(std::uint16_t bits) {
  return bits & kFieldPair ? kMaxManifolds : bits & kMany ? kMeshManifolds : 1;
}
// Of an entry, or of the first of its pair: as many numbers as there are fours of entries.
inline bool starts_number(const ContactEntry& e) { return e.sub % kMaxContacts == 0; }

// The last real narrow test of a pair, for recycling. No padding: written to snapshots as bytes.
struct PairMemory {
  PairCache cache;
  std::uint32_t valid = 0;      // may be recycled
  std::uint32_t about_a = 0;    // a is the smaller one
  Real extent = 0;              // of the smaller one from its centre of mass, m
  Real margin = 0;              // m
  Vec3 between = Vec3::Zero();  // from centre of mass a to b, m
  Quat rotation_a, rotation_b;
};

// A contact as that test found it.
struct ContactBase {
  Real separation[kMaxContactPoints] = {0, 0, 0, 0};  // m
  Vec3 normal = Vec3::Zero();
};

// A contact of which no slot is known yet: tests run in parallel, slots are taken in the order of entries.
struct NewContact {
  std::uint32_t entry = 0;
  Contact contact;
  ContactBase base;
};

// A collider as it was in the last step: differences make its pairs tested again.
struct SeenCollider {
  ColliderMotion motion = ColliderMotion::none;
  std::uint8_t sensor = 0;
  std::uint16_t material = 0;
  std::uint32_t group = 0, mask = 0;
  ObjectId object;
  std::uint32_t bits = 0;
  Real friction_static = 0, friction_dynamic = 0, restitution = 0, rolling_friction = 0;
  Real extent = 0;      // of the shape from the owner's centre of mass, m; infinite for planes
  Real half_width = 0;  // least_half_width of the shape, m; infinite where it is not convex
};
enum SeenBits : std::uint32_t {
  kChanged = 1,         // pairs are tested again
  kSurfaceChanged = 2,  // contacts are mixed again
  kSettled = 4,         // fell asleep since the last step
  kConveyor = 8,        // has a surface velocity; kept over steps
  kAwake = 16,          // kept over steps
};

// A contact of a moving collider with scenery, and which of its points are ghosts.
struct SeamEntry {
  std::uint32_t body, entry, ghosts;
};

struct Exclusion {
  ObjectId a, b;  // a < b
  std::uint32_t count = 0;
};

static_assert(sizeof(ContactPoint) == 10 * sizeof(Real) + (sizeof(Real) == 8 ? 8 : 4));
static_assert(sizeof(Contact) == 16 + 16 * sizeof(Real) + kMaxContactPoints * sizeof(ContactPoint));
static_assert(sizeof(PairMemory) == 16 + 13 * sizeof(Real));
static_assert(kMaxContacts == kMeshManifolds && kMaxManifolds % kMaxContacts == 0);
static_assert(sizeof(SeenCollider) == 24 + 6 * sizeof(Real));

struct Collide::Impl {
  explicit Impl(SystemSetup& setup);

  // passes
  void find_pairs(StepContext& c);
  void collide(StepContext& c);
  void report_contact_states(StepContext& c);

  // pairs.cpp
  void list_examined();
  void compare_colliders();
  bool is_conveyor(std::uint32_t i) const;
  void compare_collider(std::uint32_t i);
  void compare_motion(std::uint32_t i);
  std::size_t unchanged_entries(std::size_t& pair) const;
  bool merge_pairs();
  bool may_collide(std::uint32_t a, std::uint32_t b) const;
  bool keep(const ContactEntry& e, bool reported) const;
  int many(std::uint32_t a, std::uint32_t b) const;
  void create(std::uint32_t a, std::uint32_t b);
  void release(const ContactEntry& e);
  void free_slot(std::uint32_t slot);
  void measure(PairMemory& m, std::uint32_t a, std::uint32_t b) const;
  void write_order();

  // resting.cpp
  template <class F>
  void each_resting_entry(std::uint32_t pair, F&& f) const {
    const RestingPair& p = contacts->resting.pairs[pair];
    for (std::uint16_t k = 0; k < kMaxContacts && p.bits[k]; ++k) {
      const auto sub = static_cast<std::uint16_t>(p.bits[k] & kSecond ? k + kMaxContacts : k);
      f(ContactEntry{p.a, p.b, pair, p.contact[k], sub, static_cast<std::uint16_t>(p.bits[k] & ~(kResting | kSecond))});
    }
  }
  void rest(std::span<const ContactEntry> group);
  void take_resting(std::uint32_t collider);
  bool merge_returning();
  void return_woken();
  // Contacts that satisfy `wanted`, with those at rest, sorted.
  template <class F>
  std::vector<ContactEntry> listed_entries(F&& wanted) const {
    std::vector<ContactEntry> list;
    std::copy_if(entries.begin(), entries.end(), std::back_inserter(list), wanted);
    if (contacts->resting.count == 0) return list;
    contacts->resting.each([&](std::uint32_t pair) {
      each_resting_entry(pair, [&](const ContactEntry& e) {
        if (wanted(e)) list.push_back(e);
      });
    });
    std::sort(list.begin(), list.end(), in_order);
    return list;
  }
  std::vector<ContactEntry> all_entries() const;
  void forget(std::uint32_t collider);

  // update.cpp
  void fetch(const ContactEntry& e) const;
  void test_pair(std::uint32_t head, Real dt, Array<NewContact>& found);
  void test_sensor(ContactEntry& e);
  bool recycle(std::span<const ContactEntry> group);
  std::uint32_t test_fresh(std::span<const ContactEntry> group, Real margin, Real dt, Array<NewContact>& found);
  void write_manifold(Contact& contact, ContactBase& base, const Manifold& m, std::span<const Contact> old, Real limit,
                      const Vec3& ahead);
  struct Side;
  Side side_of(const Contact& contact, std::uint32_t i) const;
  void mix(Contact& contact) const;
  void check_contact(ContactEntry& e, Contact& contact, Real margin, Real dt);
  void stay_apart(ContactEntry& e);
  bool take_slots();
  bool free_slots();
  void list_arrivals();
  void list_active(StepContext& c);

  // obstacles.cpp
  bool may_pass(std::uint32_t a, std::uint32_t b, Real dt) const;
  Sweep sweep_of(std::uint32_t i, Real dt) const;
  template <class F>
  int collide_at(Real time, const Sweep& a, const Sweep& b, Real margin, PairCache& cache, Manifold* found, Vec3& ahead,
                 F&& nearer);
  int look_ahead(std::uint32_t a, std::uint32_t b, Real margin, Real dt, Manifold* found, Vec3& ahead);
  int collide_midway(std::uint32_t a, std::uint32_t b, Real margin, Real dt, PairCache& cache, Manifold* found,
                     Vec3& ahead);
  bool is_field(std::uint32_t i) const { return colliders->shape[i]->kind_id() == field_kind; }

  // seams.cpp
  std::uint32_t ghosts_of(const ContactEntry& e, std::span<const SeamEntry> group) const;
  void leave_out(ContactEntry& e, std::uint32_t ghosts, Real dt);
  void leave_out_ghosts(StepContext& c);

  // contact_states.cpp
  ContactKey key(const ContactEntry& e, bool& flipped) const;
  std::uint32_t net_point(const ContactEntry& e) const;
  ContactFinding finding(const ContactEntry& e) const;
  void count(const ContactEntry& e, int change);
  void check_watched();
  void report_stay();

  // validate.cpp
  void check_unexamined();
  void check_entry(const ContactEntry& e) const;
  void check_entries() const;
  void check_book() const;

  // queries.cpp
  bool passes(std::uint32_t i, const QueryFilter& f) const;
  template <class Near, class F>
  void each_near(const QueryFilter& filter, Near&& near, F&& f) const;
  template <class F>
  void each_hit(const Vec3& origin, const Vec3& ray, const QueryFilter& filter, F&& f) const;

  bool excluded(ObjectId a, ObjectId b) const;
  // Calls f(member) for what snapshots hold, but for the colliders and the names of materials.
  template <class C, class F>
  static void each_saved(C& c, F&& f) {
    for_each_of(f, c.contacts->slots, c.contacts->order, c.contacts->free_list, c.contacts->active,
                c.contacts->active_pairs, c.contacts->resting.pairs, c.bases, c.seen, c.entries, c.memory, c.free_pairs,
                c.exclusions, c.recheck_filters, c.recheck_surfaces, c.material_pairs, c.material_numbers);
  }

  Arena& arena;
  CommandLog& commands;
  Colliders* colliders;
  Contacts* contacts;
  ContactBook* book;
  std::unique_ptr<BroadPhase> broad;
  NarrowPhase narrow;
  int field_kind = find_field_kind();  // of distance fields; -1: none in this build

  Array<BoxMotion> motion{&arena};                       // by collider
  Array<std::uint32_t> examined{&arena};                 // colliders that may have changed or moved, ascending
  Array<std::uint32_t> changes{&arena}, merged{&arena};  // to list those
  Array<Aabb> checked_boxes{&arena};                     // by collider, where asserts are on
  Array<IndexPair> pairs{&arena};
  Array<SeenCollider> seen{&arena};                           // by collider
  Array<ContactEntry> entries{&arena}, next_entries{&arena};  // sorted by (a, b, sub)
  Slack next_slack;                                           // of next_entries
  Array<ContactEntry> returning{&arena};                      // from rest
  Array<PairMemory> memory{&arena};                           // by number of the pair
  Array<std::uint32_t> free_pairs{&arena};                    // numbers
  Array<ContactBase> bases{&arena};                           // by slot
  std::vector<Array<NewContact>> found_by;                    // by worker
  Array<const NewContact*> found_in_order{&arena};
  std::vector<Slack> found_by_slack;
  Slack found_slack;
  Array<SeamEntry> seam_entries{&arena};           // sorted by body
  Array<std::uint32_t> watched{&arena};            // indices in `entries`
  Array<Exclusion> exclusions{&arena};             // sorted
  bool scenery_changed = false;                    // something at rest counts as moving in this step
  bool examine_all = false;                        // after a load
  bool recheck_filters = false;                    // exclusions changed
  bool recheck_surfaces = false;                   // material pairs changed
  std::vector<std::string> materials;              // number - 1
  Array<SurfaceNumbers> material_numbers{&arena};  // number - 1; may be shorter
  std::vector<MaterialPair> material_pairs;        // sorted, a <= b
};

// Object pairs of exclusions are unordered.
inline std::pair<ObjectId, ObjectId> ordered(ObjectId a, ObjectId b) {
  FEDER_ASSERT(a && b && a != b);
  return a < b ? std::pair{a, b} : std::pair{b, a};
}

}  // namespace feder
