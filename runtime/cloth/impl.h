// The parts of the cloth system that its files share. Private to the module.
#pragma once
#include <memory>
#include <vector>

#include "cloth/group.h"
#include "cloth/sheet.h"
#include "forces/force.h"
#include "state/movers.h"
#include "step/watch.h"

namespace feder {

// Vertices that the guard moves as one.
struct Zone {
  Vec3 velocity = Vec3::Zero();  // their momentum while it is summed up, m/s
  Real mass = 0;
  Real share = 1;     // of the way it would go with that velocity
  Real freedom = 1;   // of its vertices' motion beside it
  bool held = false;  // a pinned vertex is in it
};

struct Cloth::Impl {
  explicit Impl(SystemSetup& setup);

  Arena& arena;
  ClothVertices& vertices;
  Store& store;
  Watch& watched;
  Objects& objects;
  Events& events;
  bool* structure_changed;
  const Real air_density;  // kg/m^3, of still air
  Cloth* owner = nullptr;
  std::vector<std::unique_ptr<Sheet>> sheets;  // the object's index is the place here
  std::vector<Attachment> attachments;         // in the order they were made
  Movers* movers = nullptr;

  // of a step, by vertex
  Array<Row4> moved, before, speed;
  Array<Vec3> acceleration;  // gravity, script, wind
  Array<Vec3> force;         // work of forces.cpp, N
  Array<MassPoint> points;
  // of a step, by mover: what contacts moved it beside its own solver's account
  Array<Vec3> mover_shift, mover_turn;
  // of a step: groups in the order of their first cloths (groups.cpp); records behind the last are kept for their
  // memory
  std::vector<std::unique_ptr<ClothGroup>> groups;
  std::size_t group_count = 0;
  // What connects cloths beside closeness, told by couplings: a cloth and a mover, or, with mover 0, two cloths.
  struct Connection {
    std::uint32_t a = 0, b = 0, mover = 0;
  };
  Array<Connection> connections;
  Array<std::uint32_t> mover_cloth;  // by mover: the first cloth connected to it
  Array<std::uint32_t> joined_to;    // by cloth: an earlier one of its group, or itself
  bool any_active = false;
  std::size_t force_count = 0;  // forces known when the rows were made
  bool gravity_known = false;
  Vec3 gravity = Vec3::Zero();  // of the last step: a change wakes all

  // closeness of cloth and cloth, by vertex; each group writes those of its own
  Array<Aabb> vertex_box;                // swept over the rest of the step, beside the drift
  Array<Vec3> found_place, found_speed;  // by vertex, when the boxes were made
  Array<Real> stray;                     // by vertex: what it may depart from that motion, m
  Array<std::uint32_t> found;
  Array<Row4> guard_start;                 // displacements at the start of the part
  Array<std::uint32_t> held_with;          // by vertex: one of its group, or kNone: not held
  Array<Zone> zones;                       // by lowest vertex
  Array<Row4> wished;                      // displacements before the zones were made
  Array<Row4> swapped;                     // speeds while the guard searches
  Array<Between> between;                  // cloths that may touch each other
  Array<std::uint32_t> near_sheet;         // by vertex: place of its cloth
  std::uint64_t guarded = 0, widened = 0;  // corrections and second searches of the last step
  std::uint64_t row_updates = 0;           // of the last step: links, hinges, contacts and holds by small steps
  mutable Array<std::uint32_t> marks;      // of validate(), by vertex

  Sheet& sheet(ObjectId id) const {
    FEDER_ASSERT(objects.alive(id) && objects.kind(id) == ObjectKind::cloth);
    return *sheets[objects.index(id)];
  }
  std::uint32_t vertex(ObjectId id, std::size_t i) const;  // index in ClothVertices; SceneError when there is none
  ClothView view(Sheet& s);
  void attach_solver(Sheet& s, const std::string& name, const Params& options);
  void measure_paths(Sheet& s);
  void make_ties(Sheet& s);
  void place_ties(Sheet& s);
  void solve_body_ties(const ClothGroup& g);
  void wake(Sheet& s, WakeCause cause, ObjectId other);
  void put_to_sleep(Sheet& s);

  // Passes: of the step, of the substep, of the loop of small steps, of the step.
  void prepare(StepContext& c);
  void form_groups(StepContext& c);
  void begin_substep(StepContext& c);
  void find_near(StepContext& c);
  void advance(StepContext& c);
  void advance_movers(StepContext& c);
  void solve(StepContext& c);
  void read_velocities(StepContext& c);
  void damp(StepContext& c);
  void project(StepContext& c);
  void commit(StepContext& c);

  // groups.cpp
  ClothGroup& group(const StepContext& c) const { return *groups[static_cast<std::size_t>(c.inner.group)]; }
  std::uint32_t first_of(std::uint32_t sheet);
  void join(std::uint32_t a, std::uint32_t b);
  template <class F>
  void each_active(const ClothGroup& g, F&& f) {
    for (const std::uint32_t n : g.sheets)
      if (sheets[n]->active()) f(*sheets[n]);
  }

  void choose_steps(StepContext& c);
  double swing(const Sheet& s) const;
  void check_damping(Sheet& s, StepContext& c);
  void prepare_solver(Sheet& s, StepContext& c);
  void gather(Sheet& s, Real h);
  void add_forces(StepContext& c);
  void add_wind(Sheet& s, double time, Real h);
  void add_still_air(const Sheet& s, Real h);
  void quarantine(StepContext& c);
  void update_sleep(StepContext& c);
  // watch.cpp
  double kinetic_energy(const Sheet& s) const;
  double work(const Sheet& s) const;
  double given(const Sheet& s, const StepContext& c) const;
  void watch(StepContext& c);
  void suspect(const Sheet& s);
  void tear(StepContext& c);
  bool tear_at(Sheet& s, std::uint32_t link, StepContext& c);
  std::uint32_t split_vertex(Sheet& s, std::uint32_t vertex, const std::vector<std::uint32_t>& triangles);
  void lump_mass(Sheet& s);
  void share_mass(Sheet& s);
  // validate.cpp
  void validate_sheet(std::uint32_t n) const;
  void validate_mesh(const Sheet& s) const;
  void validate_motion(const Sheet& s) const;
  void validate_ties(const Sheet& s) const;
  void validate_pairs() const;
  void validate_group(std::size_t k) const;

  // rows.cpp
  void solve_rows(Array<ClothRow>& list, bool cloths, Real h);
  void solve_holds(const ClothGroup& g);
  void velocities(const ClothGroup& g);
  void stop_rebound(Array<ClothRow>& list, bool cloths, Real h);
  Vec3 mover_displacement(std::uint32_t mover, const Vec3& arm) const;
  void push_mover(std::uint32_t mover, const Vec3& arm, const Vec3& correction, Real h);  // correction: kg m
  Real mover_response(std::uint32_t mover, const Vec3& arm, const Vec3& n) const;         // 1/kg

  // near.cpp: pairs that may come close in this step, and their rows
  bool near_wanted(const ClothGroup& g) const;
  std::uint32_t between_of(std::uint32_t a, std::uint32_t b) const;  // kNone: they may not touch
  Sheet& sheet_of(std::uint32_t vertex) const {
    FEDER_ASSERT(vertex < vertices.size());
    return *sheets[objects.index(vertices.cloth[vertex])];
  }
  Vec3 place(std::uint32_t vertex) const { return vertices.position[vertex] + moved[vertex].vec(); }
  // `time`: what is left of the step, s; `part`: the time from these rows to the guard, s; `held`: vertices may stay
  // behind.
  void find_pairs(ClothGroup& g, Real time, bool held);
  void list_features(ClothGroup& g, Real time, bool held);
  void add_pair(ClothGroup& g, const std::uint32_t (&v)[4], bool edges, Real time);
  void measure(NearPair& p, Real (&weight)[4]) const;
  void make_near_rows(ClothGroup& g, Real time, Real part);
  int near_parts(const ClothGroup& g, StepContext& c) const;  // of a substep
  void collect_near(const ClothGroup& g);
  void account(const ClothRow& r, int k, const Vec3& change, const Vec3& wanted, Real h);
  // guard.cpp: no pair crosses within a part
  void guard(ClothGroup& g, Real part);
  Vec3 astray(const ClothGroup& g, std::uint32_t vertex) const;  // beside the motion foreseen at the search, m
  bool near_path(ClothGroup& g, Real part);
  bool separate(NearPair& p, Real h, bool push);
  void widen(ClothGroup& g, Real part);
  void hold_back(ClothGroup& g, Real part);
  std::uint32_t held_root(std::uint32_t vertex);
  void move_zones(const ClothGroup& g, Real part);
  Real freedom(const NearPair& p);
};

}  // namespace feder
