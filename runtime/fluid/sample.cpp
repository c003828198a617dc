// A fluid between its particles: quantities at a point, what flows through a box, how many pairs lie too close.
//  - Density: the sum of the kernel over the particles near, over the share of the kernel that walls leave free
//    (boundary_table.h: `share`; the solvers' own wall term is a force law for whole layers, 1.6 times too high at the
//    wall itself). Walls that meet share a corner as the product of what each leaves free.
//  - Velocity and pressure: means over the particles near, weighted by the kernel (Shepard 1968), each particle with
//    its volume at rest: those at a surface lack neighbours, not density.
//  - Their gradients: the gradient of that mean, normalised by the matrix that makes it exact for linear fields
//    (Randles & Libersky 1996; Bonet & Lok 1999). Where too few particles lie near, it stays as it is.
// Kept between calls: nothing. Weak spot: Shepard's mean lies half a layer off the value at a free surface or a wall.
#include <algorithm>
#include <cmath>

#include "fluid/impl.h"

namespace feder {
namespace {

// Of the spread of evenly laid neighbours; below it they nearly lie in a plane or on a line.
constexpr double kDegenerate = 1e-3;

double three(const Vec3& a, int k) { return static_cast<double>(a[k]); }

// The kernel around a point of the fluid.
class Smoothing {
 public:
  Smoothing(const FluidPool& p, const Boundary& boundary, const Vec3& at) : p_(p), at_(at) {
    const double h = static_cast<double>(p.support), whole = p.dimension == 2 ? h * h : h * h * h;
    value_ = static_cast<double>(p.unit) / whole, slope_ = value_ / (h * h);
    for (const BoundaryShape& w : boundary.shapes) {
      Vec3 n;
      const Real d = w.shape->distance(to_local(w.pose, at), p.support, n);
      if (!p.meets(w) || !(d < p.support)) continue;
      const BoundaryTerms terms = p.table->at(d / p.support);
      const Real left = 1 - terms.share;
      free_ *= static_cast<double>(std::max(left, Real(kLeastFree)));
      if (left > Real(kLeastFree)) free_slope_ += terms.colour / (p.support * left) * rotate(w.pose.rotation, n);
    }
  }
  // Weight of particle i: its share of the density at rest.
  double weight(std::uint32_t i) const { return value_ * p_.kernel->density.value(p_.dimension, u(i)); }
  // Its gradient by the point, 1/m.
  Vec3d slope(std::uint32_t i) const {
    const Vec3 apart = at_ - p_.x[i].vec();
    const double s = slope_ * p_.kernel->density.slope(p_.dimension, u(i));
    return Vec3d(s * three(apart, 0), s * three(apart, 1), s * three(apart, 2));
  }
  bool holds(std::uint32_t i) const { return u(i) < 1; }
  // Share of the kernel that walls leave free, and its gradient over itself, 1/m.
  double free() const { return std::max(free_, static_cast<double>(kLeastFree)); }
  Vec3d free_slope() const {
    if (free_ <= static_cast<double>(kLeastFree)) return Vec3d::Zero();
    return Vec3d(three(free_slope_, 0), three(free_slope_, 1), three(free_slope_, 2));
  }

 private:
  static constexpr float kLeastFree = 0.1f;  // below it nothing is known: the point lies inside a solid
  double u(std::uint32_t i) const {
    return static_cast<double>(length(Vec3(p_.x[i].vec() - at_))) / static_cast<double>(p_.support);
  }
  const FluidPool& p_;
  Vec3 at_;
  double value_ = 0, slope_ = 0, free_ = 1;
  Vec3 free_slope_ = Vec3::Zero();
};

// Indices of the particles within a distance of a point.
std::vector<std::uint32_t> particles_near(const FluidPool& p, const Vec3& at, Real distance) {
  std::vector<std::uint32_t> near;
  for (std::uint32_t i = 0; i < p.count; ++i) {
    const Vec3 apart = p.x[i].vec() - at;
    if (dot(apart, apart) < distance * distance) near.push_back(i);
  }
  return near;
}

// The gradient of Shepard's mean, times the sum of its weights, becomes exact for linear fields. `spread`: the sum of
// slope times offset of each particle from the mean position.
class Normalization {
 public:
  Normalization(const Mat3d& spread, double weights, int dimension) : weights_(weights) {
    Mat3d m = spread;
    if (dimension == 2) m.row(2).setZero(), m.col(2).setZero(), m(2, 2) = weights;
    const Vec3d a = m.row(0), b = m.row(1), c = m.row(2), bc = across(b, c);
    const double det = a.dot(bc);
    exact_ = std::abs(det) > kDegenerate * weights * weights * weights;
    if (exact_) inverse_.col(0) = bc / det, inverse_.col(1) = across(c, a) / det, inverse_.col(2) = across(a, b) / det;
  }
  Vec3d operator()(const Vec3d& sum) const {
    const Vec3d plain = sum / weights_;
    if (!exact_) return plain;
    return inverse_ * sum;
  }

 private:
  static Vec3d across(const Vec3d& a, const Vec3d& b) {
    return Vec3d(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
  }
  double weights_;
  bool exact_ = false;
  Mat3d inverse_ = Mat3d::Zero();
};

Vec3 rounded(const Vec3d& a) { return vec3(static_cast<Real>(a[0]), static_cast<Real>(a[1]), static_cast<Real>(a[2])); }

// Length of the interval of one spacing around x that lies in [lo, hi], in spacings.
double overlap(double x, double spacing, double lo, double hi) {
  return std::max(0.0, std::min(x + spacing / 2, hi) - std::max(x - spacing / 2, lo)) / spacing;
}

}  // namespace

// Densities of these particles, over that at rest, where they are now: as refresh() finds those of all.
void Fluid::Impl::refresh_near(FluidPool& p, const Vec3& at, const std::vector<std::uint32_t>& wanted) {
  if (p.images || meets_others(p)) return refresh(p);  // the boundary's terms are those of all of them
  const std::vector<std::uint32_t> around = particles_near(p, at, 2 * p.support);
  for (const std::uint32_t i : wanted) {
    const Vec3 x = p.x[i].vec();
    double sum = 0;
    for (const std::uint32_t j : around) {
      const double u = static_cast<double>(length(Vec3(p.x[j].vec() - x))) / static_cast<double>(p.support);
      if (j != i && u < 1) sum += p.kernel->density.value(p.dimension, u);
    }
    const double norm = p.kernel->norm_density[p.dimension - 2];
    Real ratio = static_cast<Real>(static_cast<double>(p.value_factor) / norm * sum) + p.own_value + p.screen[i];
    for (const BoundaryShape& w : boundary.shapes) {
      Vec3 n;
      const Real d = w.shape->distance(to_local(w.pose, x), p.support, n);
      if (p.meets(w) && d < p.support) ratio += p.table->at(d / p.support).value;
    }
    p.ratio[i] = ratio;
  }
}

double Fluid::pressure_at(ObjectId id, const Vec3& point) { return static_cast<double>(sample(id, point).pressure); }

FluidSample Fluid::sample(ObjectId id, const Vec3& point) {
  FluidPool& p = impl_->pool(id);
  FluidSample out;
  if (!is_finite(point)) throw SceneError("fluid: sample: expected a finite point");
  Vec3 at = point;
  if (p.dimension == 2) at[2] = 0;
  const Smoothing kernel(p, impl_->boundary, at);
  std::vector<std::uint32_t> near = particles_near(p, at, p.support);
  std::erase_if(near, [&](std::uint32_t i) { return !kernel.holds(i) || !(kernel.weight(i) > 0); });
  if (near.empty()) return out;
  const Impl::KeptRatios kept(p);
  impl_->refresh_near(p, at, near);
  const FluidSolver& solver = impl_->solver_of(p);
  // means
  double weights = 0, pressure = 0;
  Vec3d slopes = Vec3d::Zero(), velocity = Vec3d::Zero(), middle = Vec3d::Zero();
  for (const std::uint32_t i : near) {
    const double w = kernel.weight(i);
    weights += w, pressure += w * static_cast<double>(solver.pressure(p, i));
    slopes += kernel.slope(i);
    for (int k = 0; k < 3; ++k) {
      velocity[k] += w * three(p.v[i].vec(), k);
      middle[k] += w * (three(p.x[i].vec(), k) - three(at, k));
    }
  }
  pressure /= weights, velocity /= weights, middle /= weights;
  // gradients of the means, from differences to them
  Mat3d spread = Mat3d::Zero(), of_velocity = Mat3d::Zero();
  Vec3d of_pressure = Vec3d::Zero();
  for (const std::uint32_t i : near) {
    const Vec3d g = kernel.slope(i);
    of_pressure += (static_cast<double>(solver.pressure(p, i)) - pressure) * g;
    for (int k = 0; k < 3; ++k) {
      of_velocity.row(k) += ((three(p.v[i].vec(), k) - velocity[k]) * g).transpose();
      spread.col(k) += (three(p.x[i].vec(), k) - three(at, k) - middle[k]) * g;
    }
  }
  const Normalization normalized(spread, weights, p.dimension);
  const double density = static_cast<double>(p.desc.density) / kernel.free();
  out.density = static_cast<Real>(density * weights);
  out.density_gradient = rounded(density * (slopes - weights * kernel.free_slope()));
  out.velocity = rounded(velocity), out.pressure = static_cast<Real>(pressure);
  out.pressure_gradient = rounded(normalized(of_pressure));
  for (int k = 0; k < 3; ++k) {
    const Vec3d row = of_velocity.row(k).transpose();
    out.velocity_gradient.row(k) = rounded(normalized(row)).transpose();
  }
  return out;
}

FluidFlux Fluid::flux(ObjectId id, const Vec3& lo, const Vec3& hi) const {
  const FluidPool& p = impl_->pool(id);
  const double d = p.desc.spacing;
  for (int k = 0; k < p.dimension; ++k)
    if (!(hi[k] > lo[k]) || !is_finite(lo[k]) || !is_finite(hi[k]))
      throw SceneError("fluid: flux: expected a finite second corner above the first");
  FluidFlux out;
  // a particle is a cube of its spacing: sums do not jump where a layer of them enters the box
  for (const std::uint32_t i : impl_->by_id(p)) {
    double share = p.mass;
    for (int k = 0; k < p.dimension && share > 0; ++k)
      share *= overlap(three(p.x[i].vec(), k), d, three(lo, k), three(hi, k));
    if (!(share > 0)) continue;
    out.mass += share;
    for (int k = 0; k < 3; ++k) out.momentum[k] += share * three(p.v[i].vec(), k);
  }
  for (int k = 0; k < p.dimension; ++k) out.rate[k] = out.momentum[k] / (three(hi, k) - three(lo, k));
  return out;
}

// By cells, not by the lists of the solvers: those are longer than this needs, and made for all particles.
Fluid::Impl::PairCount Fluid::Impl::pairs_of(FluidPool& p, std::uint32_t most) {
  PairCount n;
  if (p.count == 0) return n;
  p.grid.sort({&p.x[0].x, 4 * std::size_t(p.count)}, p.support, one_thread, p.order);
  const Real close2 = p.desc.spacing * p.desc.spacing / 4, near2 = p.support * p.support;
  const std::uint32_t stride = (p.count - 1) / most + 1;
  for (std::uint32_t i = 0; i < p.count; i += stride) {
    const Vec3 x = p.x[i].vec();
    int from[3], to[3];
    for (int k = 0; k < 3; ++k) {
      const int cell = p.grid.coordinate(k, x[k]);
      from[k] = std::max(cell - 1, 0), to[k] = std::min(cell + 1, p.grid.cells(k) - 1);
    }
    for (int z = from[2]; z <= to[2]; ++z)
      for (int y = from[1]; y <= to[1]; ++y)
        for (std::uint32_t at = p.grid.first(from[0], y, z); at < p.grid.last(to[0], y, z); ++at) {
          const std::uint32_t j = p.order[at];
          const Vec3 apart = x - p.x[j].vec();
          const Real square = dot(apart, apart);
          if (j == i || !(square < near2)) continue;
          ++n.all, n.close += square < close2;
        }
  }
  return n;
}

double Fluid::clumping(ObjectId id) { return impl_->pairs_of(impl_->pool(id), kNone).share(); }

}  // namespace feder
