// Linear-time elimination along trees of joints (Baraff, "Linear-Time Dynamics using Lagrange Multipliers", 1996;
// the same recursion as Featherstone's articulated inertia). Unknown are the velocity changes dv of the bodies and
// the impulses p of the links, M dv = J^T p and J dv + g p = -(J v + bias). From the leaves up, a child is eliminated
// into its parent: A = M + sum J_up^T Y^-1 J_up with Y = J_own A_child^-1 J_own^T + g; then impulses follow from the
// root down. g is a compliance: at rounding level, so that redundant rows of a joint are solvable; larger at anchors
// that close a chain.
// In double precision, because Y spans the mass ratio. Nothing is kept between calls of find(). Loops of bodies,
// springs, limits and motors stay with the iterative rows.
#include "rigid/joint_trees.h"

#include "base/hash.h"

namespace feder {
namespace {

bool moves(const SolverMass& m) { return m.inv_mass > 0; }

bool stiff(const Row& r) { return r.lower == -kInfinity && r.upper == kInfinity && r.hertz == 0; }

}  // namespace

void JointTrees::collect_links(std::span<const Row> rows, std::span<const RowBlock> blocks,
                               const SolverBodies& solver_bodies) {
  links_.clear();
  for (const RowBlock& block : blocks) {
    bool all = true;
    for (std::uint32_t k = 0; k < block.count; ++k) all = all && stiff(rows[block.first + k]);
    if (!all) continue;
    FEDER_ASSERT(links_.empty() || links_.back().joint <= block.joint);
    if (links_.empty() || links_.back().joint != block.joint) {
      Link link;
      link.index_a = moves(solver_bodies.mass[block.index_a]) ? block.index_a : 0;
      link.index_b = moves(solver_bodies.mass[block.index_b]) ? block.index_b : 0;
      link.state_a = block.index_a;
      link.state_b = block.index_b;
      link.joint = block.joint;
      links_.push_back(link);
    }
    Link& link = links_.back();
    if (link.rows + block.count > kMaxRows) continue;
    for (std::uint32_t k = 0; k < block.count; ++k) link.row[link.rows++] = block.first + k;
  }
}

// Joins the links' bodies; accepts the components without loops and with something to move.
void JointTrees::accept_trees() {
  for (Link& link : links_) {
    if (!link.index_a || !link.index_b) continue;
    const std::uint32_t a = trees_.root(link.index_a), b = trees_.root(link.index_b);
    const bool cyclic = a == b || cyclic_[a] || cyclic_[b];  // a link within a tree closes a loop
    cyclic_[trees_.join(a, b)] = cyclic;
  }
  for (Link& link : links_) {
    link.root = trees_.root(link.index_a ? link.index_a : link.index_b);
    ++count_[link.root];
  }
  // a single link is a tree too: softened rows would leave part of what warm-start impulses do in the new pose, a
  // rotation about the long axis of slender bodies
  for (Link& link : links_)
    if (cyclic_[link.root] || (!link.index_a && !link.index_b)) link.root = kNone;
}

// Appends the node of a body and queues it.
void JointTrees::grow(std::uint32_t index, std::uint32_t parent, std::uint32_t link) {
  FEDER_ASSERT(index != 0 && !visited_[index]);  // visited twice would be a loop
  Node node;
  node.solver_index = index;
  node.parent = parent;
  node.link = link;
  node.tree = parent == kNone ? static_cast<std::uint32_t>(nodes_.size()) : nodes_[parent].tree;
  node_of_[index] = static_cast<std::uint32_t>(nodes_.size());
  if (link != kNone) node.rows = links_[link].rows, node.body_is_a = links_[link].index_a == index;
  queue_.push_back(static_cast<std::uint32_t>(nodes_.size()));
  nodes_.push_back(node);
  visited_[index] = 1;
}

void JointTrees::order_nodes(std::size_t body_count) {
  // edges by solver index: counting sort
  first_edge_.assign(body_count + 1, 0);
  const auto each_side = [&](auto&& f) {
    for (std::uint32_t l = 0; l < links_.size(); ++l) {
      if (links_[l].root == kNone) continue;
      if (links_[l].index_a) f(links_[l].index_a, l);
      if (links_[l].index_b) f(links_[l].index_b, l);
    }
  };
  each_side([&](std::uint32_t m, std::uint32_t) { ++first_edge_[m + 1]; });
  for (std::size_t m = 0; m < body_count; ++m) first_edge_[m + 1] += first_edge_[m];
  edges_.resize(first_edge_[body_count]);
  count_.assign(first_edge_.begin(), first_edge_.end());
  each_side([&](std::uint32_t m, std::uint32_t l) { edges_[count_[m]++] = l; });
  // breadth first; links to the world are roots, the first of a tree its root link
  for (int pass = 0; pass < 2; ++pass) {
    for (std::uint32_t l = 0; l < links_.size(); ++l) {
      const Link& link = links_[l];
      if (link.root == kNone) continue;
      const bool anchored = !link.index_a || !link.index_b;
      const std::uint32_t start = link.index_a ? link.index_a : link.index_b;
      if (visited_[start] || (pass == 0 && !anchored)) continue;
      queue_.clear();
      grow(start, kNone, anchored ? l : kNone);
      for (std::size_t q = 0; q < queue_.size(); ++q) {
        const std::uint32_t at = queue_[q], index = nodes_[at].solver_index, from = nodes_[at].link;
        for (std::uint32_t e = first_edge_[index]; e < first_edge_[index + 1]; ++e) {
          const Link& next = links_[edges_[e]];
          if (edges_[e] == from) continue;
          const std::uint32_t other = next.index_a == index ? next.index_b : next.index_a;
          if (other) {
            if (!visited_[other]) grow(other, at, edges_[e]);
            continue;
          }
          // a second anchor: a leaf without a body
          Node leaf;
          leaf.parent = at;
          leaf.link = edges_[e];
          leaf.tree = nodes_[at].tree;
          leaf.leaf = true;
          leaf.rows = next.rows;
          leaf.body_is_a = next.index_a != index;
          nodes_.push_back(leaf);
        }
      }
    }
  }
}

// Checks the order: parents before children; each accepted link belongs to one node, whose body it moves.
void JointTrees::check_nodes() const {
  MultisetHash accepted, placed;
  for (std::uint32_t l = 0; l < links_.size(); ++l)
    if (links_[l].root != kNone) accepted.add(l);
  for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
    const Node& node = nodes_[n];
    FEDER_ASSERT(node.parent == kNone || (node.parent < n && !nodes_[node.parent].leaf));
    if (node.link == kNone) continue;
    placed.add(node.link);
    const Link& link = links_[node.link];
    FEDER_ASSERT(node.leaf || (node.body_is_a ? link.index_a : link.index_b) == node.solver_index);
    FEDER_ASSERT(node.rows == link.rows && node.rows >= 1);
  }
  FEDER_ASSERT(accepted == placed);
}

void JointTrees::find(std::span<const Row> rows, std::span<const RowBlock> blocks, const SolverBodies& solver_bodies) {
  const std::size_t count = solver_bodies.state.size();
  nodes_.clear();
  direct_.assign(blocks.size(), 0);
  node_of_.assign(count, kNone);
  collect_links(rows, blocks, solver_bodies);
  if (links_.empty()) return;
  trees_.reset(count);
  cyclic_.assign(count, 0);
  count_.assign(count, 0);
  visited_.assign(count, 0);
  accept_trees();
  order_nodes(count);
  if constexpr (kAsserts) check_nodes();
  // blocks of accepted links
  std::size_t l = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    while (l < links_.size() && links_[l].joint < blocks[i].joint) ++l;
    if (l == links_.size()) break;
    if (links_[l].joint != blocks[i].joint || links_[l].root == kNone) continue;
    for (int k = 0; k < links_[l].rows; ++k) direct_[i] |= links_[l].row[k] == blocks[i].first;
  }
  place_numbers();
}

bool JointTrees::joins(std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t x = node_of(a), y = node_of(b);
  if (x == kNone || y == kNone) return x != y;
  return nodes_[x].tree == nodes_[y].tree;
}

void JointTrees::leave_out(std::span<const std::uint8_t> left_out, std::span<const RowBlock> blocks) {
  if (direct_.empty()) return;
  FEDER_ASSERT(left_out.size() == blocks.size() && direct_.size() == blocks.size());
  new_row_.clear();
  std::uint32_t row = 0, kept = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    FEDER_ASSERT(!left_out[i] || !direct_[i]);
    for (std::uint32_t k = 0; k < blocks[i].count; ++k) new_row_.push_back(left_out[i] ? kNone : row++);
    if (!left_out[i]) direct_[kept++] = direct_[i];
  }
  direct_.resize(kept);
  for (Link& link : links_)
    for (int k = 0; k < link.rows; ++k) link.row[k] = new_row_[link.row[k]];
}

}  // namespace feder
