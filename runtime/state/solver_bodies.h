// Solver bodies: whatever contacts and constraint rows can push, in one dense array that the solver of the step works
// on. A body or a colliding net point owns a solver slot for life; at the start of a step each owner that takes part
// writes its solver index there. Index 0 is the world: infinite mass, at rest, never written.
#pragma once
#include "feder/error.h"
#include "feder/memory.h"
#include "feder/types.h"
#include "state/arrays.h"

namespace feder {

// State of a solver body in a step, used by the inner loops: 16 numbers in this order, one cache line in the float
// build. Wide kernels load it as two rows of eight.
struct alignas(64) SolverBody {
  Vec3 velocity = Vec3::Zero();          // m/s
  Vec3 angular_velocity = Vec3::Zero();  // rad/s
  Vec3 delta_position = Vec3::Zero();    // displacement of the centre of mass since the start of the step, m
  Vec3 delta_rotation = Vec3::Zero();    // sum of h * angular_velocity since the start of the step, rad
  Quat rotation;                         // now
};
static_assert(sizeof(SolverBody) == 16 * sizeof(Real));

// Mass and start pose of a solver body in a step, read when rows are prepared.
struct SolverMass {
  Real inv_mass = 0;                  // 1/kg
  Vec3 inv_mass_axes = Vec3::Zero();  // inv_mass with locked world axes zeroed (equal to inv_mass when none)
  Mat3 inv_inertia = Mat3::Zero();    // world, 1/(kg m^2), locks applied
  Vec3 center = Vec3::Zero();         // centre of mass at the start of the step, world, m
  Quat start_rotation;
};

struct SolverBodies {
  explicit SolverBodies(Arena& a) : index(&a), free_list(&a), indexed(&a), state(&a), mass(&a) {}

  Array<std::uint32_t> index;  // by solver slot: index into state/mass this step; 0 = does not move
  Array<std::uint32_t> free_list;
  Array<std::uint32_t> indexed;  // slots that may have an index, by solver index
  Array<SolverBody> state;       // by solver index
  Array<SolverMass> mass;

  // Solver index of what owns `slot`; kNone is the world.
  std::uint32_t at(std::uint32_t slot) const { return slot == kNone ? 0 : index[slot]; }

  // Pose of the centre of mass now; the world's is the identity.
  Pose pose(std::uint32_t i) const { return {mass[i].center + state[i].delta_position, state[i].rotation}; }

  std::uint32_t add() {
    const std::uint32_t slot = take_index(free_list, index.size(), [&] { index.push_back(0); });
    FEDER_ASSERT(slot < index.size() && index[slot] == 0);
    return slot;
  }
  void remove(std::uint32_t slot) {
    FEDER_ASSERT(slot < index.size() && free_list.size() < index.size());
    index[slot] = 0;
    free_list.push_back(slot);
  }
  // Start of a step: the world, and room for `count` solver bodies after it, for an owner that fills them, and
  // `indexed`, by index.
  void reset(std::uint32_t count = 0) {
    for (const std::uint32_t slot : indexed)
      if (slot < index.size()) index[slot] = 0;
    state.resize(count + 1), mass.resize(count + 1), indexed.resize(count + 1);
    state[0] = {}, mass[0] = {}, indexed[0] = kNone;
  }
  void clear_indices() {  // after a load
    for (std::uint32_t& s : index) s = 0;
    indexed.clear();
  }
  std::uint32_t append(std::uint32_t slot, const SolverBody& s, const SolverMass& m) {
    FEDER_ASSERT(index[slot] == 0 && state.size() == mass.size() && !state.empty());
    FEDER_ASSERT(!(m.inv_mass < 0));
    state.push_back(s);
    mass.push_back(m);
    indexed.push_back(slot);
    return index[slot] = static_cast<std::uint32_t>(state.size() - 1);
  }
};

}  // namespace feder
