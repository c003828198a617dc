// Derivatives of a net's forces, for implicit methods and for bounds of its frequencies. A spring:
//   K = -k [n n^T + max(0, 1 - rest/len)(1 - n n^T)],  D = -c n n^T,
// the indefinite part of a compressed spring dropped (Choi & Ko 2002). Generators: their known derivative, else central
// differences of each point alone; of both the negative semidefinite part. Kept between calls: work arrays.
// Weak spot: differences cost six evaluations of a generator.
#include <algorithm>
#include <cmath>

#include "springs/net.h"

namespace feder {
namespace {

// n n^T c
inline Mat3d along(const Vec3d& n, double c) {
  const Vec3d cn = c * n;
  Mat3d m;
  for (int col = 0; col < 3; ++col) m.col(col) = cn * n[col];
  return m;
}

// In double, for derivatives: n n^T k stays semidefinite beside small masses.
struct Direction {
  Vec3d n;
  double len;
};

// The kernels' rule: a spring without length points along x, from the lower point number to the higher.
inline Direction direction(std::span<const Vec3> x, std::uint32_t i, std::uint32_t j) {
  const Vec3d d = x[j].cast<double>() - x[i].cast<double>();
  const double square = d.dot(d);
  if (square <= static_cast<double>(kNoLength2)) return {Vec3d(i < j ? 1 : -1, 0, 0), 0};
  const double len = std::sqrt(square);
  return {d / len, len};
}

inline double rate(std::span<const Vec3> v, std::uint32_t i, std::uint32_t j, const Vec3d& n) {
  return (v[j] - v[i]).cast<double>().dot(n);
}

// The symmetric, negative semidefinite part of m.
Mat3d negative_part(const Mat3& m) {
  const Mat3 symmetric = Real(0.5) * (m + m.transpose());
  Vec3 values;
  Mat3 vectors;
  eigen_symmetric(symmetric, values, vectors);
  Mat3d out = Mat3d::Zero();
  for (int k = 0; k < 3; ++k)
    if (values[k] < 0) out += along(vectors.col(k).cast<double>(), values[k]);
  return out;
}

}  // namespace

bool Net::is_slack(std::uint32_t k, double len, double rate) const {
  const double stretch = len - static_cast<double>(springs.rest_length[k]);
  return springs.tension_only[k] &&
         (stretch <= 0 || springs.tension(k, stretch) + static_cast<double>(springs.damping[k]) * rate < 0);
}

void Net::pattern(std::vector<BlockIndex>& blocks) const {
  for (std::uint32_t k = 0; k < springs.size(); ++k) {
    const std::uint32_t i = springs.i[k], j = springs.j[k];
    blocks.push_back(i < j ? BlockIndex{i, j} : BlockIndex{j, i});
  }
}

void Net::damping(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& d) {
  FEDER_ASSERT(d.diagonal.size() == points && d.off.size() == springs.size());
  d.set_zero();
  for (std::uint32_t i = 0; i < points; ++i)
    d.diagonal[i].diagonal().setConstant(-static_cast<double>(settings.damping * particles_.mass[first + i]));
  for (std::uint32_t k = 0; k < springs.size(); ++k) {
    if (springs.damping[k] == 0) continue;
    const std::uint32_t i = springs.i[k], j = springs.j[k];
    const Direction at = direction(x, i, j);
    if (is_slack(k, at.len, rate(v, i, j, at.n))) continue;
    const Mat3d block = along(at.n, springs.damping[k]);
    d.diagonal[i] -= block;
    d.diagonal[j] -= block;
    d.off[k] = block;
  }
  add_force_derivative(x, v, t, true, d);
}

void Net::jacobian(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& k, BlockSparse& d) {
  damping(x, v, t, d);
  FEDER_ASSERT(k.off.size() == d.off.size());
  k.set_zero();
  for (std::uint32_t s = 0; s < springs.size(); ++s) {
    const std::uint32_t i = springs.i[s], j = springs.j[s];
    const Direction at = direction(x, i, j);
    if (is_slack(s, at.len, rate(v, i, j, at.n))) continue;
    const double rest = springs.rest_length[s], stretch = at.len - rest, stiff = springs.slope(s, stretch);
    const double across = rest == 0       ? stiff / springs.power[s]
                          : at.len > rest ? springs.tension(s, stretch) / at.len
                                          : 0;
    Mat3d block = along(at.n, stiff - across);
    block.diagonal().array() += across;
    k.diagonal[i] -= block;
    k.diagonal[j] -= block;
    k.off[s] = block;
  }
  add_force_derivative(x, v, t, false, k);
}

void Net::add_force_derivative(std::span<const Vec3> x, std::span<const Vec3> v, double t, bool by_velocity,
                               BlockSparse& out) {
  bool any = false, unknown = false;
  for (const ForceEntry* f : acting_) any = any || !by_velocity || f->force->depends_on_velocity();
  if (!any) return;
  fill_points(x, v);
  FEDER_ASSERT(out.diagonal.size() == points);
  derivative_.assign(points, Mat3::Zero());
  for (const ForceEntry* f : acting_)
    if ((!by_velocity || f->force->depends_on_velocity()) && !add_known_derivative(*f, t, by_velocity)) unknown = true;
  if (unknown) add_differences(x, v, t, by_velocity);
  for (std::uint32_t i = 0; i < points; ++i) out.diagonal[i] += negative_part(derivative_[i]);
}

// Adds a generator's derivative where it is known, else returns false.
bool Net::add_known_derivative(const ForceEntry& f, double t, bool by_velocity) {
  if (f.points.empty()) return f.force->derivative(points_.data(), points, t, by_velocity, derivative_.data());
  const std::size_t count = pick_points(f);
  some_derivative_.assign(count, Mat3::Zero());
  if (!f.force->derivative(some_.data(), count, t, by_velocity, some_derivative_.data())) return false;
  for (std::size_t k = 0; k < count; ++k) derivative_[f.points[k]] += some_derivative_[k];
  return true;
}

// Central differences of the generators without a known derivative, of each point alone.
void Net::add_differences(std::span<const Vec3> x, std::span<const Vec3> v, double t, bool by_velocity) {
  const auto shift = [&](std::uint32_t i) { return (1 + (by_velocity ? v[i] : x[i]).cwiseAbs().maxCoeff()) / 1024; };
  const auto forces = [&](int axis, Real side, Array<Vec3>& f) {
    for (std::uint32_t i = 0; i < points; ++i) {
      points_[i].position = x[i], points_[i].velocity = v[i];
      (by_velocity ? points_[i].velocity : points_[i].position)[axis] += side * shift(i);
    }
    f.assign(points, Vec3(0, 0, 0));
    for (const ForceEntry* g : acting_)
      if (!g->force->derivative(nullptr, 0, t, by_velocity, nullptr)) add_generator(*g, t, f.data());
  };
  for (int axis = 0; axis < 3; ++axis) {
    forces(axis, -1, below_);
    forces(axis, 1, above_);
    for (std::uint32_t i = 0; i < points; ++i) derivative_[i].col(axis) += (above_[i] - below_[i]) / (2 * shift(i));
  }
}

void Net::bounds(double& most_frequency, double& most_decay, bool with_generators, double time) {
  // springs: row sums of M^-1 K, of a point's own block and of the blocks of free neighbours
  row_stiffness_.assign(points, 0);
  row_damping_.assign(points, 0);
  Array<double>&stiff = row_stiffness_, &damp = row_damping_;
  for (std::uint32_t k = 0; k < springs.size(); ++k) {
    const std::uint32_t ends[2] = {springs.i[k], springs.j[k]};
    const double slope =
        springs.power[k] == 1
            ? static_cast<double>(springs.stiffness[k])
            : springs.slope(k, static_cast<double>(length_of(k)) - static_cast<double>(springs.rest_length[k]));
    for (int e = 0; e < 2; ++e) {
      const double rows = particles_.inv_mass[first + ends[1 - e]] != 0 ? 2 : 1;
      stiff[ends[e]] += rows * slope;
      damp[ends[e]] += rows * static_cast<double>(springs.damping[k]);
    }
  }
  // generators with a known derivative: its row sums
  if (with_generators && !acting_.empty()) {
    fill_points(positions(), velocities());
    for (const bool by_velocity : {false, true}) {
      derivative_.assign(points, Mat3::Zero());
      for (const ForceEntry* f : acting_) add_known_derivative(*f, time, by_velocity);
      for (std::uint32_t i = 0; i < points; ++i)
        (by_velocity ? damp : stiff)[i] += static_cast<double>(derivative_[i].cwiseAbs().rowwise().sum().maxCoeff());
    }
  }
  // the largest over free points
  double w2 = 0, rate = 0;
  for (std::uint32_t i = 0; i < points; ++i) {
    const double inv = particles_.inv_mass[first + i];
    if (inv == 0) continue;
    w2 = std::max(w2, stiff[i] * inv);
    rate = std::max(rate, damp[i] * inv + static_cast<double>(settings.damping));
  }
  most_frequency = std::sqrt(w2);
  most_decay = rate;
}

}  // namespace feder
