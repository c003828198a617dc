// Forces of a net. A spring between a and b, with n = (x_b - x_a)/len, pulls with
//   tension = stiffness (len - rest_length) + damping (v_b - v_a).n
// equal and opposite (springs/spring_kernel.h); one that only pulls has none below its rest length and never pushes.
// Derivatives for implicit methods: K = -k [n n^T + max(0, 1 - rest/len)(1 - n n^T)], the indefinite part of a
// compressed spring dropped (Choi & Ko 2002), D = -c n n^T; generators by what they tell, or by differences. Still air
// presses on faces as on cloth (forces/area.h); implicit methods take its force without a derivative.
// Kept between calls: work arrays.
#include "springs/net.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "forces/area.h"

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

constexpr std::uint32_t kFewPoints = 8;  // below, one by one is faster than wide

// All exponents below the largest? In integers, so that compilers vectorise it.
bool all_finite(std::span<const Vec3> a) {
  using Bits = std::conditional_t<sizeof(Real) == 4, std::uint32_t, std::uint64_t>;
  const Bits mask = std::bit_cast<Bits>(kInfinity);
  const Real* p = a.data()->data();
  Bits bad = 0;
  for (std::size_t k = 0; k < a.size() * 3; ++k) bad |= (std::bit_cast<Bits>(p[k]) & mask) == mask;
  return bad == 0;
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
  FEDER_ASSERT(s.i != s.j && rest >= 0 && s.stiffness >= 0);
  i.push_back(s.i), j.push_back(s.j);
  stiffness.push_back(s.stiffness), damping.push_back(s.damping);
  rest_length.push_back(rest), break_strain.push_back(s.break_strain);
  const Real longest = rest * (1 + s.break_strain);
  limit.push_back(s.break_strain < kInfinity ? longest * longest : kInfinity);
  alive.push_back(1), tension_only.push_back(s.tension_only), power.push_back(static_cast<std::uint8_t>(s.power));
}

void SpringArrays::remove(std::uint32_t k) {
  FEDER_ASSERT(k < size() && alive[k]);
  alive[k] = 0;
  stiffness[k] = damping[k] = 0;
  break_strain[k] = limit[k] = kInfinity;
}

void Net::remove_spring(std::uint32_t k) {
  if (!springs.alive[k]) return;
  springs.remove(k);
  if (laid_out_ == version) layout.remove(k);
}

void Net::prepare(const Vec3& gravity, Real air_density, const Forces* forces, TagMask tags) {
  if (laid_out_ != version) {
    layout.build(springs, points);
    laid_out_ = version;
  }
  gravity_ = gravity * settings.gravity_scale;
  acting_.clear();
  damped_ = settings.damping > 0;
  generators_damp_ = on_stepping_thread = false;
  air_density_ = faces.empty() ? Real(0) : air_density;
  drag_share_ = kInfinity;
  // explicit methods hold a drag for a substep or a part of it; the others take its derivative or cut the substep
  const IntegratorInfo info = integrator->info();
  if (forces && !info.implicit && !info.adaptive) drag_share_ = forces->drag_share();
  if (forces)
    for (const ForceEntry& f : forces->list)
      if (acts_on(f, object, tags)) {
        FEDER_ASSERT(f.points.empty() || f.points.back() < points);
        acting_.push_back(&f);
        generators_damp_ = generators_damp_ || f.force->depends_on_velocity();
        on_stepping_thread = on_stepping_thread || f.force->on_stepping_thread();
        if (f.force->on_area()) air_density_ = 0;  // wind: the air is not still
      }
  damped_ = damped_ || air_density_ > 0 || generators_damp_ || layout.damped();
}

void Net::integrate(double t, Real h, JobPool* jobs) {
  if (frozen) return;
  FEDER_ASSERT(h > 0 && laid_out_ == version && layout.spring_count() == springs.size());
  FEDER_ASSERT(!jobs_);  // one call at a time
  jobs_ = jobs;
  step_ = h;
  const std::span<Vec3> x(particles_.position.data() + first, points), v(particles_.velocity.data() + first, points);
  integrator->step(*this, t, h, x, v);
  jobs_ = nullptr;
}

std::uint32_t Net::find_non_finite(JobPool* jobs, bool places_only) const {
  if (points >= kFewPoints && all_points_finite(jobs, places_only)) return kNone;
  const std::span<const Vec3> x = positions(), v = velocities();
  for (std::uint32_t i = 0; i < points; ++i)
    if (!is_finite(x[i]) || !(places_only || is_finite(v[i]))) return i;
  return kNone;
}

bool Net::all_points_finite(JobPool* jobs, bool places_only) const {
  const std::span<const Vec3> x = positions(), v = velocities();
  const auto good = [&](std::uint32_t from, std::uint32_t to) {
    return all_finite(x.subspan(from, to - from)) && (places_only || all_finite(v.subspan(from, to - from)));
  };
  if (!jobs) return good(0, points);
  std::atomic<bool> bad{false};
  jobs->for_blocks(points, {1024, 2'000}, [&](std::uint32_t from, std::uint32_t to, int) {
    if (!good(from, to)) bad.store(true, std::memory_order_relaxed);
  });
  return !bad.load(std::memory_order_relaxed);
}

void Net::eval(std::span<const Vec3> x, std::span<const Vec3> v, double t, std::span<Vec3> force) {
  FEDER_ASSERT(x.size() == points && v.size() == points && force.size() == points);
  const Real* mass = particles_.mass.data() + first;
  const Vec3* script = particles_.script_force.data() + first;
  const auto outside = [&](std::uint32_t i) {
    return Vec3(mass[i] * (gravity_ - settings.damping * v[i]) + script[i]);
  };
  coincident += layout.eval(x, v, jobs_, outside, force) / 2;
  if (air_density_ > 0) add_still_air(x, v, force);
  if (acting_.empty()) return;
  fill_points(x, v);
  for (const ForceEntry* f : acting_) add_generator(*f, t, force.data());
}

std::size_t Net::pick_points(const ForceEntry& f) {
  some_.clear();
  for (const std::uint32_t i : f.points) some_.push_back(points_[i]);
  return some_.size();
}

void Net::add_generator(const ForceEntry& f, double t, Vec3* out) {
  if (f.points.empty()) return f.force->add(points_.data(), points, t, out);
  const std::size_t count = pick_points(f);
  some_force_.assign(count, Vec3(0, 0, 0));
  f.force->add(some_.data(), count, t, some_force_.data());
  for (std::size_t k = 0; k < count; ++k) out[f.points[k]] += some_force_[k];
}

// As on cloth.
void Net::add_still_air(std::span<const Vec3> x, std::span<const Vec3> v, std::span<Vec3> force) const {
  for (std::size_t t = 0; t < faces.size(); t += 3) {
    const std::uint32_t *f = &faces[t], a = f[0], b = f[1], c = f[2];
    const Vec3 twice = cross(x[b] - x[a], x[c] - x[a]), u = (v[a] + v[b] + v[c]) / 3;
    const Real* mass = particles_.mass.data() + first;
    const Real most = kMaxMassShare * std::min({mass[a], mass[b], mass[c]}) / step_;
    const Vec3 third = still_air(u, twice, air_density_, most, {}) / 3;
    for (int k = 0; k < 3; ++k) force[f[k]] += third;
  }
}

void Net::fill_points(std::span<const Vec3> x, std::span<const Vec3> v) {
  points_.resize(points);
  for (std::uint32_t i = 0; i < points; ++i) {
    const Real r = particles_.radius[first + i];
    const Real mass = particles_.mass[first + i];
    points_[i] = {x[i], v[i], mass, kPi * r * r, kPi * r * r * r * Real(4) / 3, drag_share_ * mass / step_};
  }
}

bool Net::limp(std::uint32_t k, double len, double rate) const {
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
    if (limp(k, at.len, rate(v, i, j, at.n))) continue;
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
    if (limp(s, at.len, rate(v, i, j, at.n))) continue;
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

// What the generator tells of its derivative. False: nothing.
bool Net::add_known_derivative(const ForceEntry& f, double t, bool by_velocity) {
  if (f.points.empty()) return f.force->derivative(points_.data(), points, t, by_velocity, derivative_.data());
  const std::size_t count = pick_points(f);
  some_derivative_.assign(count, Mat3::Zero());
  if (!f.force->derivative(some_.data(), count, t, by_velocity, some_derivative_.data())) return false;
  for (std::size_t k = 0; k < count; ++k) derivative_[f.points[k]] += some_derivative_[k];
  return true;
}

// Of the generators that do not tell theirs, by central differences: each of them sees each point alone.
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
  // row sums of M^-1 K: what a point's springs add to its own row, and to the columns of free neighbours
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
  if (with_generators && !acting_.empty()) {
    fill_points(positions(), velocities());
    for (const bool by_velocity : {false, true}) {
      derivative_.assign(points, Mat3::Zero());
      for (const ForceEntry* f : acting_) add_known_derivative(*f, time, by_velocity);
      for (std::uint32_t i = 0; i < points; ++i)
        (by_velocity ? damp : stiff)[i] += static_cast<double>(derivative_[i].cwiseAbs().rowwise().sum().maxCoeff());
    }
  }
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

Real Net::length_of(std::uint32_t k) const {
  FEDER_ASSERT(k < springs.size() && first + points <= particles_.size());
  return length(particles_.position[first + springs.j[k]] - particles_.position[first + springs.i[k]]);
}

Real Net::strain(std::uint32_t k) const {
  const Real rest = springs.rest_length[k];
  return springs.alive[k] && rest > 0 ? (length_of(k) - rest) / rest : Real(0);
}

Energy Net::energy() {
  Energy e;
  const std::span<const Vec3> x = positions(), v = velocities();
  for (std::uint32_t i = 0; i < points; ++i) {
    const double m = particles_.mass[first + i];
    e.kinetic += 0.5 * m * static_cast<double>(dot(v[i], v[i]));
    e.potential -= m * static_cast<double>(dot(gravity_, x[i]));
  }
  for (std::uint32_t k = 0; k < springs.size(); ++k) {
    const double stretch = static_cast<double>(length_of(k)) - static_cast<double>(springs.rest_length[k]);
    if (springs.tension_only[k] && stretch < 0) continue;
    e.elastic += springs.tension(k, stretch) * stretch / (springs.power[k] + 1);
  }
  if (acting_.empty()) return e;
  fill_points(x, v);
  for (const ForceEntry* f : acting_)
    e.potential += f->points.empty() ? f->force->potential(points_.data(), points)
                                     : f->force->potential(some_.data(), pick_points(*f));
  return e;
}

}  // namespace feder
