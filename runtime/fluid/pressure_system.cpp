#include "fluid/pressure_system.h"

#include <algorithm>
#include <cmath>

namespace feder {
namespace {

constexpr double kFirstStep = 0.4;  // over the diagonal: below 2 over the largest eigenvalue, 3.9 to 4.6 in columns at
                                    // rest

// Of displacements: what they may leave of an error, over the diagonal and per multiplier. Densities hardly feel some
// displacements, of neighbours against each other; to correct by those takes so long ones that the densities after them
// are worse than before. Without it columns of 40 layers in 3D boil.
constexpr Real kSoftness = Real(0.3);

}  // namespace

void PressureSystem::Sums::add(const Sums& s) {
  descent += s.descent, curvature += s.curvature, conjugate += s.conjugate, error += s.error,
      room = std::min(room, s.room);
}

template <class F>
void PressureSystem::each(JobPool& jobs, F&& f) {
  for (FluidPool* p : pools_)
    jobs.for_blocks(p->count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) f(*p, i);
    });
}

template <class F>
PressureSystem::Sums PressureSystem::sum_of(FluidPool& p, JobPool& jobs, F&& f) {
  const std::uint32_t blocks = (p.count + kParticleGrain.items - 1) / kParticleGrain.items;
  sums_.assign(blocks, Sums{});
  jobs.for_blocks(p.count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    Sums s;
    for (std::uint32_t i = first; i < last; ++i) f(p, i, s);
    sums_[first / kParticleGrain.items] = s;
  });
  Sums all;
  for (const Sums& s : sums_) all.add(s);
  return all;
}

template <class F>
PressureSystem::Sums PressureSystem::sum(JobPool& jobs, F&& f) {
  Sums all;
  for (FluidPool* p : pools_) all.add(sum_of(*p, jobs, f));
  return all;
}

PressureSystem::Excess PressureSystem::excess(FluidPool& p, Real bound, JobPool& jobs) {
  const Sums s = sum_of(p, jobs, [&](FluidPool& q, std::uint32_t i, Sums& t) {
    t.error += std::max(0.0, static_cast<double>(q.ratio[i]) - 1);
    t.room = std::min(t.room, 1 + static_cast<double>(bound - q.ratio[i]));
  });
  return {p.count > 0 ? s.error / p.count : 0.0, s.room < 0};
}

void PressureSystem::prepare(JobPool& jobs) {
  for (FluidPool* pool : pools_) {
    FluidPool& p = *pool;
    p.images->build(p, *boundary_, jobs);
    const SweepInput in = p.sweep_input();
    const Real inv_mass = 1 / p.mass, rs = p.support * p.support * p.slope_factor * p.slope_factor;
    const bool mixture = p.is_mixture();
    if (p.uneven()) {
      p.find_skew(jobs);
      jobs.for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
        p.sweeps->values_by(in, first, last, p.sum.data());
      });
    }
    if (mixture) weigh_by_lightness(p, jobs);
    jobs.for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      p.sweeps->slopes(in, first, last, &p.move[0].x, p.squares.data());
      if (mixture) p.sweeps->squares_by(in, first, last, p.squares.data());
      p.even_slopes(first, last);
      for (std::uint32_t i = first; i < last; ++i) {
        const Vec3 open = p.slope_factor * p.move[i].vec() + p.images->gradient(i);
        Real shared = 0;
        for (std::uint32_t at = p.contact_first[i]; at < p.contact_first[i + 1]; ++at) {
          const BoundaryBody& b = boundary_->body_of(p.contacts[at]);
          if (!b.dynamic) continue;
          const Real slope = length(p.images->push(at).linear);
          shared += slope * std::max(b.contact_weight, slope) * b.response(p.x[i].vec(), p.contacts[at].normal);
        }
        // of a mixture: by the masses of both sides; those of images are taken for its own
        const Real own = open.squaredNorm() + p.images->squares(i);
        p.diagonal[i] = (mixture ? std::max(p.least_squares, own) / p.mass_of(i) + rs * p.squares[i]
                                 : inv_mass * std::max(p.least_squares, own + rs * p.squares[i])) +
                        shared;
        const Real crowd = p.value_factor * (p.uneven() ? p.sum[i] : p.move[i].w) + p.share_of(i) * p.own_value;
        p.ratio[i] = crowd + p.screen[i] + p.images->value(i);
        p.air[i] = p.table->air(length(open) * p.support);
      }
    });
  }
}

// Puts 1/mass into the weights of the positions, times what they count squared, until the next ones.
void PressureSystem::weigh_by_lightness(FluidPool& p, JobPool& jobs) {
  p.weigh(jobs, [&p](std::uint32_t i) { return p.share_of(i) * p.share_of(i) / p.mass_of(i); });
}

// What the motion of the boundary adds to the growth of the ratio of particle i.
Real PressureSystem::wall_growth(const FluidPool& p, std::uint32_t i, bool of_moved) const {
  Real sum = 0;
  for (std::uint32_t at = p.contact_first[i]; at < p.contact_first[i + 1]; ++at) {
    const std::uint32_t n = boundary_->shapes[p.contacts[at].shape].body;
    const BoundaryBody& b = boundary_->bodies[n];
    const BoundaryImages::Push& push = p.images->push(at);
    if (!of_moved)
      sum -= dot(push.linear, b.velocity) + dot(push.angular, b.angular_velocity);
    else if (b.dynamic)
      sum -= dot(push.linear, moved_[n].velocity) + dot(push.angular, moved_[n].angular_velocity);
  }
  return sum;
}

void PressureSystem::press(JobPool& jobs) {
  each(jobs, [](FluidPool& p, std::uint32_t i) { p.x[i].w = p.next_weight[i]; });
  if (bodies_) moved_.assign(boundary_->bodies.size(), Motion{});
  for (FluidPool* pool : pools_) {
    FluidPool& p = *pool;
    const SweepInput in = p.sweep_input();
    const Real inv_mass = 1 / p.mass;
    const bool mixture = p.is_mixture();
    jobs.for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      p.sweeps->push(in, first, last, &p.move[0].x);
      p.even_push(first, last);
      p.sweeps->image_push(in, p.images->input(), first, last, &p.move[0].x);
      for (std::uint32_t i = first; i < last; ++i) {
        const Real lightness = mixture ? 1 / p.mass_of(i) : inv_mass;
        p.move[i].set(-lightness * p.slope_factor * p.move[i].vec());
      }
    });
    p.move[p.count] = {};
    if (!bodies_) continue;
    for (const std::uint32_t at : p.dynamic_contacts) {
      const std::uint32_t n = boundary_->shapes[p.contacts[at].shape].body;
      const BoundaryBody& b = boundary_->bodies[n];
      const BoundaryImages::Push& push = p.images->push(at);
      const Real weight = p.x[p.contacts[at].particle].w;
      moved_[n].velocity += weight * b.inv_mass.cwiseProduct(push.linear);
      moved_[n].angular_velocity += weight * (b.inv_inertia * push.angular);
    }
  }
}

// Between solves no weights are left in the positions.
void PressureSystem::clear_weights(JobPool& jobs) {
  each(jobs, [](FluidPool& p, std::uint32_t i) { p.x[i].w = 0; });
}

void PressureSystem::grow(JobPool& jobs, bool of_moved) {
  for (FluidPool* pool : pools_) {
    FluidPool& p = *pool;
    const Array<Row4>& u = of_moved ? p.move : state(p);
    SweepInput in = p.sweep_input(), shared = in;
    in.velocity = shared.velocity = &u[0].x;
    if (p.uneven()) {
      p.share_out(u, p.swap4, jobs);
      shared.velocity = &p.swap4[0].x;
    }
    const bool moving = bodies_ && (of_moved ? !p.dynamic_contacts.empty() : boundary_moves_);
    jobs.for_blocks(p.count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      p.sweeps->growth(shared, first, last, p.sum.data());
      if (p.uneven())
        for (std::uint32_t i = first; i < last; ++i) p.sum[i] += dot(u[i].vec(), p.skew[i].vec());
      p.sweeps->image_growth(in, p.images->input(), first, last, p.sum.data());
      for (std::uint32_t i = first; i < last; ++i) {
        const Real sum = p.slope_factor * p.sum[i] + (moving ? wall_growth(p, i, of_moved) : Real(0));
        const Real held = of_moved ? p.x[i].w : multipliers(p)[i];
        p.sum[i] = sum - (bodies_ ? p.compliance : kSoftness * p.diagonal[i]) * held;
      }
    });
  }
}

// Along the direction in `next_weight`, whose effect is in `move` and moved_; residuals are not touched.
void PressureSystem::step(Real size, JobPool& jobs) {
  each(jobs, [&](FluidPool& p, std::uint32_t i) {
    Row4& u = state(p)[i];
    u.set(u.vec() + size * p.move[i].vec());
  });
  if (!bodies_) return;
  for (std::size_t n = 0; n < moved_.size(); ++n) {
    BoundaryBody& b = boundary_->bodies[n];
    if (!b.dynamic) continue;
    b.velocity += size * moved_[n].velocity;
    b.angular_velocity += size * moved_[n].angular_velocity;
  }
}

void PressureSystem::find_residuals(JobPool& jobs) {
  grow(jobs, false);
  each(jobs, [](FluidPool& p, std::uint32_t i) { p.residual[i] = p.sum[i] - p.allowed[i]; });
}

PressureSystem::Result PressureSystem::solve(double tolerance, int most, JobPool& jobs) {
  Result result;
  double count = 0, length = kFirstStep;
  for (const FluidPool* p : pools_) count += p->count;
  // under pressure, or about to be
  const auto least = [this](const FluidPool& p, std::uint32_t i) {
    return bodies_ && !p.least.empty() ? p.least[i] : Real(0);
  };
  const auto active = [&](FluidPool& p, std::uint32_t i) {
    return multipliers(p)[i] > least(p, i) || p.residual[i] > 0;
  };
  const auto restart = [&] {
    each(jobs, [&](FluidPool& p, std::uint32_t i) {
      p.next_weight[i] = active(p, i) ? p.residual[i] / p.diagonal[i] : Real(0);
    });
  };
  find_residuals(jobs);
  restart();
  for (bool fresh = true;;) {
    const Sums now = sum(jobs, [&](FluidPool& p, std::uint32_t i, Sums& s) {
      if (active(p, i)) s.error += std::fabs(static_cast<double>(p.residual[i]));
    });
    result.error = now.error / count;
    if (result.error <= tolerance || result.iterations >= most) break;
    // the step that would be taken, up to the bounds
    each(jobs, [&](FluidPool& p, std::uint32_t i) {
      p.next_weight[i] = std::max(least(p, i) - multipliers(p)[i], static_cast<Real>(length) * p.next_weight[i]);
    });
    press(jobs), grow(jobs, true);
    ++result.iterations;
    const Sums s = sum(jobs, [&](FluidPool& p, std::uint32_t i, Sums& t) {
      const double w = static_cast<double>(p.next_weight[i]);
      t.descent += w * static_cast<double>(p.residual[i]);
      t.curvature -= w * static_cast<double>(p.sum[i]);
      if (w < 0) t.room = std::min(t.room, static_cast<double>(multipliers(p)[i] - least(p, i)) / -w);
    });
    if (!(s.descent > 0) || !(s.curvature > 0)) {
      if (fresh) break;
      restart();
      fresh = true, length = kFirstStep;
      continue;
    }
    const double full = s.descent / s.curvature;
    const Real size = static_cast<Real>(std::min(full, s.room));
    step(size, jobs);
    const Sums t = sum(jobs, [&](FluidPool& p, std::uint32_t i, Sums& g) {
      Real& l = multipliers(p)[i];
      l = std::max(least(p, i), l + size * p.next_weight[i]);
      p.residual[i] += size * p.sum[i];
      if (active(p, i))
        g.conjugate -= static_cast<double>(p.residual[i] / p.diagonal[i]) * static_cast<double>(p.sum[i]);
    });
    const Real carry = static_cast<Real>(t.conjugate / s.curvature);
    each(jobs, [&](FluidPool& p, std::uint32_t i) {
      p.next_weight[i] = active(p, i) ? p.residual[i] / p.diagonal[i] - carry * p.next_weight[i] : Real(0);
    });
    length *= full;
    fresh = false;
  }
  return result;
}

void PressureSystem::start_velocities(JobPool& jobs) {
  bodies_ = true;
  each(jobs, [](FluidPool& p, std::uint32_t i) { p.next_weight[i] = p.lambda[i]; });
  press(jobs);
  before_.clear(), started_.clear();
  for (const BoundaryBody& b : boundary_->bodies) before_.push_back({b.velocity, b.angular_velocity});
  step(1, jobs);
  for (const BoundaryBody& b : boundary_->bodies) started_.push_back({b.velocity, b.angular_velocity});
}

PressureSystem::Result PressureSystem::solve_velocities(double tolerance, int most, JobPool& jobs) {
  bodies_ = true;
  FEDER_ASSERT(before_.size() == boundary_->bodies.size());  // start_velocities() has pushed
  boundary_moves_ = false;
  for (std::size_t n = 0; n < before_.size(); ++n) {
    const BoundaryBody& b = boundary_->bodies[n];
    before_[n].velocity += b.velocity - started_[n].velocity;
    before_[n].angular_velocity += b.angular_velocity - started_[n].angular_velocity;
    boundary_moves_ = boundary_moves_ || b.dynamic || !b.velocity.isZero(0) || !b.angular_velocity.isZero(0);
  }
  const Result r = solve(tolerance, most, jobs);
  // each body's impulse in one, from the multipliers
  for (std::size_t n = 0; n < before_.size(); ++n) {
    BoundaryBody& b = boundary_->bodies[n];
    b.velocity = before_[n].velocity, b.angular_velocity = before_[n].angular_velocity;
  }
  for (FluidPool* pool : pools_) {
    FluidPool& p = *pool;
    for (std::uint32_t at = 0; at < p.contact_first[p.count]; ++at) {
      BoundaryContact& k = p.contacts[at];
      const BoundaryImages::Push& push = p.images->push(at);
      const Real l = p.lambda[k.particle];
      k.impulse = -l * dot(push.linear, k.normal);
      BoundaryBody& b = boundary_->body_of(k);
      if (b.dynamic) b.push_by(l * push.linear, l * push.angular);
    }
  }
  clear_weights(jobs);
  return r;
}

PressureSystem::Result PressureSystem::solve_displacements(double tolerance, int most, JobPool& jobs) {
  bodies_ = false;
  for (FluidPool* p : pools_) {
    std::fill(p->extra.begin(), p->extra.begin() + p->count + 1, Row4{});
    std::fill(p->shifts.begin(), p->shifts.begin() + p->count, Real(0));
  }
  const Result r = solve(tolerance, most, jobs);
  clear_weights(jobs);
  return r;
}

}  // namespace feder
