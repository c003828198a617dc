// Contact batches: eight contacts side by side, every field eight lanes wide, and the kernels on them. Plain structs
// only, since a file compiled with -mavx2 includes them. No two contacts of a batch push the same solver body.
#pragma once
#include "base/simd.h"

namespace feder {

inline constexpr int kBatchPoints = 4;

// A point lies at the manifold's centre + x t1 + y t2, where n, t1, t2 are the normal and its tangent_frame, so that
// its motion along the normal takes two products. What it is off along n does not matter.
struct BatchPoint {
  Lane8 x, y;        // m
  Lane8 separation;  // at the start of the step, m
  Lane8 mass;        // effective along the normal, kg; 1 or 0 (no such point) until `prepare`
  Lane8 impulse;     // N s
};

// Every pass reads all of it from memory, twice per substep, and in large piles that is what a step waits for: what can
// be had by a few products (tangents, lever arms, distances) is not here, and yes or no is a bit per lane.
struct ContactBatch {
  unsigned index_a[kLanes], index_b[kLanes];  // solver indices; 0 = world
  unsigned char points;                       // the largest point count of the lanes
  unsigned char rounds;              // symmetric sweeps over the points per pass: more when a lane has no warm start
  unsigned char writes_a, writes_b;  // bit per lane: the solver body can be pushed
  unsigned char fixed;               // bit per lane: one side cannot move
  unsigned char warm;                // bit per lane: began the step with impulses
  unsigned char bounces;             // some lane has restitution
  unsigned char rolls;               // some lane has rolling friction
  unsigned char conveys;             // some lane has a surface that moves
  unsigned char locked;              // some body has locked axes
  unsigned char last_of_color;       // the next batch may push the same bodies
  Lane8x3 normal;                    // a to b
  BatchPoint point[kBatchPoints];
  Lane8 coupling[6];                         // between points 01 02 03 12 13 23, 1/kg
  Lane8 inv_mass_a, inv_mass_b;              // of axes that are not locked, 1/kg
  Lane8 inv_inertia_a[6], inv_inertia_b[6];  // xx yy zz xy xz yz, 1/(kg m^2)
  Lane8 leak, leak_mean;                     // compliance: part of a point's own impulse, and of the sum, lost in a
                                             // visit; until `prepare` the factor by which crowding softens the pair
  // friction at the manifold's centre
  Lane8x3 center_a, center_b;       // arms, m
  Lane8 tangent_mass[3];            // inverse of the 2x2 matrix: 11 12 22, kg
  Lane8 tangent_impulse[2];         // along t1 and t2, N s
  Lane8 twist_mass, twist_impulse;  // kg m^2, N m s
  Lane8 friction_static, friction_dynamic;
};

// What the pass with bias does not need.
struct BatchSide {
  Lane8 total[kBatchPoints];  // sum of the normal impulses over the substeps, N s
  Lane8 restitution;
};

// What few batches need: where nothing rolls, conveys or is locked it is not touched, and takes no memory.
struct BatchExtra {
  Lane8x3 axes_a, axes_b;   // where something is locked: inverse masses by world axis, 1/kg
  Lane8 tangent_speed[2];   // wanted, m/s (conveyor)
  Lane8 rolling_arm;        // m
  Lane8 rolling_mass[6];    // inverse of the sum of the inverse inertias, kg m^2
  Lane8x3 rolling_impulse;  // N m s
};

// What only `prepare` takes of a batch.
struct BatchInput {
  Lane8x3 arm_a[kBatchPoints], arm_b[kBatchPoints];  // from the centres of mass to the points, m
  Lane8 lands;                                       // 1: new, or along gravity; else 0
};

// Impacts of a batch within a substep; only in steps where something bounces.
struct StrikeBatch {
  Lane8 approach[kBatchPoints];  // normal speed of the points that strike, m/s (negative); else 0
  Lane8 impulse[kBatchPoints];   // of this strike, N s
  Lane8 tangent[2];              // N s
  unsigned acts;                 // some point strikes
};

// A solver body's mass in the order the kernels want: 16 numbers.
struct alignas(64) WideMass {
  WideReal inv_mass[3];
  WideReal inv_inertia[6];
  WideReal movable;  // 1: contacts change its velocity; 0: the world, and what is kinematic
  WideReal pad[6];
};

struct SoftFactors {
  WideReal bias_rate, mass_scale, impulse_scale;
};

struct ContactPass {
  ContactBatch* batches;
  BatchSide* sides;
  StrikeBatch* strikes;
  BatchExtra* extras;
  const BatchInput* input;  // of the batch `first`, alone; for `prepare`
  unsigned first, last;     // range of batches
  unsigned fetched;         // the next ones are asked for in time up to here; 0 where caches hold them all
  WideReal* bodies;         // SolverBody as 16 numbers each
  const WideMass* masses;
  WideReal h, inv_h;
  SoftFactors soft, soft_fixed;  // between solver bodies; against something that cannot move
  WideReal push_speed;           // largest speed at which overlap is undone, m/s
  WideReal bounce_speed;         // slower approaches do not bounce, m/s
  unsigned odd;                  // 1 in every second substep
  unsigned again;                // 1: `relax` has been here in this substep
  unsigned all_strike;           // 1: impacts without restitution, too, are strikes
  const unsigned char* jointed;  // by solver index: on a joint
  unsigned char* struck;         // by solver index: the last wave of strikes that changed its velocity; null: mark all
  unsigned char wave;            // of the strikes that come, or that come after `mark`; from 1 on
};

struct ContactKernels {
  void (*prepare)(const ContactPass&);  // of one batch
  void (*renew)(const ContactPass&);    // after `prepare`: the masses have changed
  void (*warm_start)(const ContactPass&);
  void (*mark)(const ContactPass&);         // which points strike
  void (*strike)(const ContactPass&);       // restitution, a round over those
  void (*mark_thrown)(const ContactPass&);  // which points of jointed bodies their warm start drives apart
  void (*ease)(const ContactPass&);         // takes it back, a round over those
  void (*solve)(const ContactPass&);        // with bias; friction in part
  void (*relax)(const ContactPass&);        // without bias; friction, twist, rolling
};

extern const ContactKernels kContactKernelsPlain;
extern const ContactKernels kContactKernelsAvx2;

}  // namespace feder
