// The elimination along trees of joints; the method is described in joint_trees.cpp. Nodes are packed: the numbers of a
// body, then those of its link, by its number of rows. All loops over rows and axes have fixed bounds and are unrolled,
// since the matrices are smaller than the loops around them.
#include <array>
#include <cstring>
#include <utility>

#include "rigid/joint_trees.h"

namespace feder {
namespace {

constexpr double kCompliance = 1e-8;  // of a row's own compliance
// The same of an anchor that closes a chain between two anchors to the world. Directions that such a chain constrains
// twice (parallel hinges: three of six) get impulses of misfit / compliance, and as axes tilt a little, those move
// bodies. Impulses are kept from substep to substep, so that it acts as a stiffness of 1/(h^2 compliance), not as
// creep.
constexpr double kClosingCompliance = 1e-3;

// Calls f(0) ... f(Count - 1) with constants.
template <int Count, class F>
[[gnu::always_inline]] inline void unrolled(F&& f) {
  [&]<int... I>(std::integer_sequence<int, I...>) __attribute__((always_inline)) {
    (f(std::integral_constant<int, I>{}), ...);
  }
  (std::make_integer_sequence<int, Count>{});
}

// Place of row i, column k <= i in packed rows.
constexpr int packed(int i, int k) { return i * (i + 1) / 2 + k; }

// In place L D L^T of a symmetric matrix in packed rows (lower triangle); the diagonal becomes 1/D.
template <int N>
[[gnu::always_inline]] inline void factorize(double* m) {
  unrolled<N>([&](auto i) __attribute__((always_inline)) {
    double* row = m + packed(i, 0);
    unrolled<i>([&](auto j) __attribute__((always_inline)) {
      unrolled<j>([&](auto k) __attribute__((always_inline)) { row[j] -= row[k] * m[packed(j, k)]; });
    });
    unrolled<i>([&](auto j) __attribute__((always_inline)) {
      const double scaled = row[j] * m[packed(j, j)];
      row[i] -= row[j] * scaled;
      row[j] = scaled;
    });
    row[i] = row[i] > 0 ? 1 / row[i] : 0;
  });
}

template <int N>
[[gnu::always_inline]] inline void solve_factors(const double* m, double* to) {
  double x[N];
  unrolled<N>([&](auto i) __attribute__((always_inline)) { x[i] = to[i]; });
  unrolled<N>([&](auto i) __attribute__((always_inline)) {
    unrolled<i>([&](auto k) __attribute__((always_inline)) { x[i] -= m[packed(i, k)] * x[k]; });
  });
  unrolled<N>([&](auto i) __attribute__((always_inline)) { x[i] *= m[packed(i, i)]; });
  unrolled<N>([&](auto n) __attribute__((always_inline)) {
    constexpr int i = N - 1 - n;
    unrolled<i>([&](auto k) __attribute__((always_inline)) { x[k] -= m[packed(i, k)] * x[i]; });
  });
  unrolled<N>([&](auto i) __attribute__((always_inline)) { to[i] = x[i]; });
}

[[gnu::always_inline]] inline double dot6(const double* a, const double* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5];
}

constexpr std::size_t kTriangle = 21;  // of a symmetric matrix over six axes

// Numbers of a node: of its body, and of the link to its parent with N rows.
struct BodyNumbers {
  double inertia[kTriangle];  // factors of the articulated inertia
  double load[6];             // impulses that the children ask for
  double response[6];         // velocity change
};
template <int N>
struct LinkNumbers {
  double own[N][6], up[N][6];         // Jacobians of the two sides
  double weight[N][6];                // own x inverse inertia
  double across[N][6];                // inverse stiffness x up
  double stiffness[N * (N + 1) / 2];  // factors of weight x own^T + regularisation
  double wanted[N];                   // impulses for a parent at rest
};
constexpr std::size_t kBodyDoubles = sizeof(BodyNumbers) / sizeof(double);

BodyNumbers& body_of(double* numbers) { return *reinterpret_cast<BodyNumbers*>(numbers); }
const BodyNumbers& body_of(const double* numbers) { return *reinterpret_cast<const BodyNumbers*>(numbers); }
template <int N>
LinkNumbers<N>& link_of(double* numbers) {
  return *reinterpret_cast<LinkNumbers<N>*>(numbers + kBodyDoubles);
}

template <int... N>
constexpr auto link_doubles(std::integer_sequence<int, N...>) {
  return std::array<std::size_t, sizeof...(N) + 1>{0, sizeof(LinkNumbers<N + 1>) / sizeof(double)...};
}
constexpr auto kLinkDoubles = link_doubles(std::make_integer_sequence<int, 6>{});  // by number of rows

// Calls f with the number of rows as a constant; not at all when there are none.
template <class F>
void with_rows(int rows, F&& f) {
  switch (rows) {
    case 1: return f(std::integral_constant<int, 1>{});
    case 2: return f(std::integral_constant<int, 2>{});
    case 3: return f(std::integral_constant<int, 3>{});
    case 4: return f(std::integral_constant<int, 4>{});
    case 5: return f(std::integral_constant<int, 5>{});
    case 6: return f(std::integral_constant<int, 6>{});
    default: FEDER_ASSERT(rows == 0);
  }
}

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
[[gnu::always_inline]] inline void jacobian(const Row& row, bool side_a, const JointedBody* uneven, double* out) {
  const Vec3& moment = side_a ? row.angular_a : row.angular_b;
  const Vec3d local = uneven ? uneven->in_axes(moment) : Vec3d(moment.cast<double>());
  const double sign = side_a ? -1 : 1;
  for (int k = 0; k < 3; ++k) {
    out[k] = sign * static_cast<double>(row.linear[k]);
    out[k + 3] = local[k];
  }
}

}  // namespace

void JointTrees::place_numbers() {
  std::size_t count = 0;
  for (Node& node : nodes_) {
    node.first = static_cast<std::uint32_t>(count);
    count += kBodyDoubles + kLinkDoubles[static_cast<std::size_t>(node.rows)];
  }
  numbers_.assign(count, 0);
  masses_.assign(nodes_.size() * kTriangle, 0);
}

// Eliminates one node into its parent.
template <int N>
void JointTrees::factor_link(const Node& node, const TreeRows& rows, const SolverInput& in) {
  const Link& link = links_[node.link];
  const JointedBody* own = node.leaf ? nullptr : in.uneven(node.solver_index);
  const JointedBody* up = node.parent == kNone ? nullptr : in.uneven(nodes_[node.parent].solver_index);
  LinkNumbers<N>& n = link_of<N>(&numbers_[node.first]);
  const double* inertia = body_of(&numbers_[node.first]).inertia;
  // Jacobians now
  for (int i = 0; i < N; ++i) {
    const Row& row = rows.rows[link.row[i]];
    jacobian(row, node.body_is_a, own, n.own[i]);
    jacobian(row, !node.body_is_a, up, n.up[i]);
  }
  // Y = own A^-1 own^T + g
  unrolled<N>([&](auto i) __attribute__((always_inline)) {
    double* y = n.stiffness + packed(i, 0);
    const double alone = static_cast<double>(rows.compliance[link.row[i]]);
    if (node.leaf) {
      for (int j = 0; j < i; ++j) y[j] = 0;
      y[i] = kClosingCompliance * alone + 1e-30;
      return;
    }
    for (int k = 0; k < 6; ++k) n.weight[i][k] = n.own[i][k];
    solve_factors<6>(inertia, n.weight[i]);
    unrolled<i + 1>([&](auto j) __attribute__((always_inline)) { y[j] = dot6(n.weight[i], n.own[j]); });
    y[i] += kCompliance * alone + 1e-30;
  });
  factorize<N>(n.stiffness);
  if (node.parent == kNone) return;
  // A_parent += up^T Y^-1 up
  double* a = body_of(&numbers_[nodes_[node.parent].first]).inertia;
  unrolled<6>([&](auto k) __attribute__((always_inline)) {
    double column[N];
    unrolled<N>([&](auto i) __attribute__((always_inline)) { column[i] = n.up[i][k]; });
    solve_factors<N>(n.stiffness, column);
    unrolled<N>([&](auto i) __attribute__((always_inline)) { n.across[i][k] = column[i]; });
    unrolled<k + 1>([&](auto m) __attribute__((always_inline)) {
      double sum = a[packed(k, m)];
      unrolled<N>([&](auto i) __attribute__((always_inline)) { sum += column[i] * n.up[i][m]; });
      a[packed(k, m)] = sum;
    });
  });
}

void JointTrees::factor(const TreeRows& rows, const SolverInput& in, std::span<const Mat3> inv_inertia, bool fresh) {
  FEDER_ASSERT(inv_inertia.size() == in.solver_bodies->state.size());
  FEDER_ASSERT(masses_.size() == nodes_.size() * kTriangle);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    if (node.leaf) continue;
    double* mass = &masses_[i * kTriangle];
    if (fresh)
      mass_matrix(in.solver_bodies->mass[node.solver_index], in.uneven(node.solver_index),
                  inv_inertia[node.solver_index], mass);
    std::memcpy(body_of(&numbers_[node.first]).inertia, mass, kTriangle * sizeof(double));
  }
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    const Node& node = nodes_[i];
    if (!node.leaf) factorize<6>(body_of(&numbers_[node.first]).inertia);
    with_rows(node.rows, [&](auto n) { factor_link<n>(node, rows, in); });
  }
}

// Leaves to root: the right-hand side of a link, less the response of its child.
template <int N>
void JointTrees::gather_link(const Node& node, std::span<const Row> rows, const SolverBodies* solver_bodies,
                             std::span<const Real> bias) {
  const Link& link = links_[node.link];
  LinkNumbers<N>& n = link_of<N>(&numbers_[node.first]);
  const double* load = body_of(&numbers_[node.first]).load;
  Vec3 v = Vec3::Zero(), wa = Vec3::Zero(), wb = Vec3::Zero();
  if (solver_bodies) {
    const SolverBody &a = solver_bodies->state[link.state_a], &b = solver_bodies->state[link.state_b];
    v = b.velocity - a.velocity, wa = a.angular_velocity, wb = b.angular_velocity;
  }
  double wanted[N];
  unrolled<N>([&](auto i) __attribute__((always_inline)) {
    const Row& row = rows[link.row[i]];
    const Real speed = dot(row.linear, v) + dot(row.angular_b, wb) + dot(row.angular_a, wa);
    wanted[i] = -static_cast<double>(speed + bias[link.row[i]]);
    if (!node.leaf) wanted[i] -= dot6(n.weight[i], load);
  });
  solve_factors<N>(n.stiffness, wanted);
  unrolled<N>([&](auto i) __attribute__((always_inline)) { n.wanted[i] = wanted[i]; });
  if (node.parent == kNone) return;
  double* to = body_of(&numbers_[nodes_[node.parent].first]).load;
  unrolled<6>([&](auto k) __attribute__((always_inline)) {
    double sum = to[k];
    unrolled<N>([&](auto i) __attribute__((always_inline)) { sum += n.up[i][k] * wanted[i]; });
    to[k] = sum;
  });
}

// Root to leaves: impulses of a link, given the parent's velocity change; what they do to its body.
template <int N>
void JointTrees::push_link(const Node& node, std::span<Real> step) {
  const LinkNumbers<N>& n = link_of<N>(&numbers_[node.first]);
  const double* above = node.parent == kNone ? nullptr : body_of(&numbers_[nodes_[node.parent].first]).response;
  double* response = body_of(&numbers_[node.first]).response;
  double p[N];
  unrolled<N>([&](auto i) __attribute__((always_inline)) {
    p[i] = above ? n.wanted[i] - dot6(n.across[i], above) : n.wanted[i];
    step[links_[node.link].row[i]] = static_cast<Real>(p[i]);
  });
  unrolled<6>([&](auto k) __attribute__((always_inline)) {
    double sum = response[k];
    unrolled<N>([&](auto i) __attribute__((always_inline)) { sum += n.own[i][k] * p[i]; });
    response[k] = sum;
  });
}

void JointTrees::solve(std::span<const Row> rows, const SolverBodies* solver_bodies, std::span<const Real> bias,
                       std::span<Real> step) {
  FEDER_ASSERT(bias.size() == rows.size() && step.size() == rows.size());
  const auto count = static_cast<std::uint32_t>(nodes_.size());
  for (const Node& node : nodes_)
    for (double& x : body_of(&numbers_[node.first]).load) x = 0;
  gather(0, count, rows, solver_bodies, bias);
  push(0, count, step);
}

void JointTrees::gather(std::uint32_t first, std::uint32_t last, std::span<const Row> rows,
                        const SolverBodies* solver_bodies, std::span<const Real> bias) {
  for (std::uint32_t i = last; i-- > first;)
    with_rows(nodes_[i].rows, [&](auto n) { gather_link<n>(nodes_[i], rows, solver_bodies, bias); });
}

void JointTrees::push(std::uint32_t first, std::uint32_t last, std::span<Real> step) {
  for (std::uint32_t i = first; i < last; ++i) {
    const Node& node = nodes_[i];
    BodyNumbers& body = body_of(&numbers_[node.first]);
    for (int k = 0; k < 6; ++k) body.response[k] = body.load[k];
    with_rows(node.rows, [&](auto n) { push_link<n>(node, step); });
    if (!node.leaf) solve_factors<6>(body.inertia, body.response);
  }
}

void JointTrees::respond(const RowBlock& block, std::span<const Row> rows, const SolverInput& in,
                         std::span<const Real> no_bias, std::span<Real> step) {
  FEDER_ASSERT(joins(block.index_a, block.index_b) && block.count == 1);
  const std::uint32_t first = tree_of(block.index_a, block.index_b);
  std::uint32_t last = first;
  for (; last < nodes_.size() && nodes_[last].tree == first; ++last)
    for (double& x : body_of(&numbers_[nodes_[last].first]).load) x = 0;
  for (const bool side_a : {true, false}) {
    const std::uint32_t index = side_a ? block.index_a : block.index_b, at = node_of(index);
    if (at != kNone) jacobian(rows[block.first], side_a, in.uneven(index), body_of(&numbers_[nodes_[at].first]).load);
  }
  gather(first, last, rows, nullptr, no_bias);
  push(first, last, step);
}

double JointTrees::response(const RowBlock& block, std::span<const Row> rows, const SolverInput& in) const {
  double change = 0;
  for (const bool side_a : {true, false}) {
    const std::uint32_t index = side_a ? block.index_a : block.index_b, at = node_of(index);
    if (at == kNone) continue;
    double along[6];
    jacobian(rows[block.first], side_a, in.uneven(index), along);
    change += dot6(along, body_of(&numbers_[nodes_[at].first]).response);
  }
  return change;
}

void JointTrees::move_bodies(SolverBodies& solver_bodies) const {
  for (const Node& node : nodes_) {
    if (node.leaf) continue;
    const double* dv = body_of(&numbers_[node.first]).response;
    SolverBody& s = solver_bodies.state[node.solver_index];
    for (int k = 0; k < 3; ++k) {
      s.velocity[k] += static_cast<Real>(dv[k]);
      s.angular_velocity[k] += static_cast<Real>(dv[k + 3]);
    }
  }
}

}  // namespace feder
