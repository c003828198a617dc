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

constexpr double kCompliance = 1e-8;  // of a row's own compliance
// The same of an anchor that closes a chain between two anchors to the world. Directions that such a chain constrains
// twice (parallel hinges: three of six) get impulses of misfit / compliance, and as axes tilt a little, those move
// bodies. Impulses are kept from substep to substep, so that it acts as a stiffness of 1/(h^2 compliance), not as
// creep.
constexpr double kClosingCompliance = 1e-3;

// In place L D L^T of a symmetric matrix in packed rows (lower triangle); the diagonal becomes 1/D.
void factorize(double* m, int n) {
  FEDER_ASSERT(n >= 0 && n <= 6);
  for (int i = 0; i < n; ++i) {
    double* row = m + i * (i + 1) / 2;
    for (int j = 0; j < i; ++j) {
      const double* other = m + j * (j + 1) / 2;
      for (int k = 0; k < j; ++k) row[j] -= row[k] * other[k];
    }
    for (int j = 0; j < i; ++j) {
      const double scaled = row[j] * m[j * (j + 1) / 2 + j];
      row[i] -= row[j] * scaled;
      row[j] = scaled;
    }
    row[i] = row[i] > 0 ? 1 / row[i] : 0;
  }
}

void solve_factors(const double* m, int n, double* x) {
  for (int i = 1; i < n; ++i)
    for (int k = 0; k < i; ++k) x[i] -= m[i * (i + 1) / 2 + k] * x[k];
  for (int i = 0; i < n; ++i) x[i] *= m[i * (i + 1) / 2 + i];
  for (int i = n - 1; i > 0; --i)
    for (int k = 0; k < i; ++k) x[k] -= m[i * (i + 1) / 2 + k] * x[i];
}

double dot6(const double* a, const double* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5];
}

bool moves(const SolverMass& m) { return m.inv_mass > 0; }

bool stiff(const Row& r) { return r.lower == -kInfinity && r.upper == kInfinity && r.hertz == 0; }

// Mass matrix, packed. A locked axis gets a mass beyond all others.
void mass_matrix(const SolverMass& m, const JointedBody* uneven, const Mat3& inv_inertia, double* out) {
  FEDER_ASSERT(m.inv_mass > 0);
  const double heavy = 1e9 / static_cast<double>(m.inv_mass);
  for (int i = 0; i < 21; ++i) out[i] = 0;
  for (int k = 0; k < 3; ++k) {
    const double inv = static_cast<double>(m.inv_mass_axes[k]);
    out[k * (k + 1) / 2 + k] = inv > 0 ? 1 / inv : heavy;
  }
  if (uneven) {
    for (int k = 3; k < 6; ++k) out[k * (k + 1) / 2 + k] = 1 / (uneven->inv_moments[k - 3] * uneven->share[k - 3]);
    return;
  }
  double inv[3][3], largest = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) inv[i][j] = 0.5 * static_cast<double>(inv_inertia(i, j) + inv_inertia(j, i));
  for (int i = 0; i < 3; ++i) largest = inv[i][i] > largest ? inv[i][i] : largest;
  for (int i = 0; i < 3; ++i) inv[i][i] += inv[i][i] > 0 ? 0 : (largest > 0 ? 1e-9 * largest : 1e-9 / heavy);
  double c[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      c[i][j] = inv[i1][j1] * inv[i2][j2] - inv[i1][j2] * inv[i2][j1];
    }
  }
  const double det = inv[0][0] * c[0][0] + inv[0][1] * c[0][1] + inv[0][2] * c[0][2];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) out[(i + 3) * (i + 4) / 2 + j + 3] = c[i][j] / det;
}

// Jacobian of one side, in world axes; the angular part of an uneven body in its principal axes.
void jacobian(const Row& row, bool side_a, const JointedBody* uneven, double* out) {
  const Vec3& moment = side_a ? row.angular_a : row.angular_b;
  const Vec3d local = uneven ? uneven->in_axes(moment) : Vec3d(moment.cast<double>());
  const double sign = side_a ? -1 : 1;
  for (int k = 0; k < 3; ++k) {
    out[k] = sign * static_cast<double>(row.linear[k]);
    out[k + 3] = local[k];
  }
}

// Compliance of a row through one body, J M^-1 J^T.
double compliance(const Row& row, const Vec3& moment, const SolverMass& m, const JointedBody* uneven,
                  const Mat3& inv_inertia) {
  const double straight = static_cast<double>(dot(row.linear, Vec3(m.inv_mass_axes.cwiseProduct(row.linear))));
  if (!uneven) return straight + static_cast<double>(dot(moment, Vec3(inv_inertia * moment)));
  const Vec3d local = uneven->in_axes(moment);
  return straight + local.dot(uneven->felt().cwiseProduct(local));
}

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
  response_.resize(nodes_.size() * 6);
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

// Eliminates one node into its parent.
void JointTrees::factor_node(Node& node, std::span<const Row> rows, const SolverInput& in,
                             std::span<const Mat3> inv_inertia) {
  const JointedBody* own = node.leaf ? nullptr : in.uneven(node.solver_index);
  const JointedBody* up = node.parent == kNone ? nullptr : in.uneven(nodes_[node.parent].solver_index);
  // Jacobians now
  for (int i = 0; i < node.rows; ++i) {
    const Row& row = rows[links_[node.link].row[i]];
    jacobian(row, node.body_is_a, own, node.own[i]);
    jacobian(row, !node.body_is_a, up, node.up[i]);
  }
  if (!node.leaf) factorize(node.inertia, 6);
  // Y = own A^-1 own^T + g
  for (int i = 0; i < node.rows; ++i) {
    double* y = node.stiffness + i * (i + 1) / 2;
    if (node.leaf) {
      for (int j = 0; j < i; ++j) y[j] = 0;
    } else {
      for (int k = 0; k < 6; ++k) node.weight[i][k] = node.own[i][k];
      solve_factors(node.inertia, 6, node.weight[i]);
      for (int j = 0; j <= i; ++j) y[j] = dot6(node.weight[i], node.own[j]);
    }
    const Row& row = rows[links_[node.link].row[i]];
    const std::uint32_t a = links_[node.link].index_a, b = links_[node.link].index_b;
    const double alone = compliance(row, row.angular_a, in.solver_bodies->mass[a], in.uneven(a), inv_inertia[a]) +
                         compliance(row, row.angular_b, in.solver_bodies->mass[b], in.uneven(b), inv_inertia[b]);
    y[i] = (node.leaf ? kClosingCompliance * alone : y[i] + kCompliance * alone) + 1e-30;
  }
  factorize(node.stiffness, node.rows);
  if (node.parent == kNone) return;
  // A_parent += up^T Y^-1 up
  double scaled[kMaxRows];
  double* a = nodes_[node.parent].inertia;
  for (int k = 0; k < 6; ++k) {
    for (int i = 0; i < node.rows; ++i) scaled[i] = node.up[i][k];
    solve_factors(node.stiffness, node.rows, scaled);
    for (int m = 0; m <= k; ++m)
      for (int i = 0; i < node.rows; ++i) a[k * (k + 1) / 2 + m] += scaled[i] * node.up[i][m];
  }
}

void JointTrees::factor(std::span<const Row> rows, const SolverInput& in, std::span<const Mat3> inv_inertia) {
  FEDER_ASSERT(inv_inertia.size() == in.solver_bodies->state.size());
  for (Node& node : nodes_)
    if (!node.leaf)
      mass_matrix(in.solver_bodies->mass[node.solver_index], in.uneven(node.solver_index),
                  inv_inertia[node.solver_index], node.inertia);
  for (std::size_t i = nodes_.size(); i-- > 0;) factor_node(nodes_[i], rows, in, inv_inertia);
}

Real JointTrees::speed(const Row& row, const Link& link, const SolverBodies& solver_bodies) {
  const SolverBody &a = solver_bodies.state[link.state_a], &b = solver_bodies.state[link.state_b];
  return dot(row.linear, Vec3(b.velocity - a.velocity)) + dot(row.angular_b, b.angular_velocity) +
         dot(row.angular_a, a.angular_velocity);
}

void JointTrees::solve(std::span<const Row> rows, const SolverBodies* solver_bodies, std::span<const Real> bias,
                       std::span<Real> step) {
  FEDER_ASSERT(bias.size() == rows.size() && step.size() == rows.size());
  FEDER_ASSERT(response_.size() == nodes_.size() * 6);
  for (Node& node : nodes_)
    for (double& x : node.load) x = 0;
  // leaves to root: the right-hand side of each link, less the response of its child
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    for (int i = 0; i < node.rows; ++i) {
      const std::uint32_t r = links_[node.link].row[i];
      node.wanted[i] =
          -static_cast<double>(solver_bodies ? speed(rows[r], links_[node.link], *solver_bodies) + bias[r] : bias[r]);
      if (!node.leaf) node.wanted[i] -= dot6(node.weight[i], node.load);
    }
    if (node.parent == kNone) continue;
    double p[kMaxRows];
    for (int i = 0; i < node.rows; ++i) p[i] = node.wanted[i];
    solve_factors(node.stiffness, node.rows, p);
    for (int i = 0; i < node.rows; ++i)
      for (int k = 0; k < 6; ++k) nodes_[node.parent].load[k] += node.up[i][k] * p[i];
  }
  // root to leaves: impulses, given the parent's velocity change
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const Node& node = nodes_[n];
    double p[kMaxRows];
    for (int i = 0; i < node.rows; ++i) {
      p[i] = node.wanted[i];
      if (node.parent != kNone) p[i] -= dot6(node.up[i], &response_[6 * node.parent]);
    }
    solve_factors(node.stiffness, node.rows, p);
    for (int i = 0; i < node.rows; ++i) step[links_[node.link].row[i]] = static_cast<Real>(p[i]);
    if (node.leaf) continue;
    double* dv = &response_[6 * n];
    for (int k = 0; k < 6; ++k) {
      dv[k] = node.load[k];
      for (int i = 0; i < node.rows; ++i) dv[k] += node.own[i][k] * p[i];
    }
    solve_factors(node.inertia, 6, dv);
  }
}

}  // namespace feder
