// Forces of a net. A spring between a and b, with n = (x_b - x_a)/len, pulls with
//   tension = stiffness (len - rest_length) + damping (v_b - v_a).n
// equal and opposite (springs/spring_kernel.h); one with tension_only has none below its rest length and never pushes.
// Still air presses on faces as on cloth (forces/area.h); implicit methods take its force without a derivative. The
// derivatives are in derivatives.cpp. Kept between calls: work arrays.
#include "springs/net.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "forces/area.h"

namespace feder {
namespace {

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

}  // namespace

void SpringArrays::add(const SpringDesc& s, Real rest) {
  FEDER_ASSERT(s.i != s.j && rest >= 0 && s.stiffness >= 0);
  const Real longest = rest * (1 + s.break_strain);
  i.push_back(s.i);
  j.push_back(s.j);
  stiffness.push_back(s.stiffness);
  damping.push_back(s.damping);
  rest_length.push_back(rest);
  break_strain.push_back(s.break_strain);
  limit.push_back(s.break_strain < kInfinity ? longest * longest : kInfinity);
  alive.push_back(1);
  tension_only.push_back(s.tension_only);
  power.push_back(static_cast<std::uint8_t>(s.power));
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

// Drag of still air on the faces, as on cloth.
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
