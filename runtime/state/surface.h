// Surfaces: points with edges and triangles (of cloths, nets) as contact sees them. Each step their owners claim runs
// of points and describe what lies on them; contact forms loop groups and finds and solves contact rows, couplings add
// rows of their own. Valid from the owners' passes at cloth_prepare and net_surface to the end of the step.
#pragma once
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "bounds/box_search.h"
#include "feder/error.h"
#include "feder/events.h"
#include "feder/memory.h"
#include "feder/object.h"
#include "feder/types.h"
#include "state/arrays.h"
#include "state/bodies.h"
#include "state/solver_bodies.h"

namespace feder {

// One row of four numbers, as the wide kernels gather them.
struct alignas(4 * sizeof(Real)) Row4 {
  Real x = 0, y = 0, z = 0, w = 0;
  Vec3 vec() const { return Vec3(x, y, z); }
  void set(const Vec3& v) { x = v[0], y = v[1], z = v[2]; }
  void add(const Vec3& v) { x += v[0], y += v[1], z += v[2]; }
};

// Edges where their owner keeps them: the two ends of one lie together, those of the next `stride` numbers on.
struct EdgeView {
  const std::uint32_t* ends = nullptr;
  std::uint32_t stride = 2, count = 0;
};

// The surface of one object. Indices of triangles and edges count from 0 within it.
struct Surface {
  ObjectId object;
  std::uint32_t first = 0, count = 0, total = 0;  // run of points: visible ones, then hidden ones
  std::uint32_t inner = 0;                        // of the hidden ones behind those: what links may hold too
  std::span<const std::uint32_t> triangles;       // three numbers each
  EdgeView edges;
  const std::uint32_t* borders = nullptr;  // by edge, with the stride of `edges`: kNone where it has one triangle alone
  std::uint64_t version = 0;               // changes with triangles and edges
  const Vec3* rest = nullptr;              // by point, unstrained, m; null: no self-contact
  Real thickness = 0;                      // m, between two layers; half of it to bodies
  Real friction = 0;
  Real relaxation = 1;  // of contact corrections, as its solver wants it
  std::uint32_t group = 1, mask = 0xffffffffu;
  Real fastest = 0;                      // m/s, of its points at the start of the step
  Real approach_speed = 0;               // m/s, of approaching bodies in this step
  std::int32_t steps = 1;                // solver substeps wanted in a substep
  std::int32_t most_steps = 0;           // as many for bodies that come farther than `way` in one; 0: no more for them
  Real way = 0;                          // m
  WakeCause wakes = WakeCause::contact;  // cause when a contact wakes something
  bool self = false;                     // self-contact
  bool active = true;                    // moves: neither asleep nor in quarantine
  bool sleep_candidate = false;          // about to fall asleep
  bool pinned = false;                   // a point of it is held
  bool solid = false;                    // its triangles enclose what it is made of: nothing belongs inside
  bool balls = false;                    // its points are colliders of their own for bodies
  bool coasts =
      false;  // its own solver runs once per substep: in the contact loop its points move at constant velocity
  // Crossings of it with itself: where its owner suspects some, m (empty: nowhere), how many moves contact may try on
  // them in this step, and how many it left; kNone: it did not look. More than most_tangles are not counted on: the
  // surface then has no contact with itself in this step. With ignores_inside what crosses is left to the owner's
  // forces.
  Aabb suspects;
  std::uint32_t untangle_trials = 0, most_tangles = kNone - 1;
  std::uint32_t tangles = kNone;
  bool ignores_inside = false;
  // What finds its candidates of self-contact; null: swept boxes, of flat sheets only where parts of it may meet.
  const Variant<BoxSearch>* search = nullptr;
  std::uint32_t untangle_rings = 0;  // edges round what crosses that are moved along: more, the longer it stays
  std::uint32_t loop = 0;            // its group, in Surfaces::groups
};

// A contact row: up to four points by weight, against each other or against a solver body.
//   C = offset + normal . (sum weight d - displacement of the solver body's point)  >= 0
// with d the displacement of a point since the start of the step.
struct SurfaceRow {
  std::uint32_t vertex[4] = {};
  Real weight[4] = {};             // 0: unused
  Vec3 normal = Vec3::Zero();      // unit; from the solver body, or from the negative weights, to the positive ones
  Real offset = 0;                 // m
  std::uint32_t solver_index = 0;  // solver index; 0: nothing that moves
  Vec3 arm = Vec3::Zero();         // from the solver body's centre of mass to the point, m
  Vec3 slide = Vec3::Zero();       // surface velocity in addition to that of the solver body (conveyor), m/s
  Real friction = 0;
  Real relaxation = 1;                  // of the correction
  std::uint32_t contact_state = kNone;  // index of its contact state, for who made it
  std::uint32_t edges = 0;              // between surfaces: 1: edge against edge; else point against triangle
  // written by the solver
  Real impulse = 0;   // along the normal in this substep, N s
  Real pushed = 0;    // the part of it in this solver substep
  Real returned = 0;  // the part of it that was returned as rebound, N s
  Real approach = 0;  // closing speed before the first impulse of the substep, m/s
};

// Attachment: a point fixed to a point of a solver body, in all three components.
struct SurfaceAttachment {
  std::uint32_t vertex = 0;
  std::uint32_t solver_index = 0;
  Vec3 arm = Vec3::Zero();    // m
  Vec3 error = Vec3::Zero();  // vertex minus point at the start of the substep, minus d then, m
};

// A pair of surfaces that may be in contact in this step, and sums over its contacts.
struct SurfacePair {
  std::uint32_t a = 0, b = 0;                        // in Surfaces::list; the object of a is the smaller
  Real speed = 0, slip = 0;                          // closing and sliding, of the strongest contact, m/s
  Real impulse = 0, strongest = 0;                   // sum over the step, and the largest of a solver substep, N s
  std::uint32_t index = 0;                           // of a point of `a` there, within its surface
  Vec3 point = Vec3::Zero(), normal = Vec3::Zero();  // from a to b
  double given[2][3] = {};  // momentum given to the points of the two, attached ones included, N s
};

// Loop group: surfaces that may interact within a substep and so share their solver substeps. Each group runs its whole
// loop before the next.
struct SurfaceGroup {
  explicit SurfaceGroup(Arena& a) : arena(a) {}

  Arena& arena;
  // of a step
  Array<std::uint32_t> members{&arena};  // in Surfaces::list, ascending; the first names the group
  int steps = 0;                         // solver substeps in a substep; 0: none of them moves
  Real step = 0;                         // s, of one
  // of a substep
  Array<SurfaceRow> rows{&arena};       // of couplings
  Array<SurfaceRow> near_rows{&arena};  // between surfaces
  Array<SurfaceAttachment> attachments{&arena};
  Array<std::uint32_t> named{&arena};  // solver indices of bodies in possible contact or attachment, by couplings
  Array<std::uint32_t> solver_indices{&arena};  // the same, each once
  bool crowded = false;                         // contact between surfaces in this substep

  void begin() {  // of a step
    for_each_of([](auto& array) { array.clear(); }, members, rows, near_rows, attachments, named);
    steps = 0;
    step = 0;
    crowded = false;
  }
  bool touches() const { return !rows.empty() || !attachments.empty() || !near_rows.empty(); }
  void use_body(std::uint32_t solver_index) {  // its rows may name it in this substep; 0: nothing
    if (solver_index != 0) named.push_back(solver_index);
  }
};

struct Surfaces {
  explicit Surfaces(Arena& a) : arena(a) {}

  Arena& arena;
  Array<Surface> list{&arena};  // of this step
  // By point. Solvers and contact work on these; the first owner's points have the numbers that it gives them.
  Array<Vec3> position{&arena};        // at the start of the step, m
  Array<Real> mass{&arena};            // kg
  Array<Row4> delta_position{&arena};  // since then, m; w: 1/kg
  Array<Row4> before{&arena};          // the same at the start of the solver substep
  Array<Row4> velocity{&arena};        // m/s; w: 1/kg
  Array<SurfacePair> pairs{&arena};

  // Groups of this step, in the order of their first members; records behind the last are kept for their memory.
  std::vector<std::unique_ptr<SurfaceGroup>> groups;
  std::size_t group_count = 0;
  // Connections beside proximity, declared by couplings before Rank::surface_groups: a surface and a dynamic solver
  // body, or, with solver body 0, two surfaces.
  struct Connection {
    std::uint32_t a = 0, b = 0, solver_index = 0;
  };
  Array<Connection> connections{&arena};
  // Sleeping objects that contact wakes; their owners read it behind Rank::surface_events, and before the plan.
  struct Wake {
    ObjectId object, other;
    WakeCause cause = WakeCause::contact;
  };
  Array<Wake> wakes{&arena};
  // Points attached to bodies, with which they do not collide; declared by the owners.
  struct Anchor {
    std::uint32_t surface, point;
    ObjectId body;
  };
  Array<Anchor> anchors{&arena};
  // Impulses of bodies on active surfaces, at the end of the step.
  struct Carried {
    ObjectId surface, body;
    Real impulse, support;  // N s; the part of it against gravity
  };
  Array<Carried> carried{&arena};
  std::uint64_t row_updates = 0;  // of the last step: elements, contacts and attachments by solver substeps

  // By solver index: displacement since the start of the substep, as the running group sees it.
  SolverBodies* solver_bodies = nullptr;                                 // null: nothing moves beside surfaces
  Array<Vec3> body_delta_position{&arena}, body_delta_rotation{&arena};  // m, rad
  Array<Vec3> body_rounding{&arena};  // of its velocity in the substep so far (Kahan 1965), m/s

  // Owners of surfaces, declared when that changes: contact has passes where two surfaces may meet, where one takes its
  // substeps in the loop (cloth) or has self-contact, and where one has faces that a body may meet.
  struct Owner {
    std::string_view name;
    std::uint32_t count;
    bool loops;  // its solver runs in the loop of solver substeps; else it coasts there
    bool self;   // one of them has self-contact
    bool faces;  // one of them has triangles
  };
  std::vector<Owner> owners;
  void declare(const Owner& owner) {
    for (Owner& o : owners)
      if (o.name == owner.name) return void(o = owner);
    owners.push_back(owner);
  }
  const Bodies* bodies = nullptr;  // that surfaces may meet
  std::uint32_t declared() const {
    std::uint32_t all = 0;
    for (const Owner& o : owners) all += o.count;
    return all;
  }
  template <class F>
  bool any_owner(F&& f) const {
    for (const Owner& o : owners)
      if (o.count > 0 && f(o)) return true;
    return false;
  }
  bool wanted() const {
    const bool some = bodies && bodies->size() > 0;
    return declared() > 1 || any_owner([&](const Owner& o) { return o.loops || o.self || (o.faces && some); });
  }
  // Whether this owner has surfaces that contact needs.
  bool shows(std::string_view name) const {
    for (const Owner& o : owners)
      if (o.name == name) return o.count > 0 && wanted();
    return false;
  }

  std::uint32_t size() const { return static_cast<std::uint32_t>(position.size()); }
  std::size_t group_of(std::size_t n) const { return list[n].loop; }
  // A run of `count` more points.
  std::uint32_t claim(std::uint32_t count) {
    const std::uint32_t first = size(), end = first + count;
    for_each_of([end](auto& array) { array.resize(end); }, position, mass, delta_position, before, velocity);
    return first;
  }
  void begin() {  // of a step
    for_each_of([](auto& array) { array.clear(); }, list, pairs, connections, anchors, carried, position, mass,
                delta_position, before, velocity);
  }
  // Invalidates all: what they name is gone.
  void forget() {
    begin();
    clear_rows();
    group_count = 0;
  }
  void clear_rows() {  // and attachments, of all groups
    for (auto& g : groups) g->rows.clear(), g->attachments.clear();
  }
  Vec3 body_displacement(std::uint32_t m, const Vec3& arm) const {
    FEDER_ASSERT(m < body_delta_position.size());
    return body_delta_position[m] + cross(body_delta_rotation[m], arm);
  }
  // Change of velocity along n at `arm` per impulse there, 1/kg.
  Real body_response(std::uint32_t m, const Vec3& arm, const Vec3& n) const {
    if (m == 0) return 0;
    FEDER_ASSERT(solver_bodies && m < solver_bodies->mass.size());
    const SolverMass& mm = solver_bodies->mass[m];
    const Vec3 rotation = cross(arm, n);
    return dot(n, mm.inv_mass_axes.cwiseProduct(n)) + dot(rotation, mm.inv_inertia * rotation);
  }
  // Position-based impulse: correction in kg m, within a solver substep of h.
  void push_body(std::uint32_t m, const Vec3& arm, const Vec3& correction, Real h) {
    if (m == 0) return;
    FEDER_ASSERT(h > 0);
    const SolverMass& mm = solver_bodies->mass[m];
    SolverBody& state = solver_bodies->state[m];
    const Vec3 shift = mm.inv_mass_axes.cwiseProduct(correction), rotation = mm.inv_inertia * cross(arm, correction);
    body_delta_position[m] += shift;
    body_delta_rotation[m] += rotation;
    const Vec3 change = shift / h + body_rounding[m], was = state.velocity;
    state.velocity += change;
    body_rounding[m] = change - (state.velocity - was);
    state.angular_velocity += rotation / h;
  }
};

}  // namespace feder
