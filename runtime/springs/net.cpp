// Forces of a net. A spring between a and b, with n = (x_b - x_a)/len, pulls with
//   tension = stiffness (len - rest_length) + damping (v_b - v_a).n
// equal and opposite, so momentum is exact to rounding. Springs run in index order: the sums, and so the bits, never
// depend on threads (nets run in parallel, the springs of a net do not).
// Derivatives for implicit methods: K = -k [n n^T + max(0, 1 - rest/len)(1 - n n^T)], the indefinite part of a
// compressed spring dropped (Choi & Ko 2002), D = -c n n^T; generators by differences.
// Kept between calls: work arrays. Weak spot: one thread per net.
#include "springs/net.h"

#include <cmath>

namespace feder {
namespace {

// Direction of a spring of no length.
const Vec3 kNoDirection = Vec3(1, 0, 0);

struct Direction {
  Vec3 n;
  Real len;
};

inline Direction direction(const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  return {normalized_or(d, kNoDirection), length(d)};
}

// n n^T c
inline Mat3d along(const Vec3d& n, double c) {
  const Vec3d cn = c * n;
  Mat3d m;
  for (int col = 0; col < 3; ++col) m.col(col) = cn * n[col];
  return m;
}

// The same in double, for derivatives: n n^T k stays semidefinite beside small masses.
struct DirectionD {
  Vec3d n;
  double len;
};

inline DirectionD direction_d(const Vec3& a, const Vec3& b) {
  const Vec3d d = b.cast<double>() - a.cast<double>();
  const double len = std::sqrt(d.dot(d));
  return {len > 0 ? Vec3d(d / len) : Vec3d(1, 0, 0), len};
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

void SpringArrays::add(const SpringDesc& s, Real rest) {
  i.push_back(s.i), j.push_back(s.j);
  stiffness.push_back(s.stiffness), damping.push_back(s.damping);
  rest_length.push_back(rest), break_strain.push_back(s.break_strain);
  alive.push_back(1);
}

void SpringArrays::remove(std::uint32_t k) {
  alive[k] = 0;
  stiffness[k] = damping[k] = 0;
  break_strain[k] = kInfinity;
}

void Net::prepare(const Vec3& gravity, const Forces* forces, TagMask tags) {
  gravity_ = gravity * settings.gravity_scale;
  acting_.clear();
  damped_ = settings.damping > 0;
  generators_damp_ = false;
  if (forces)
    for (const ForceEntry& f : forces->list)
      if (acts_on(f, object, tags)) {
        acting_.push_back(f.force.get());
        generators_damp_ = generators_damp_ || f.force->depends_on_velocity();
      }
  damped_ = damped_ || generators_damp_;
  for (std::uint32_t k = 0; k < springs.size() && !damped_; ++k) damped_ = springs.damping[k] > 0;
}

void Net::integrate(double t, Real h) {
  if (frozen) return;
  const std::span<Vec3> x(particles_.position.data() + first, points), v(particles_.velocity.data() + first, points);
  integrator->step(*this, t, h, x, v);
}

std::uint32_t Net::find_non_finite() const {
  for (std::uint32_t i = 0; i < points; ++i)
    if (!is_finite(particles_.position[first + i]) || !is_finite(particles_.velocity[first + i])) return i;
  return kNone;
}

void Net::eval(std::span<const Vec3> x, std::span<const Vec3> v, double t, std::span<Vec3> force) {
  const Real* mass = particles_.mass.data() + first;
  const Vec3* script = particles_.script_force.data() + first;
  for (std::uint32_t i = 0; i < points; ++i) force[i] = mass[i] * (gravity_ - settings.damping * v[i]) + script[i];

  const SpringArrays& s = springs;
  for (std::uint32_t k = 0; k < s.size(); ++k) {
    const std::uint32_t i = s.i[k], j = s.j[k];
    const Direction d = direction(x[i], x[j]);
    const Vec3 u = v[j] - v[i];
    const Vec3 f = d.n * (s.stiffness[k] * (d.len - s.rest_length[k]) + s.damping[k] * dot(u, d.n));
    force[i] += f;
    force[j] -= f;
  }

  if (acting_.empty()) return;
  fill_points(x, v);
  for (const Force* f : acting_) f->add(points_.data(), points, t, force.data());
}

void Net::fill_points(std::span<const Vec3> x, std::span<const Vec3> v) {
  points_.resize(points);
  for (std::uint32_t i = 0; i < points; ++i) {
    const Real r = particles_.radius[first + i];
    points_[i] = {x[i], v[i], particles_.mass[first + i], kPi * r * r, kPi * r * r * r * Real(4) / 3};
  }
}

void Net::pattern(std::vector<BlockIndex>& blocks) const {
  for (std::uint32_t k = 0; k < springs.size(); ++k) {
    const std::uint32_t i = springs.i[k], j = springs.j[k];
    blocks.push_back(i < j ? BlockIndex{i, j} : BlockIndex{j, i});
  }
}

void Net::damping(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& d) {
  d.set_zero();
  for (std::uint32_t i = 0; i < points; ++i)
    d.diagonal[i].diagonal().setConstant(-static_cast<double>(settings.damping * particles_.mass[first + i]));
  for (std::uint32_t k = 0; k < springs.size(); ++k) {
    if (springs.damping[k] == 0) continue;
    const std::uint32_t i = springs.i[k], j = springs.j[k];
    const Mat3d block = along(direction_d(x[i], x[j]).n, springs.damping[k]);
    d.diagonal[i] -= block;
    d.diagonal[j] -= block;
    d.off[k] = block;
  }
  add_force_derivative(x, v, t, true, d);
}

void Net::jacobian(std::span<const Vec3> x, std::span<const Vec3> v, double t, BlockSparse& k, BlockSparse& d) {
  damping(x, v, t, d);
  k.set_zero();
  for (std::uint32_t s = 0; s < springs.size(); ++s) {
    const std::uint32_t i = springs.i[s], j = springs.j[s];
    const DirectionD at = direction_d(x[i], x[j]);
    const double rest = springs.rest_length[s], stiff = springs.stiffness[s];
    const double across = at.len > rest ? stiff * (1 - rest / at.len) : 0;
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
  bool any = false;
  for (const Force* f : acting_) any = any || !by_velocity || f->depends_on_velocity();
  if (!any) return;
  fill_points(x, v);
  const auto shift = [&](std::uint32_t i) { return (1 + (by_velocity ? v[i] : x[i]).cwiseAbs().maxCoeff()) / 1024; };
  // forces with all points moved by side * shift along the axis: a generator sees each point alone
  const auto forces = [&](int axis, Real side, Array<Vec3>& f) {
    for (std::uint32_t i = 0; i < points; ++i) {
      points_[i].position = x[i], points_[i].velocity = v[i];
      (by_velocity ? points_[i].velocity : points_[i].position)[axis] += side * shift(i);
    }
    f.assign(points, Vec3(0, 0, 0));
    for (const Force* g : acting_) g->add(points_.data(), points, t, f.data());
  };
  derivative_.resize(points);
  for (int axis = 0; axis < 3; ++axis) {
    forces(axis, -1, below_);
    forces(axis, 1, above_);
    for (std::uint32_t i = 0; i < points; ++i)
      derivative_[i].col(axis) = (above_[i] - below_[i]) / (2 * shift(i));
  }
  for (std::uint32_t i = 0; i < points; ++i) out.diagonal[i] += negative_part(derivative_[i]);
}

void Net::bounds(double& frequency, double& decay) const {
  // row sums of M^-1 K: what a point's springs add to its own row, and to the columns of free neighbours
  std::vector<double> stiff(points, 0), damp(points, 0);
  for (std::uint32_t k = 0; k < springs.size(); ++k) {
    const std::uint32_t ends[2] = {springs.i[k], springs.j[k]};
    for (int e = 0; e < 2; ++e) {
      const double rows = particles_.inv_mass[first + ends[1 - e]] != 0 ? 2 : 1;
      stiff[ends[e]] += rows * static_cast<double>(springs.stiffness[k]);
      damp[ends[e]] += rows * static_cast<double>(springs.damping[k]);
    }
  }
  double w2 = 0, rate = 0;
  for (std::uint32_t i = 0; i < points; ++i) {
    const double inv = particles_.inv_mass[first + i];
    if (inv == 0) continue;
    w2 = std::max(w2, stiff[i] * inv);
    rate = std::max(rate, damp[i] * inv + static_cast<double>(settings.damping));
  }
  frequency = std::sqrt(w2);
  decay = rate;
}

Real Net::length_of(std::uint32_t k) const {
  return length(particles_.position[first + springs.j[k]] - particles_.position[first + springs.i[k]]);
}

Real Net::strain(std::uint32_t k) const {
  const Real rest = springs.rest_length[k];
  return springs.alive[k] && rest > 0 ? (length_of(k) - rest) / rest : Real(0);
}

Energy Net::energy() {
  Energy e;
  const std::span<const Vec3> x(particles_.position.data() + first, points);
  const std::span<const Vec3> v(particles_.velocity.data() + first, points);
  for (std::uint32_t i = 0; i < points; ++i) {
    const double m = particles_.mass[first + i];
    e.kinetic += 0.5 * m * static_cast<double>(dot(v[i], v[i]));
    e.potential -= m * static_cast<double>(dot(gravity_, x[i]));
  }
  for (std::uint32_t k = 0; k < springs.size(); ++k) {
    const double stretch = static_cast<double>(length_of(k)) - static_cast<double>(springs.rest_length[k]);
    e.elastic += 0.5 * static_cast<double>(springs.stiffness[k]) * stretch * stretch;
  }
  if (acting_.empty()) return e;
  fill_points(x, v);
  for (const Force* f : acting_) e.potential += f->potential(points_.data(), points);
  return e;
}

}  // namespace feder
