// The step plan: a tree of loops of passes, built when the scene's structure changes, run every step from top to
// bottom. Clocks stand around every loop; inside a loop passes are counted each time and clocked in one
// iteration of kClockEvery, so that solver substeps are not made of clocks.
#pragma once
#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "feder/events.h"
#include "feder/memory.h"
#include "feder/object.h"
#include "feder/profile.h"
#include "feder/types.h"

namespace feder {

// The order of a step, from top to bottom: every rank by name, once. A pass stands at a rank, or, when its system is
// not one of the runtime's, before or after one. Passes of one place run in the order in which their systems were made.
// A loop is a run of ranks; loops nest. tests/step/test_order.cpp.

enum class Rank : std::uint8_t {
  // step: bounds, broad phase, narrow phase
  begin,
  body_bounds,
  point_bounds,
  broad,
  narrow,
  wake_touched,
  contact_list,
  // step: arrays that the substeps work on
  gather_bodies,
  gather_points,
  surface_begin,
  cloth_approach,
  cloth_prepare,
  net_surface,
  surface_pairs,
  append_points,
  surface_candidates,
  surface_groups,
  cloth_gather,
  surface_tangles,
  joint_rows,
  boundary_list,

  // substep: velocities and nets
  body_forces,
  body_velocities,
  net_faces,
  net_prepare,
  net_integrate,
  net_release,
  // substep: fluids
  fluid_emit,
  boundary_place,
  face_screen,
  fluid_settle,
  fluid_choose,
  fluid_predict,  // fluid substeps
  fluid_neighbors,
  fluid_boundary,
  fluid_pressure,
  fluid_friction,
  fluid_move,
  boundary_move,
  fluid_project,
  fluid_check,
  boundary_weigh,
  net_contact,
  boundary_push,
  // substep: surfaces, cloth and nets
  surface_contact,
  cloth_attachments,
  cloth_particles,
  cloth_forces,
  net_coast,
  surface_start,
  surface_refresh,  // surface substeps
  surface_near,
  cloth_integrate,
  surface_coast,
  surface_bodies,
  surface_attachments,
  cloth_ties,
  surface_rows,
  cloth_velocities,
  surface_velocities,
  surface_rebound,
  cloth_damp,
  surface_project,
  surface_collect,
  cloth_read_back,
  net_follow,
  // substep: contacts and joints of bodies
  net_hand_over,
  body_solve,
  net_read_back,
  boundary_follow,
  boundary_project,
  boundary_return,

  // step: after the last substep
  restitution,
  net_read_bounces,
  surface_events,
  cloth_wake,
  keep_awake,
  cloth_load,
  commit,
  fluid_drain,
  check,
  fluid_events,
  contact_events,
  finish,

  // between steps, before questions about the state
  query_colliders,
  query_boundary,
};
inline constexpr int kRankCount = static_cast<int>(Rank::query_boundary) + 1;

enum class Loop : std::uint8_t { step, substep, fluid, surface };
inline constexpr int kLoopCount = 4;

struct LoopSpan {
  const char* name;
  Loop parent;
  Rank first, last;  // inclusive
};
inline constexpr LoopSpan kLoops[kLoopCount] = {
    {"step", Loop::step, Rank::begin, Rank::finish},
    {"substep", Loop::step, Rank::body_forces, Rank::boundary_return},
    {"fluid substeps", Loop::substep, Rank::fluid_predict, Rank::fluid_project},
    {"surface substeps", Loop::substep, Rank::surface_refresh, Rank::surface_project},
};

// The innermost loop around a rank.
constexpr Loop loop_of(Rank rank) {
  Loop inner = Loop::step;
  for (int i = 1; i < kLoopCount; ++i)
    if (rank >= kLoops[i].first && rank <= kLoops[i].last) inner = static_cast<Loop>(i);
  return inner;
}

// Where a pass runs: at a rank (side 0), or before (-1) or after (1) all that stand there.
struct Place {
  constexpr Place(Rank r, int s = 0) : rank(r), side(s) {}  // implicit: a rank is a place
  Rank rank;
  int side;
  friend constexpr bool operator==(const Place&, const Place&) = default;
  friend constexpr bool operator<(const Place& a, const Place& b) {
    return a.rank != b.rank ? a.rank < b.rank : a.side < b.side;
  }
};
constexpr Place before(Rank rank) { return {rank, -1}; }
constexpr Place after(Rank rank) { return {rank, 1}; }

class JobPool;

// How often a loop of solver substeps runs: one count per group, written before the loop by a pass of its system. A
// group runs its whole loop before the next.
struct LoopCounts {
  std::vector<int> count;  // by group
};

// Present iteration of an inner loop.
struct InnerLoop {
  int group = 0;
  int index = 0;  // of the iteration, from 0
  int count = 1;  // iterations of this group
  bool last() const { return index + 1 == count; }
};

// The step that a pass runs in.
struct StepContext {
  Real dt = 0;  // s, the whole step
  Real h = 0;   // s, one substep: dt / substeps
  int substeps = 1;
  int substep = 0;         // 0 .. substeps-1 inside the substep loop
  InnerLoop inner;         // inside a loop of solver substeps
  std::uint64_t step = 0;  // steps done before this one
  double time = 0;         // s, simulated, at the start of the step
  int dimension = 3;
  bool sleeping = true;         // bodies may fall asleep
  Vec3 gravity = Vec3::Zero();  // m/s^2
  Store* store = nullptr;
  Objects* objects = nullptr;
  Events* events = nullptr;
  JobPool* jobs = nullptr;
  Scratch* scratch = nullptr;
  LoopCounts* loops = nullptr;  // by Loop

  LoopCounts& counts(Loop loop) const { return loops[static_cast<int>(loop)]; }
};

using PassFunction = void (*)(void* self, StepContext& context);

// A pass, or a loop around the passes that follow it.
struct PlanNode {
  Place place = Rank::begin;  // of a loop: its first rank
  bool is_loop = false;
  Loop loop = Loop::step;   // a loop: which; a pass: the one it runs in
  const char* name = "";    // "integrate", "find pairs": unique within a system
  const char* system = "";  // empty for a loop
  PassFunction run = nullptr;
  void* self = nullptr;
  std::uint32_t end = 0;  // of a loop: the node after its last one
  Counter counter;        // of a loop: calls are its iterations
};

class StepPlan {
 public:
  void clear();
  // Member function form: plan.add<&Rigid::integrate>(Rank::body_velocities, "integrate", "rigid", this)
  template <auto Method, class T>
  void add(Place place, const char* name, const char* system, T* self) {
    add(
        place, name, system, [](void* s, StepContext& c) { (static_cast<T*>(s)->*Method)(c); }, self);
  }
  void add(Place place, const char* name, const char* system, PassFunction run, void* self);
  void finish();                   // sorts and nests; counters of passes that were there before are kept
  void run(StepContext& context);  // one step
  void run_queries(Rank last, StepContext& context);  // the passes between steps, up to a rank

  // In running order; a loop stands before its passes.
  std::span<const PlanNode> nodes() const { return {nodes_.data(), step_end_}; }  // of a step
  static std::string path(const PlanNode& node);  // "step/substep/surface substeps": the loops around it
  static int depth(const PlanNode& node);         // 0: in the step itself
  double total_nanoseconds() const;
  void reset_counters();
  void clock_every(int iterations) {
    clock_every_ = iterations, std::fill(idle_, idle_ + kLoopCount, 0);
  }  // 1: `explain` pays for exact shares

 private:
  void run_nodes(std::uint32_t first, std::uint32_t end, StepContext& c, bool clocked);
  void run_loop(PlanNode& loop, std::uint32_t first, StepContext& c);

  std::vector<PlanNode> nodes_, old_;
  std::size_t step_end_ = 0;  // the passes between steps follow
  LoopCounts counts_[kLoopCount];
  int idle_[kLoopCount] = {};            // iterations until the next that is clocked
  static constexpr int kClockEvery = 7;  // no divisor of usual numbers of substeps: the first iteration is not typical
  int clock_every_ = kClockEvery;
};

}  // namespace feder
