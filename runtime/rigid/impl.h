// State and functions of the rigid system, shared by its source files. Private to the module.
#pragma once
#include "base/jobs.h"
#include "constrain/joint.h"
#include "feder/error.h"
#include "feder/force.h"
#include "feder/rigid.h"
#include "feder/system.h"
#include "rigid/solver.h"
#include "rigid/spin_batch.h"
#include "rigid/union_find.h"
#include "state/bodies.h"
#include "state/colliders.h"
#include "state/command_log.h"
#include "state/contacts.h"
#include "state/rows.h"
#include "state/solver_bodies.h"
#include "step/watch.h"

namespace feder {

inline constexpr Real kContactMargin = Real(0.02);  // m, of boxes

// Colliders of a body move as it does: both enumerations name the same motions in the same order.
constexpr ColliderMotion motion_of(BodyType type) { return static_cast<ColliderMotion>(type); }
static_assert(motion_of(BodyType::fixed) == ColliderMotion::fixed);
static_assert(motion_of(BodyType::kinematic) == ColliderMotion::kinematic);
static_assert(motion_of(BodyType::dynamic) == ColliderMotion::dynamic);

// A joint as the system keeps it; the part that the solver needs is SolverJoint.
inline constexpr Real kMinMass = Real(1e-9), kMaxMass = Real(1e14);  // kg

struct JointRecord {
  ObjectId object, a, b;
  std::uint32_t body_a = kNone, body_b = kNone;  // kNone = world
  std::uint32_t kind = 0;                        // row in joint_kinds()
  Pose local_a, local_b;                         // frames in the centre-of-mass frames (world: in the world)
  Real break_force = kInfinity;
  std::uint8_t alive = 0, collide = 0, mass_checked = 0;
  std::uint8_t open_looks = 0;  // in a row at which it was open
};

// The parts of a new body, and what they weigh together.
struct BodySolid {
  std::vector<CompoundPart> parts;     // posed in the body frame
  std::vector<ShapeSurface> surfaces;  // that parts name
  Vec3 center = Vec3::Zero();          // of mass, in the body frame, m
  Real volume = 0, mass = 0;           // m^3, kg
  Mat3 inertia = Mat3::Zero();         // about the centre of mass, kg m^2
};

struct JointGap {
  Real open = 0, bend = 0;  // m, rad
};

// Where a fast body has to stop in a step.
struct FastStop {
  Real time = 2;                // fraction of the step; above 1: nowhere
  Real group_time = 2;          // the earliest of what joints connect; of the first of these bodies
  std::uint32_t other = kNone;  // the body that it meets
  std::uint32_t obstacles = 0;  // looked at
  Vec3 normal = Vec3::Zero(), point = Vec3::Zero();
  bool inside = false;  // it has reached the middle, past all that contacts could do
};

// What a contact carries: its thinner body, and how far that sinks.
struct ContactLoad {
  std::uint32_t body = kNone, light = kNone;  // the thinner and the lighter one
  int bodies = 0;                             // that are dynamic
  Real thickness = kInfinity, depth = 0;      // m
  Real sinks = 0, by_weight = 0;              // of the thickness, in the long run: by its load, by weights alone
  Real ratio = 0, force = 0;                  // of the masses; N
  Real pull = 0;                              // the weights on it over its mass, m/s^2
};

// How a body swings across the tension of its joints: (h w)^2 with one piece, at their forces now and per newton, 1/N.
struct JointNeed {
  Real swings = 0, per_force = 0;
  Real least = kInfinity, most = 0;  // forces now, N
  bool open = false;                 // at the last look (open_joints.cpp)
};

// What the contacts of an island carry. Needs are squares of the pieces of a substep.
struct IslandLoad {
  Real by_weight = 0, by_impulse = 0, by_joints = 0;
  Real swings = 0, per_force = 0;    // largest of JointNeed
  Real mass = 0;                     // of the heaviest body on joints, kg
  Real least = kInfinity, most = 0;  // forces of its joints, N
  std::uint64_t contacts = 0;        // and joints
  int wanted = 0;                    // level
  std::uint8_t before = 0;           // level in the last step
  std::int8_t trend = -128;          // as level_trend
  bool hard = false;                 // has contacts that may need more pieces
  bool jointed = false;              // has joints: only these count
  bool open = false;                 // of JointNeed
  bool apart = false;                // has net points, or joints to kinematic bodies
};

// Kinetic energies of an island at the start and the end of a step, and what may have been given to it, J; watch.cpp.
struct IslandEnergy {
  double before = 0, after = 0, given = 0;
  double mass = 0;   // kg
  double drive = 0;  // speed of what moves by itself, m/s
};

struct Rigid::Impl {
  explicit Impl(SystemSetup& setup);

  // bodies.cpp
  ObjectId add(const BodyDesc& desc);
  void load_motion(std::uint32_t i, const BodyDesc& desc, const Vec3& center);
  void load_mass(std::uint32_t i, const BodySolid& solid);
  void remove(std::uint32_t i, const std::string& where);
  std::uint32_t index(ObjectId body) const;
  void add_colliders(std::uint32_t i, const BodyDesc& desc, const BodySolid& solid);
  void resize_arrays();
  void load_surface(std::uint32_t k, const BodyDesc& desc, const ShapeSurface& stated);
  template <class F>
  void each_collider(std::uint32_t i, F&& f) const {
    for (std::uint32_t k = bodies.first_collider[i]; k != kNone; k = colliders.next_of_body[k]) f(k);
  }
  // Those whose part of the shape states nothing of the kind itself.
  template <class F>
  void each_collider_without(SurfaceBits bit, std::uint32_t i, F&& f) const {
    each_collider(i, [&](std::uint32_t k) {
      if (!(colliders.stated[k] & bit)) f(k);
    });
  }
  void set_pose(std::uint32_t i, const Pose& origin);
  void set_type(std::uint32_t i, BodyType type);
  void set_mass(std::uint32_t i);  // inverse mass and inertia from mass, inertia, type, locks
  void changed(std::uint32_t i);   // contacts are removed, pairs are tested again
  void place_colliders(std::uint32_t i, Real dt, const Vec3& gravity);

  // rows.cpp
  void update_boxes(StepContext& c);
  void aim_kinematic(std::uint32_t i, StepContext& c);
  void gather(StepContext& c);
  void add_forces(StepContext& c);
  void integrate_velocities(StepContext& c);
  void prepare(StepContext& c);
  void solve(StepContext& c);
  void finish_solve(StepContext& c);
  void commit(StepContext& c);
  void gather_body(std::uint32_t p);
  void gather_push(std::uint32_t p, const StepContext& c);
  Vec3 acceleration(std::uint32_t p, const StepContext& c) const;
  bool start_uneven(std::uint32_t p, const StepContext& c);
  void stop_bad(std::uint32_t p);
  void commit_body(std::uint32_t p);
  // Calls f(p) for the bodies moving[p], in parallel.
  template <class F>
  void each_moving(StepContext& c, F&& f) {
    constexpr JobGrain kGrain{256, 8'000};  // bodies per job
    c.jobs->for_blocks(static_cast<std::uint32_t>(moving.size()), kGrain,
                       [&](std::uint32_t first, std::uint32_t last, int) {
                         for (std::uint32_t p = first; p < last; ++p) f(p);
                       });
  }
  bool commit_finite(std::uint32_t p) const;
  void quarantine(std::uint32_t i);
  void refresh(StepContext& c);
  void rebuild_list();
  SolverInput input();

  // continuous.cpp
  OwnerMotion motion_in_step(std::uint32_t i) const;
  bool is_fast(std::uint32_t p) const;
  void sweep_collider(std::uint32_t i, std::uint32_t k, const OwnerMotion& motion, Real begin, Real end,
                      Array<std::uint32_t>& found, FastStop& stop);
  void list_fast(StepContext& c);
  FastStop find_stop(std::uint32_t p, Array<std::uint32_t>& found);
  void apply_stop(std::uint32_t p, const FastStop& stop, const OwnerMotion& other);
  void stop_together();
  void stop_fast(StepContext& c);

  // spin.cpp
  void list_spins(StepContext& c);
  void fill_spin(std::uint32_t p);
  void spin(StepContext& c);
  void load_principal(std::uint32_t i);
  Vec3 spin_momentum(std::uint32_t p);
  void stop_spin(std::uint32_t p);

  // sleep.cpp
  void wake(std::uint32_t i, WakeCause cause, ObjectId other);
  void wake_one(std::uint32_t i, WakeCause cause, ObjectId other);
  void wake_touching(std::uint32_t i, WakeCause cause);
  void wake_touched(StepContext& c);
  void put_to_sleep(std::uint32_t i);
  void update_sleep(StepContext& c);
  void measure_motion(StepContext& c);
  void check_far(StepContext& c);
  void say_of_fields(StepContext& c);
  void look_for_swings(StepContext& c);  // fields.cpp
  // carve.cpp
  std::uint32_t only_collider(std::uint32_t i, const char* verb) const;
  BodySolid solid_like(std::uint32_t i, const ShapePtr& shape, const Pose& place, Real density) const;
  BodyDesc description_of(std::uint32_t i, std::uint32_t k) const;
  void carve(std::uint32_t i, const ShapePtr& tool, const Pose& place, bool weld);
  struct Pile {
    std::uint32_t upper, lower;
    Real gravity;         // along the contact, m/s^2
    Real impulse, depth;  // of the last step, N s; m
  };
  Pile pile_of(const Contact& contact, const Vec3& gravity) const;
  Real weight_of(const Pile& pile) const;
  ContactLoad load_of(const Pile& pile, Real rate, const StepContext& c) const;
  const JointNeed* joint_needs(StepContext& c);
  Real hangs_of(Real per_force, Real mass, const StepContext& c) const;
  Real need_of_joints(const IslandLoad& island, const StepContext& c) const;
  std::span<const Pile> list_piles(IslandLoad* by_root, StepContext& c);
  void carried_weights(std::span<const Pile> piles, Real* out, StepContext& c);
  const Real* crowds(std::span<const Pile> piles, StepContext& c);
  std::span<const std::uint32_t> list_hard(Real rate, StepContext& c);
  void choose_levels(StepContext& c);
  void share_out(IslandLoad* by_root, StepContext& c);
  void check_loads(StepContext& c);
  void warn_squeezed(const ContactLoad& load, StepContext& c);
  template <class F>
  void each_link(F&& f);
  void join_islands();
  void keep_driven_awake();
  void sleep_islands();

  // edit.cpp
  void wake_around(std::uint32_t i);
  void set_rate(std::uint32_t i, Array<Vec3>& rate, const Vec3& value, int lock);

  // watch.cpp
  double kinetic_energy(std::uint32_t i, const Quat& rotation, const Vec3& v, const Vec3& angular_velocity) const;
  bool jumps(std::uint32_t i, Real energy, Real least) {  // energy: kinetic, per mass, m^2/s^2
    const bool yes = !(energy <= Real(kDiverged) * pace[i] + least);
    pace[i] = energy;
    return yes;
  }
  void measure_pace(const StepContext& c);
  double work_on(std::uint32_t i, const StepContext& c);
  double outside_speed(std::uint32_t i, std::uint32_t other) const;
  double joint_given(std::uint32_t j, bool edited, const StepContext& c);
  void watch_contacts(const StepContext& c);
  void watch_joints(const StepContext& c);
  void account(const StepContext& c, const Array<std::uint32_t>* of);
  bool accounted(std::uint32_t root) const { return island_numbers[root] != kNone; }
  IslandEnergy& energy_of(std::uint32_t root) { return island_energies[island_numbers[root]]; }
  void watch(const StepContext& c);
  void suspect(std::uint32_t i);
  void edited(std::uint32_t i) {
    FEDER_ASSERT(i == kNone || i < edited_step.size());
    if (i != kNone) edited_step[i] = now;
  }

  // joints.cpp
  ObjectId add_joint(const JointDesc& desc);
  void remove_joint(std::uint32_t j, const std::string& where, WakeCause cause);
  std::uint32_t joint_index(ObjectId joint) const;
  void refresh_joint(std::uint32_t j);
  void refresh_joints_of(std::uint32_t body);
  void wake_joined(const JointRecord& r, WakeCause cause);
  Real row_compliance(std::uint32_t body, const Vec3& linear, const Vec3& angular) const;
  void fill_rows(std::uint32_t j, const JointInput& in) const;
  void activate_joints(StepContext& c);
  void list_active_joints(StepContext& c);
  void load_inertia(std::uint32_t body);
  JointedBody* uneven_body(std::uint32_t index) { return uneven_of({jointed.data(), jointed.size()}, index); }
  JointGap gap_of(std::uint32_t j) const;
  Real radius_of(const JointRecord& r) const;
  void check_open_joints(StepContext& c);
  void check_mass_ratios(StepContext& c);
  void check_mass_ratio(std::uint32_t j, Real ratio, Real per_substep, StepContext& c);
  void break_joints(StepContext& c);
  JointInput joint_input(std::uint32_t j) const;
  void joint_load(std::uint32_t j, Vec3& force, Vec3& torque) const;
  void joint_totals(Real& max_error, double& elastic) const;

  // validate.cpp
  void check_gathered() const;
  void check_body(std::uint32_t i) const;
  std::uint32_t check_colliders(std::uint32_t i) const;  // how many it has
  void check_islands() const;
  void check_joint(std::uint32_t j) const;
  void check_active_joints() const;
  void check_lists() const;

  Store& store;
  Arena& arena;
  Watch& watched;
  Objects& objects;
  Events& events;
  CommandLog& commands;
  ContactService& collide;
  Bodies& bodies;
  Colliders& colliders;
  Contacts& contacts;
  SolverBodies& solver_bodies;
  int dimension;
  bool* structure_changed;
  std::unique_ptr<RigidSolver> solver;

  // per body, beside Bodies
  Array<Real> volume{&arena};                 // m^3
  Array<Real> core_depth{&arena};             // how far a motion may go that passes through nothing, m
  Array<Real> area{&arena};                   // cross-section of the sphere of that volume, m^2
  Array<std::uint8_t> asymmetric{&arena};     // uneven moments of inertia: angular momentum is integrated
  Array<Vec3> kept_momentum{&arena};          // angular momentum at the end of the last step, N m s, and its velocity:
  Array<Vec3> kept_angular_velocity{&arena};  // unless that is edited, the momentum continues without rounding
  Array<Quat> principal{&arena};              // principal axes of inertia in the body frame
  Array<Vec3> inv_moments{&arena};            // about them, 1/(kg m^2)
  Array<Real> spin_invariant{&arena};         // of a free rotation, see SpinBatch, J
  Array<std::uint8_t> level{&arena};          // its substeps are done in 2^level pieces
  Array<std::int8_t> level_trend{&arena};     // steps since when it asks for a higher level, or, below 0, for a lower
  Array<std::uint8_t> sleep_candidate{&arena};  // slow enough to sleep (two thresholds)
  Array<std::uint32_t> next_in_island{&arena};  // ring of a sleeping island
  UnionFind islands{arena};                     // of the bodies that are awake
  bool islands_joined = false;                  // in this step
  UnionFind fast_groups{arena};                 // by place in `fast`
  Array<Real> pace{&arena};                     // kinetic energy per mass at the end of the last step, m^2/s^2
  Array<std::uint64_t> edited_step{&arena};     // in which a script moved it, or edited its joints

  // Calls f(array) for the arrays that have an entry per body: of all, or of those that snapshots hold.
  template <class S, class F>
  static void each_array(S& s, F&& f) {
    each_saved_array(s, f);
    for_each_of(f, s.pace, s.edited_step);
  }
  template <class S, class F>
  static void each_saved_array(S& s, F&& f) {
    for_each_of(f, s.volume, s.core_depth, s.area, s.asymmetric, s.kept_momentum, s.kept_angular_velocity, s.principal,
                s.inv_moments, s.spin_invariant, s.level, s.level_trend, s.sleep_candidate, s.next_in_island);
  }
  template <class S, class F>
  static void each_saved(S& s, F&& f);  // rigid.cpp
  template <class S, class F>
  static void each_saved_number(S& s, F&& f);

  // joints, by joint index
  Array<SolverJoint> joints{&arena};
  Array<JointRecord> records{&arena};
  Array<std::uint32_t> free_joints{&arena};
  std::uint32_t joint_count = 0;
  Array<std::uint32_t> active_joints{&arena};     // with an awake side, ascending
  Array<std::uint32_t> breakable_joints{&arena};  // of those
  Array<std::uint32_t> joined_bodies{&arena};     // sides of those, ascending
  bool joints_stale = true;         // those lists are: bodies woke or slept, or joints were made or removed
  mutable Array<Row> rows{&arena};  // for questions about joints
  mutable Array<RowBlock> blocks{&arena};
  Real last_h = Real(1) / 240;  // s

  // this step
  Array<std::uint32_t> moving{
      &arena};  // awake dynamic and kinematic bodies, ascending; moving[p] has solver index p + 1
  bool list_stale = true;
  Array<std::uint32_t> fast{&arena};  // places in `moving` of bodies that may pass through something, ascending
  Array<FastStop> stops{&arena};      // of those
  Slack stops_slack;
  Array<OwnerMotion> stop_motions{&arena};                    // of what those meet that stop
  Array<std::uint8_t> fast_marks{&arena};                     // by p: is in `fast`
  std::vector<Array<std::uint32_t>> stop_scratch;             // by worker
  Array<ObjectId> moved{&arena};                              // awake in the last step
  Array<std::uint32_t> touching{&arena};                      // slots of contacts; wake_touching
  Array<std::uint8_t> levels{&arena};                         // by solver index; empty: all 0
  BodyPush* pushes = nullptr;                                 // by solver index, in the step's scratch memory
  Array<Vec3> applied_force{&arena}, applied_torque{&arena};  // by p, N and N m
  Array<Vec3> angular_momentum{&arena};                       // by p, of asymmetric bodies, N m s
  Array<SpinBatch> spin_batches{&arena};                      // of those that are on no joint
  Array<std::uint32_t> spin_lane{&arena};                     // by p: batch * kLanes + lane, or kNone
  Array<JointedBody> jointed{&arena};                         // by solver index; empty without joints
  Array<std::uint8_t> bad{&arena};                            // by p: not finite
  Array<MassPoint> points{&arena};                            // for force generators
  Array<Vec3> point_force{&arena};
  Array<std::uint32_t> point_rank{&arena};
  std::uint32_t body_count = 0, sleeping_count = 0;
  std::uint64_t force_count = 0;  // generators when the passes were added
  const Real* carried = nullptr;  // by body: the weight on it, N; null: not asked for in this step
  ContactLoad gives_way;          // what check_loads found last
  bool load_warned = false;
  bool gap_warned = false;    // warned of an open joint
  bool sweep_warned = false;  // warned of kMostObstacles
  bool cap_warned = false;    // warned of the iteration limit
  bool poses_stale = false;   // collider poses are of the start of the last step
  bool any_candidate = false;
  Array<std::uint32_t> jumpers{&arena};  // bodies whose islands the watchdog has to look at in this step
  // of those that are accounted, in the scratch memory of the step
  std::uint32_t* island_numbers = nullptr;  // by root, or kNone
  IslandEnergy* island_energies = nullptr;  // by number
  std::uint32_t island_count = 0;
  std::uint64_t now = 0;  // next step
  // Bodies that were carved since the last step, and what came off: events to come.
  struct Carved {
    ObjectId body, piece;
  };
  std::vector<Carved> carved_off = {};
  std::vector<ObjectId> unsaid = {};  // bodies whose fields have warnings
  bool any_field = false;             // was made in this world
  bool swing_warned = false;
  int swing_steps = 0;      // in a row in which something swung too fast
  bool warned_far = false;  // warned of motion lost far from the origin
};

}  // namespace feder
