// The order of a step, from top to bottom: every rank by name, once. A pass stands at a rank, or, when its system is
// not one of the runtime's, before or after one. Passes of one place run in the order in which their systems were made.
// A loop is a run of ranks; loops nest. tests/step/test_order.cpp.
#pragma once
#include "feder/types.h"

namespace feder {

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

}  // namespace feder
