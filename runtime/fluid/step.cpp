// Passes of the fluid system beside those of its solvers, and the world's queries: energy, momentum, residuals.
#include <algorithm>
#include <cmath>

#include "fluid/block_sums.h"
#include "fluid/impl.h"

namespace feder {

// Non-penetration projection at the poses of the bodies after the rigid solve.
void Fluid::Impl::project(StepContext& c) {
  for (auto& p : pools)
    if (p->active()) p->project_out(boundary, *c.jobs);
}

template <class F>
std::uint32_t Fluid::Impl::take_out(FluidPool& p, const StepContext& c, F&& gone) {
  struct Count {
    std::uint32_t value = 0;
    void add(const Count& n) { value += n.value; }
  };
  marked.resize(p.count);
  const Count all = sum_blocks<Count>(p.count, kParticleGrain, *c.jobs, *c.scratch, [&](std::uint32_t i, Count& n) {
    marked[i] = gone(p.x[i].vec());
    n.value += marked[i];
  });
  const std::uint32_t taken = all.value;
  if (taken == 0) return 0;
  p.remove_marked(marked);
  FEDER_ASSERT(p.count + taken == marked.size());
  p.contact_first[p.count] = 0;
  return taken;
}

void Fluid::Impl::kill(StepContext& c) {
  for (auto& p : pools) {
    const Real height = p->desc.kill_height;
    if (height > -kInfinity) take_out(*p, c, [&](const Vec3& x) { return x[1] < height; });
  }
}

void Fluid::Impl::drain(StepContext& c) {
  for (FluidDrain& d : drains) {
    if (d.stopped) continue;
    FluidPool& p = pool(d.fluid);
    FEDER_ASSERT(d.shape < shapes.size() && shapes[d.shape]);
    const Shape& shape = *shapes[d.shape];
    const std::uint32_t taken = take_out(p, c, [&](const Vec3& x) {
      Vec3 n;
      return shape.distance(to_local(d.pose, x), p.desc.spacing, n) < 0;
    });
    if (taken == 0) continue;
    d.taken += taken;
    c.events->add({.kind = kDrained, .a = d.object, .b = d.fluid, .index = taken});
  }
}

// Quarantine: particles that went non-finite are removed before anything else reads them.
void Fluid::Impl::check(StepContext& c) {
  std::string message;
  ObjectId object;
  for (auto& pool : pools) {
    FluidPool& p = *pool;
    const auto good = [&p](std::uint32_t i) {
      return is_finite(p.x[i].vec()) && is_finite(p.v[i].vec()) && is_finite(p.lambda[i]);
    };
    struct Sums : RestSums {
      std::uint32_t bad = 0;
      void add(const Sums& s) {
        square += s.square, most = std::max(most, s.most), bad += s.bad;
        for (int k = 0; k < 3; ++k) place[k] += s.place[k];
      }
    };
    const Sums sums = sum_blocks<Sums>(p.count, kParticleGrain, *c.jobs, *c.scratch, [&](std::uint32_t i, Sums& s) {
      const double v2 = static_cast<double>(dot(p.v[i].vec(), p.v[i].vec()));
      s.square += v2, s.most = std::max(s.most, v2), s.bad += !good(i);
      s.place[0] += static_cast<double>(p.x[i].x), s.place[1] += static_cast<double>(p.x[i].y);
      s.place[2] += static_cast<double>(p.x[i].z);
    });
    if (sums.bad == 0) {
      watch(p, sums.square, c);
      update_sleep(p, sums, c);
      continue;
    }
    suspect(p);
    marked.assign(p.count, 0);
    std::uint32_t bad = 0, first = 0;
    for (std::uint32_t i = 0; i < p.count; ++i) {
      if (good(i)) continue;
      if (bad++ == 0) first = p.id[i];
      marked[i] = 1;
    }
    p.remove_marked(marked);
    FEDER_ASSERT(p.count + bad == marked.size());
    p.kinetic = p.kinetic_energy();
    lost += bad;
    message += (message.empty() ? "" : "; ") + objects.describe(p.object) + ": " + std::to_string(bad) +
               " particles went non-finite and were taken out, the first was number " + std::to_string(first + 1);
    if (!object) object = p.object;
  }
  if (!message.empty()) c.events->warn("non_finite", message, object);
}

Energy Fluid::energy(const Vec3& gravity) const {
  Energy sum;
  for (const auto& p : impl_->pools) {
    const double m = p->mass, g = p->desc.gravity_scale;
    sum.potential += impl_->potential(*p);
    for (std::uint32_t i = 0; i < p->count; ++i) {
      const Vec3 v = p->v[i].vec(), x = p->x[i].vec();
      double vv = 0, gx = 0;
      for (int k = 0; k < 3; ++k) {
        vv += static_cast<double>(v[k]) * static_cast<double>(v[k]);
        gx += static_cast<double>(gravity[k]) * static_cast<double>(x[k]);
      }
      sum.kinetic += 0.5 * m * vv;
      sum.potential -= m * g * gx;
    }
  }
  return sum;
}

Momentum Fluid::momentum() const {
  Momentum sum;
  for (const auto& p : impl_->pools) {
    const double m = p->mass;
    // in the order of making, so that sorting does not change the sum
    for (const std::uint32_t i : impl_->by_id(*p)) {
      const double x[3] = {p->x[i].x, p->x[i].y, p->x[i].z};
      const double v[3] = {m * p->v[i].x, m * p->v[i].y, m * p->v[i].z};
      for (int k = 0; k < 3; ++k) {
        sum.linear[k] += v[k];
        sum.angular[k] += x[(k + 1) % 3] * v[(k + 2) % 3] - x[(k + 2) % 3] * v[(k + 1) % 3];
      }
    }
  }
  return sum;
}

void Fluid::residuals(std::vector<Residual>& out) const {
  double excess = 0, sum = 0;
  std::size_t n = 0;
  for (const auto& p : impl_->pools)
    for (std::uint32_t i = 0; i < p->count; ++i) {
      const double e = std::max(0.0, static_cast<double>(p->ratio[i]) - 1);
      excess = std::max(excess, e);
      sum += e;
      ++n;
    }
  out.push_back({"fluid.density_error_max", excess});
  out.push_back({"fluid.density_error_mean", n ? sum / static_cast<double>(n) : 0});
  Impl::PairCount pairs;
  for (const auto& p : impl_->pools) {
    const Impl::PairCount own = impl_->pairs_of(*p);
    pairs.close += own.close, pairs.all += own.all;
  }
  out.push_back({"fluid.clumping", pairs.share()});
  out.push_back({"fluid.lost_particles", static_cast<double>(impl_->lost)});
}

bool Fluid::finite() const {
  if (impl_->lost > 0) return false;
  for (const auto& p : impl_->pools)
    for (std::uint32_t i = 0; i < p->count; ++i)
      if (!is_finite(p->x[i].vec()) || !is_finite(p->v[i].vec())) return false;
  return true;
}

}  // namespace feder
