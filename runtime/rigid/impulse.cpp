// Solver `impulse`: the classical loop of impulse-based simulation, worst first (Baraff, "Physically Based Modeling",
// SIGGRAPH 1997 notes; Mirtich 1996; Gauss-Southwell instead of Gauss-Seidel). Each substep, per island:
//   trees       stiff joints without loops are solved together and exactly (joint_trees.h);
//   speeds      a heap of contacts and joints keyed by the error of their relative speed; the worst is solved in closed
//               form, and only its neighbours (a body in common) are keyed again;
//   slip        manifolds beyond static friction change to the dynamic cone: speeds again;
//   drift       bodies travel; the joint error of that motion is removed in position and speed: of trees by Newton's
//               method, of others worst first;
//   positions   a heap keyed by penetration and joint error; the worst is corrected by the least motion, in proportion
//               to inverse mass and inertia; velocities stay.
// All end at a tolerance or at a cap, which is counted. O((n + pops * degree) log n) for n contacts and joints.
// Kept between calls: impulses of resting contacts (Contact) and of joints (SolverJoint) as warm start; velocities at
// the end of the last substep, which give the part that forces added. Weak spot: large piles need many pops, and an
// island runs on one thread.
#include <algorithm>

#include "base/hash.h"
#include "rigid/impulse_heap.h"
#include "rigid/impulse_parts.h"
#include "rigid/joint_load.h"
#include "rigid/joint_trees.h"
#include "rigid/union_find.h"

namespace feder {
namespace {

// m or rad: an error of 1e-7 at h = 1/240 is 2e-5 m/s, the tolerance of speeds.
constexpr Real kDriftTolerance = sizeof(Real) == 8 ? Real(1e-9) : Real(1e-6);

constexpr int kDriftRounds = 6;  // of Newton's method; each divides an error by 4/(h w)^2

constexpr int kSlipRounds = 4;  // a contact that begins to slide may make its neighbours slide

class ImpulseSolver final : public RigidSolver {
 public:
  ImpulseSolver(Arena& a, const Params& p)
      : tolerance_(p.real({"tolerance", "", {1e-12, 1}}, 2e-5)),
        rest_speed_(p.real({"restitution_speed", "m/s", {0, 1e6}}, 0.05)), slop_(p.real({"slop", "m", {0, 1}}, 0.0005)),
        pops_per_node_(p.integer({"iterations", "", {1, 100000}}, 30)), arena_(a) {}
  void prepare(const SolverInput& in, StepContext& c) override;
  void solve(const SolverInput& in, StepContext& c) override;
  void finish(const SolverInput& in, StepContext& c) override;
  std::uint64_t capped() const override { return capped_; }

 private:
  struct Island {
    std::uint32_t first, last;  // in order_
  };

  ImpulseScene scene(const SolverInput& in, const StepContext& c);
  void load_bodies(const SolverInput& in);
  void rotate_inertias(const ImpulseScene& s);
  void load_contacts(const SolverInput& in, const ImpulseScene& s);
  void load_joints(const SolverInput& in);
  void find_islands();
  void check_islands();
  void index_nodes();
  void node_bodies(std::uint32_t node, std::uint32_t& a, std::uint32_t& b) const;

  void start_substep(const SolverInput& in, const ImpulseScene& s);
  void start_joints(const SolverInput& in, const ImpulseScene& s);
  void fill(const SolverInput& in, const ImpulseJoint& joint, RowWriter& out) const;
  void travel(const SolverBodies& solver_bodies, const ImpulseScene& s);
  void factor_trees(const SolverInput& in, const StepContext& c);
  BlockRows rows_of(const RowBlock& b) const { return {&rows_[b.first], b.count, b.index_a, b.index_b}; }
  BlockRows spare_rows_of(const RowBlock& b) const { return {&spare_rows_[b.first], b.count, b.index_a, b.index_b}; }
  template <auto Apply>
  void apply_tree_step(const SolverInput& in, const ImpulseScene& s);
  void solve_tree_speeds(const SolverInput& in, const ImpulseScene& s);
  void close_tree_drift(const SolverInput& in, const ImpulseScene& s);
  bool in_tree(const ImpulseJoint& j) const { return !trees_.empty() && trees_.direct(j.first_block); }

  // `rank`: index in order_, where the nodes of an island follow each other.
  Real speed_error(const SolverInput& in, const ImpulseScene& s, std::uint32_t rank);
  void solve_speed(const SolverInput& in, const ImpulseScene& s, std::uint32_t rank);
  void fill_now(const SolverInput& in, const ImpulseJoint& joint);
  Real drift_error(const SolverInput& in, const ImpulseScene& s, std::uint32_t rank);
  void correct_drift(const SolverInput& in, const ImpulseScene& s, std::uint32_t rank);
  Real position_error(const SolverInput& in, const ImpulseScene& s, std::uint32_t rank);
  void correct_position(const SolverInput& in, const ImpulseScene& s, std::uint32_t rank);
  bool check_slip(const ImpulseScene& s, const Island& island);
  template <auto Error, auto Fix>
  void worst_first(const SolverInput& in, const ImpulseScene& s, const Island& island, Real tolerance);

  Real tolerance_, rest_speed_, slop_;
  int pops_per_node_;
  std::uint64_t capped_ = 0;

  Arena& arena_;
  Array<ImpulseBody> bodies_{&arena_};       // by solver index
  Array<ImpulseContact> contacts_{&arena_};  // nodes [0, contacts)
  Array<ImpulseJoint> joints_{&arena_};      // nodes after the contacts
  Array<Row> rows_{&arena_}, spare_rows_{&arena_};
  Array<RowBlock> blocks_{&arena_}, spare_blocks_{&arena_};
  Array<ImpulseBlock> factors_{&arena_};                                            // by block
  JointTrees trees_{arena_};                                                        // stiff joints without loops
  Array<Real> tree_bias_{&arena_}, tree_step_{&arena_}, tree_compliance_{&arena_};  // by row
  Array<Mat3> tree_inertia_{&arena_};                                               // inverse, by solver index
  UnionFind groups_{arena_};                                    // of solver bodies that contacts and joints connect
  Array<std::uint32_t> island_of_{&arena_};                     // by solver index
  Array<std::uint32_t> node_island_{&arena_}, order_{&arena_};  // by node; by rank: the node
  Array<Island> islands_{&arena_};
  Array<std::uint32_t> first_rank_{&arena_}, body_ranks_{&arena_};  // by solver index: ranks of its nodes
  WorstFirst heap_{arena_};
};

void ImpulseSolver::load_bodies(const SolverInput& in) {
  const SolverBodies& solver_bodies = *in.solver_bodies;
  bodies_.resize(solver_bodies.state.size());
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const SolverMass& m = solver_bodies.mass[i];
    ImpulseBody& b = bodies_[i];
    b = ImpulseBody{};
    b.inv_inertia = m.inv_inertia;
    b.uneven = in.uneven(static_cast<std::uint32_t>(i));
    b.movable = i > 0 && (m.inv_mass > 0 || m.inv_inertia.trace() > 0);
    b.last_velocity = solver_bodies.state[i].velocity;
    b.last_angular_velocity = solver_bodies.state[i].angular_velocity;
  }
}

void ImpulseSolver::load_contacts(const SolverInput& in, const ImpulseScene& s) {
  contacts_.clear();
  for (const std::uint32_t slot : in.contacts->active) {
    FEDER_ASSERT(slot < in.contacts->slots.size());
    Contact& from = in.contacts->slots[slot];
    ImpulseContact c;
    c.slot = slot;
    c.a = in.solver_index(from.collider_a);
    c.b = in.solver_index(from.collider_b);
    FEDER_ASSERT(c.a < bodies_.size() && c.b < bodies_.size() && (c.a != c.b || c.a == 0));
    for (ContactPoint& p : from.points) p.total_impulse = 0;
    if (!bodies_[c.a].movable && !bodies_[c.b].movable) continue;
    load_contact(from, s, c);
    contacts_.push_back(c);
    for (int i = 0; i < from.point_count; ++i) {
      ContactPoint& p = from.points[i];
      const SolverBody &a = in.solver_bodies->state[c.a], &b = in.solver_bodies->state[c.b];
      p.approach_speed = dot(from.normal, b.velocity + cross(b.angular_velocity, p.arm_b) - a.velocity -
                                              cross(a.angular_velocity, p.arm_a));
    }
  }
}

void ImpulseSolver::load_joints(const SolverInput& in) {
  joints_.clear();
  for (const std::uint32_t i : in.active_joints) {
    ImpulseJoint j;
    j.joint = i;
    j.a = in.solver_bodies->at(in.joints[i].slot_a);
    j.b = in.solver_bodies->at(in.joints[i].slot_b);
    FEDER_ASSERT(j.a < bodies_.size() && j.b < bodies_.size());
    if (bodies_[j.a].movable || bodies_[j.b].movable) joints_.push_back(j);
  }
}

void ImpulseSolver::node_bodies(std::uint32_t node, std::uint32_t& a, std::uint32_t& b) const {
  FEDER_ASSERT(node < contacts_.size() + joints_.size());
  if (node < contacts_.size())
    a = contacts_[node].a, b = contacts_[node].b;
  else
    a = joints_[node - contacts_.size()].a, b = joints_[node - contacts_.size()].b;
}

// Islands in the order of their first node; inside an island nodes keep their order.
void ImpulseSolver::find_islands() {
  const auto node_count = static_cast<std::uint32_t>(contacts_.size() + joints_.size());
  groups_.reset(bodies_.size());
  std::uint32_t a, b;
  for (std::uint32_t node = 0; node < node_count; ++node) {
    node_bodies(node, a, b);
    if (bodies_[a].movable && bodies_[b].movable) groups_.join(a, b);
  }
  island_of_.assign(bodies_.size(), kNone);
  node_island_.resize(node_count);
  islands_.clear();
  for (std::uint32_t node = 0; node < node_count; ++node) {
    node_bodies(node, a, b);
    std::uint32_t& island = island_of_[groups_.root(bodies_[a].movable ? a : b)];
    if (island == kNone) {
      island = static_cast<std::uint32_t>(islands_.size());
      islands_.push_back({0, 0});
    }
    node_island_[node] = island;
    ++islands_[island].last;
  }
  std::uint32_t first = 0;
  for (Island& i : islands_) {
    const std::uint32_t count = i.last;
    i.first = i.last = first;
    first += count;
  }
  order_.resize(node_count);
  for (std::uint32_t node = 0; node < node_count; ++node) order_[islands_[node_island_[node]].last++] = node;
  if constexpr (kAsserts) check_islands();
}

// Each node lies in one island, and both its movable bodies in no other; islands follow each other.
void ImpulseSolver::check_islands() {
  MultisetHash nodes, listed;
  for (std::uint32_t node = 0; node < order_.size(); ++node) nodes.add(node);
  std::uint32_t next = 0, ends[2];
  for (const Island& island : islands_) {
    FEDER_ASSERT(island.first == next && island.first < island.last);
    next = island.last;
    const std::uint32_t name = node_island_[order_[island.first]];
    for (std::uint32_t rank = island.first; rank < island.last; ++rank) {
      listed.add(order_[rank]);
      FEDER_ASSERT(rank == island.first || order_[rank - 1] < order_[rank]);
      node_bodies(order_[rank], ends[0], ends[1]);
      for (const std::uint32_t body : ends)
        FEDER_ASSERT(!bodies_[body].movable || island_of_[groups_.root(body)] == name);
    }
  }
  FEDER_ASSERT(next == order_.size() && nodes == listed);
}

// Ranks of the nodes of each movable body, as one list with a begin per body (counting sort).
void ImpulseSolver::index_nodes() {
  first_rank_.assign(bodies_.size() + 1, 0);
  std::uint32_t ends[2];
  const auto each = [&](auto&& visit) {
    for (std::uint32_t rank = 0; rank < order_.size(); ++rank) {
      node_bodies(order_[rank], ends[0], ends[1]);
      for (const std::uint32_t body : ends)
        if (bodies_[body].movable) visit(body, rank);
    }
  };
  each([&](std::uint32_t body, std::uint32_t) { ++first_rank_[body + 1]; });
  for (std::size_t i = 1; i < first_rank_.size(); ++i) first_rank_[i] += first_rank_[i - 1];
  body_ranks_.resize(first_rank_.back());
  std::uint32_t* next = island_of_.data();  // islands are done with it
  std::copy(first_rank_.begin(), first_rank_.end() - 1, next);
  each([&](std::uint32_t body, std::uint32_t rank) { body_ranks_[next[body]++] = rank; });
  for (std::size_t i = 0; i < bodies_.size(); ++i) FEDER_ASSERT(next[i] == first_rank_[i + 1]);
}

ImpulseScene ImpulseSolver::scene(const SolverInput& in, const StepContext& c) {
  return {in.solver_bodies->state.data(), in.solver_bodies->mass.data(), bodies_.data(), c.h, rest_speed_, slop_};
}

void ImpulseSolver::prepare(const SolverInput& in, StepContext& c) {
  capped_ = 0;
  trees_.clear();
  load_bodies(in);
  load_contacts(in, scene(in, c));
  load_joints(in);
  find_islands();
  index_nodes();
  heap_.reserve(order_.size());
}

void ImpulseSolver::fill(const SolverInput& in, const ImpulseJoint& joint, RowWriter& out) const {
  FEDER_ASSERT(joint.joint < in.joints.size() && in.joints[joint.joint].active);
  const SolverJoint& j = in.joints[joint.joint];
  const JointInput input = in.joint_input(j);
  out.start(input, joint.joint);
  j.kind->fill(input, out);
}

void ImpulseSolver::start_joints(const SolverInput& in, const ImpulseScene& s) {
  rows_.clear();
  blocks_.clear();
  RowWriter out(rows_, blocks_);
  for (ImpulseJoint& joint : joints_) {
    joint.first_block = static_cast<std::uint32_t>(blocks_.size());
    fill(in, joint, out);
    in.joints[joint.joint].rows = static_cast<std::uint8_t>(out.rows_written());
    joint.block_count = static_cast<std::uint32_t>(blocks_.size()) - joint.first_block;
  }
  factors_.resize(blocks_.size());
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const RowBlock& b = blocks_[i];
    factor_block(rows_of(b), s, factors_[i]);
    apply_block(rows_of(b), in.joints[b.joint].impulse + b.first_impulse, s);
  }
}

// Inertia of uneven bodies for the joint solve, at the rotations now; delta rotations of the substep count from here.
void ImpulseSolver::rotate_inertias(const ImpulseScene& s) {
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    ImpulseBody& b = bodies_[i];
    b.substep_rotation = s.state[i].rotation;
    b.substep_delta_rotation = Vec3::Zero();
    if (b.uneven) b.uneven->axes = b.uneven->free_axes = jointed_axes(*b.uneven, s.state[i].rotation);
  }
}

void ImpulseSolver::start_substep(const SolverInput& in, const ImpulseScene& s) {
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    ImpulseBody& b = bodies_[i];
    b.force_velocity = s.state[i].velocity - b.last_velocity;
    b.force_angular_velocity = s.state[i].angular_velocity - b.last_angular_velocity;
    b.impact_delta_position = b.impact_delta_rotation = Vec3::Zero();
  }
  if (!joints_.empty()) rotate_inertias(s);
  for (ImpulseContact& c : contacts_) start_contact(c, s);
  start_joints(in, s);
}

void ImpulseSolver::travel(const SolverBodies& solver_bodies, const ImpulseScene& s) {
  FEDER_ASSERT(bodies_.size() == solver_bodies.state.size());
  for (std::size_t i = 1; i < solver_bodies.state.size(); ++i) {
    SolverBody& m = s.state[i];
    ImpulseBody& b = bodies_[i];
    if (b.uneven) take_pushes(*b.uneven, m);
    const Vec3 rotation = free_delta_rotation(s, static_cast<std::uint32_t>(i));
    b.substep_delta_rotation = rotation;
    m.delta_position += s.h * m.velocity + b.impact_delta_position;
    m.delta_rotation += rotation;
    m.rotation = integrate_rotation(m.rotation, rotation);
  }
}

void ImpulseSolver::factor_trees(const SolverInput& in, const StepContext& c) {
  if (c.substep == 0) trees_.find(rows_, blocks_, *in.solver_bodies);
  FEDER_ASSERT(trees_.knows(blocks_.size()));
  if (trees_.empty()) return;
  tree_inertia_.resize(bodies_.size());
  for (std::size_t i = 0; i < bodies_.size(); ++i) tree_inertia_[i] = bodies_[i].inv_inertia;
  tree_compliance_.resize(rows_.size());
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    for (std::uint32_t k = 0; k < blocks_[i].count; ++k)
      tree_compliance_[blocks_[i].first + k] = factors_[i].factor[k][k];
  trees_.factor({rows_, tree_compliance_}, in, tree_inertia_, true);
  tree_bias_.assign(rows_.size(), Real(0));
  tree_step_.resize(rows_.size());
}

// Adds the solution of the trees to the impulses of their joints, and applies it.
template <auto Apply>
void ImpulseSolver::apply_tree_step(const SolverInput& in, const ImpulseScene& s) {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (!trees_.direct(i)) continue;
    const RowBlock& b = blocks_[i];
    Real* impulse = in.joints[b.joint].impulse + b.first_impulse;
    for (std::uint32_t k = 0; k < b.count; ++k) impulse[k] += tree_step_[b.first + k];
    Apply(rows_of(b), &tree_step_[b.first], s);
  }
}

void ImpulseSolver::solve_tree_speeds(const SolverInput& in, const ImpulseScene& s) {
  tree_bias_.assign(rows_.size(), Real(0));
  trees_.solve(rows_, in.solver_bodies, tree_bias_, tree_step_);
  apply_tree_step<&apply_block>(in, s);
}

// SHAKE: Newton's method for impulses along the rows of the start such that the motion adds no joint error.
void ImpulseSolver::close_tree_drift(const SolverInput& in, const ImpulseScene& s) {
  Real before = kInfinity;
  for (int round = 0; round < kDriftRounds; ++round) {
    Real worst = 0;
    for (const ImpulseJoint& j : joints_) {
      if (!in_tree(j)) continue;
      fill_now(in, j);
      for (std::uint32_t i = 0; i < j.block_count; ++i) {
        if (!trees_.direct(j.first_block + i)) continue;
        const RowBlock &start = blocks_[j.first_block + i], &now = spare_blocks_[i];
        for (std::uint32_t k = 0; k < start.count; ++k) {
          const Real drift = spare_rows_[now.first + k].value - rows_[start.first + k].value;
          tree_bias_[start.first + k] = drift / s.h;
          worst = std::max(worst, std::abs(drift));
        }
      }
    }
    // the rest adds up over the steps: converge to rounding
    if (!(worst > kDriftTolerance / 8) || worst > before / 2) return;
    before = worst;
    trees_.solve(rows_, nullptr, tree_bias_, tree_step_);
    apply_tree_step<&push_back_block>(in, s);
  }
}

Real ImpulseSolver::speed_error(const SolverInput& in, const ImpulseScene& s, std::uint32_t rank) {
  const std::uint32_t node = order_[rank];
  if (node < contacts_.size()) return contact_speed_error(contacts_[node], s);
  const ImpulseJoint& j = joints_[node - contacts_.size()];
  Real worst = 0;
  for (std::uint32_t i = j.first_block; i < j.first_block + j.block_count; ++i) {
    const RowBlock& b = blocks_[i];
    const Real* impulse = in.joints[j.joint].impulse + b.first_impulse;
    worst = std::max(worst, block_speed_error(rows_of(b), factors_[i], impulse, s));
  }
  return worst;
}

void ImpulseSolver::solve_speed(const SolverInput& in, const ImpulseScene& s, std::uint32_t rank) {
  const std::uint32_t node = order_[rank];
  if (node < contacts_.size()) return solve_contact_speed(contacts_[node], s, tolerance_ / 4);
  const ImpulseJoint& j = joints_[node - contacts_.size()];
  for (std::uint32_t i = j.first_block; i < j.first_block + j.block_count; ++i) {
    const RowBlock& b = blocks_[i];
    solve_block_speed(rows_of(b), factors_[i], in.joints[j.joint].impulse + b.first_impulse, s);
  }
}

// Rows of one joint at the poses now, into the spare arrays.
void ImpulseSolver::fill_now(const SolverInput& in, const ImpulseJoint& joint) {
  spare_rows_.clear();
  spare_blocks_.clear();
  RowWriter out(spare_rows_, spare_blocks_);
  fill(in, joint, out);
  FEDER_ASSERT(spare_blocks_.size() == joint.block_count);
}

Real ImpulseSolver::drift_error(const SolverInput& in, const ImpulseScene&, std::uint32_t rank) {
  const std::uint32_t node = order_[rank];
  if (node < contacts_.size()) return 0;
  const ImpulseJoint& j = joints_[node - contacts_.size()];
  fill_now(in, j);
  Real worst = 0;
  for (std::uint32_t i = 0; i < j.block_count; ++i) {
    if (in_tree(j) && trees_.direct(j.first_block + i)) continue;
    const RowBlock &start = blocks_[j.first_block + i], &now = spare_blocks_[i];
    worst = std::max(worst, block_drift(rows_of(start), spare_rows_of(now)));
  }
  return worst;
}

void ImpulseSolver::correct_drift(const SolverInput& in, const ImpulseScene& s, std::uint32_t rank) {
  const ImpulseJoint& j = joints_[order_[rank] - contacts_.size()];
  fill_now(in, j);
  for (std::uint32_t i = 0; i < j.block_count; ++i) {
    const RowBlock &start = blocks_[j.first_block + i], &now = spare_blocks_[i];
    correct_block_drift(rows_of(start), spare_rows_of(now), factors_[j.first_block + i],
                        in.joints[j.joint].impulse + start.first_impulse, s);
  }
}

Real ImpulseSolver::position_error(const SolverInput& in, const ImpulseScene& s, std::uint32_t rank) {
  const std::uint32_t node = order_[rank];
  if (node < contacts_.size()) return contact_depth(contacts_[node], s);
  fill_now(in, joints_[node - contacts_.size()]);
  Real worst = 0;
  for (const RowBlock& b : spare_blocks_) worst = std::max(worst, block_position_error(spare_rows_of(b)));
  return worst;
}

void ImpulseSolver::correct_position(const SolverInput& in, const ImpulseScene& s, std::uint32_t rank) {
  const std::uint32_t node = order_[rank];
  if (node < contacts_.size()) return push_contact_apart(contacts_[node], s);
  fill_now(in, joints_[node - contacts_.size()]);
  for (const RowBlock& b : spare_blocks_) correct_block(spare_rows_of(b), s);
}

template <auto Error, auto Fix>
void ImpulseSolver::worst_first(const SolverInput& in, const ImpulseScene& s, const Island& island, Real tolerance) {
  heap_.build(island.first, island.last, [&](std::uint32_t rank) { return (this->*Error)(in, s, rank); });
  const std::uint64_t cap = static_cast<std::uint64_t>(pops_per_node_) * (island.last - island.first);
  for (std::uint64_t pop = 0; heap_.top_key() > tolerance; ++pop) {
    if (pop == cap) {
      ++capped_;
      return;
    }
    const std::uint32_t rank = heap_.top();
    FEDER_ASSERT(rank >= island.first && rank < island.last);
    (this->*Fix)(in, s, rank);
    std::uint32_t ends[2];
    node_bodies(order_[rank], ends[0], ends[1]);
    for (const std::uint32_t body : ends)
      for (std::uint32_t i = first_rank_[body]; i < first_rank_[body + 1]; ++i)
        heap_.update(body_ranks_[i], (this->*Error)(in, s, body_ranks_[i]));
  }
}

// Whether contacts of the island begin to slide: their speeds must be solved again then.
bool ImpulseSolver::check_slip(const ImpulseScene& s, const Island& island) {
  bool some = false;
  for (std::uint32_t rank = island.first; rank < island.last; ++rank) {
    const std::uint32_t node = order_[rank];
    if (node >= contacts_.size() || !begins_to_slide(contacts_[node], s)) continue;
    contacts_[node].slides = some = true;
  }
  return some;
}

void ImpulseSolver::solve(const SolverInput& in, StepContext& c) {
  const ImpulseScene s = scene(in, c);
  FEDER_ASSERT(in.solver_bodies->mass.size() == bodies_.size());  // prepared for these solver bodies
  start_substep(in, s);
  if (!joints_.empty()) factor_trees(in, c);
  if (!trees_.empty()) solve_tree_speeds(in, s);
  for (const Island& island : islands_)
    for (int round = 0;; ++round) {
      worst_first<&ImpulseSolver::speed_error, &ImpulseSolver::solve_speed>(in, s, island, tolerance_);
      if (round == kSlipRounds || !check_slip(s, island)) break;
    }
  travel(*in.solver_bodies, s);
  if (!joints_.empty()) {
    if (!trees_.empty()) close_tree_drift(in, s);
    for (const Island& island : islands_)
      worst_first<&ImpulseSolver::drift_error, &ImpulseSolver::correct_drift>(in, s, island, kDriftTolerance);
    rotate_inertias(s);
  }
  for (const Island& island : islands_)
    worst_first<&ImpulseSolver::position_error, &ImpulseSolver::correct_position>(in, s, island, slop_ / 10);
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    bodies_[i].last_velocity = s.state[i].velocity;
    bodies_[i].last_angular_velocity = s.state[i].angular_velocity;
  }
  for (const ImpulseJoint& j : joints_)
    if (in.joints[j.joint].breakable)
      note_force(in.joints[j.joint], rows_, std::span(blocks_).subspan(j.first_block, j.block_count), s.h);
  for (const ImpulseContact& contact : contacts_) {
    Contact& to = in.contacts->slots[contact.slot];
    FEDER_ASSERT(to.collider_a != kNone && to.point_count == contact.count);
    for (int i = 0; i < contact.count; ++i)
      to.points[i].total_impulse += dot(contact.normal, contact.points[i].impulse) + contact.points[i].bounced;
  }
}

void ImpulseSolver::finish(const SolverInput& in, StepContext&) {
  for (const ImpulseContact& contact : contacts_) store_contact(contact, in.contacts->slots[contact.slot]);
}

}  // namespace

Variant<RigidSolver> rigid_impulse() {
  return {
      "impulse", "worst first, one closed-form impulse at a time: the classical loop",
      [](Arena& a, const Params& p) -> std::unique_ptr<RigidSolver> { return std::make_unique<ImpulseSolver>(a, p); }};
}

}  // namespace feder
