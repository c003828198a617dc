// Direct solver for the stiff joints of tree-shaped mechanisms (chains, ragdolls): exact in one pass, at any mass
// ratio. Trees are found in joint_trees.cpp and solved in
// tree_elimination.cpp.
#pragma once
#include "feder/error.h"
#include "rigid/solver.h"
#include "rigid/union_find.h"
#include "state/rows.h"
#include "state/solver_bodies.h"

namespace feder {

// Rows of a substep, and the compliance J M^-1 J^T of each alone, 1/kg or 1/(kg m^2).
struct TreeRows {
  std::span<const Row> rows;
  std::span<const Real> compliance;
};

class JointTrees {
 public:
  explicit JointTrees(Arena& arena) : arena_(arena) {}

  // Finds the blocks that belong to trees; once per step, since the number of rows does not change within it.
  void find(std::span<const Row> rows, std::span<const RowBlock> blocks, const SolverBodies& solver_bodies);
  void clear() { nodes_.clear(), direct_.clear(); }
  // Takes blocks that are in no tree out of the numbering, with their rows. `left_out`: by block, as given to find().
  void leave_out(std::span<const std::uint8_t> left_out, std::span<const RowBlock> blocks);
  std::size_t blocks() const { return direct_.size(); }
  bool empty() const { return nodes_.empty(); }
  bool knows(std::size_t blocks) const { return direct_.size() == blocks; }  // the number of blocks is that of find()
  bool direct(std::size_t block) const {
    FEDER_ASSERT(block < direct_.size());
    return direct_[block] != 0;
  }

  // A tree joins the two solver bodies, or one of them to an immovable one.
  bool joins(std::uint32_t a, std::uint32_t b) const;
  // Number of its first node.
  std::uint32_t tree_of(std::uint32_t a, std::uint32_t b) const {
    return nodes_[node_of(a) != kNone ? node_of(a) : node_of(b)].tree;
  }
  // What a unit impulse along a row of `block` does to the tree that joins() its bodies, whose joints hold.
  void respond(const RowBlock& block, std::span<const Row> rows, const SolverInput& in, std::span<const Real> no_bias,
               std::span<Real> step);
  // The change along a row of such a block by the last respond() in the same tree.
  double response(const RowBlock& block, std::span<const Row> rows, const SolverInput& in) const;

  // Of the tree that a solver body belongs to.
  std::uint32_t root(std::uint32_t index) { return trees_.root(index); }

  // Once per substep. `inv_inertia`: of even bodies now, world, by solver index; uneven ones are solved in principal
  // axes. `fresh`: masses or inertias are not those of the substep before.
  void factor(const TreeRows& rows, const SolverInput& in, std::span<const Mat3> inv_inertia, bool fresh);
  // Impulses such that J v = -bias for all rows of the trees at once, written to `step` by row. Without solver bodies
  // v is 0: impulses that change J v by -bias.
  void solve(std::span<const Row> rows, const SolverBodies* solver_bodies, std::span<const Real> bias,
             std::span<Real> step);
  // Adds to the velocities what the impulses of the last solve() do, in worlds without uneven jointed bodies.
  void move_bodies(SolverBodies& solver_bodies) const;

 private:
  static constexpr int kMaxRows = 6;

  // Edge of the graph: the stiff rows of a joint.
  struct Link {
    std::uint32_t index_a = 0, index_b = 0;  // 0: immovable
    std::uint32_t state_a = 0, state_b = 0;  // the same, kinematic bodies included
    std::uint32_t row[kMaxRows];
    int rows = 0;
    std::uint32_t root = kNone;  // root of the tree in the union-find; kNone: not solved here
    std::uint32_t joint = 0;
  };
  // A body and the link to its parent (or to the world).
  struct Node {
    std::uint32_t solver_index = 0, parent = kNone;  // parent: index in nodes_
    std::uint32_t link = kNone;
    std::uint32_t tree = 0;  // index in nodes_ of its first one
    bool body_is_a = false;
    bool leaf = false;  // a second anchor of the parent to the world: a node without a body
    int rows = 0;
    std::uint32_t first = 0;  // of its numbers, in numbers_
  };
  void collect_links(std::span<const Row> rows, std::span<const RowBlock> blocks, const SolverBodies& solver_bodies);
  void accept_trees();
  void order_nodes(std::size_t body_count);
  void check_nodes() const;
  void grow(std::uint32_t index, std::uint32_t parent, std::uint32_t link);
  void place_numbers();
  std::uint32_t node_of(std::uint32_t index) const { return index < node_of_.size() ? node_of_[index] : kNone; }
  void gather(std::uint32_t first, std::uint32_t last, std::span<const Row> rows, const SolverBodies* solver_bodies,
              std::span<const Real> bias);
  void push(std::uint32_t first, std::uint32_t last, std::span<Real> step);
  template <int N>
  void factor_link(const Node& node, const TreeRows& rows, const SolverInput& in);
  template <int N>
  void gather_link(const Node& node, std::span<const Row> rows, const SolverBodies* solver_bodies,
                   std::span<const Real> bias);
  template <int N>
  void push_link(const Node& node, std::span<Real> step);

  Arena& arena_;
  Array<Link> links_{&arena_};
  Array<Node> nodes_{&arena_};                                 // parents before children
  Array<std::uint32_t> edges_{&arena_}, first_edge_{&arena_};  // links by solver index
  UnionFind trees_{arena_};                                    // of solver bodies
  Array<std::uint8_t> cyclic_;
  Array<std::uint32_t> count_;  // links of a tree
  Array<std::uint8_t> visited_, direct_;
  Array<std::uint32_t> node_of_{&arena_};  // by solver index, kNone where it is in no tree
  Array<std::uint32_t> queue_;
  Array<std::uint32_t> new_row_;
  Array<double> masses_;   // mass matrices of the nodes, packed
  Array<double> numbers_;  // of the nodes, packed: see tree_elimination.cpp
};

}  // namespace feder
