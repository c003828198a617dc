// The solve of a damped velocity kick.
// Linearly implicit, as in Baraff & Witkin 1998 but by the velocity alone. Kept between calls: work arrays. Weak spot:
// stiff dashpots in long chains take many iterations, and a cap ends them as unconverged.
#include "integrate/damped_kick.h"

namespace feder {
namespace {
// M - share h D is close to diagonal unless the dashpots are very strong, so a few iterations reach this.
constexpr CgOptions kDampingSolve = {sizeof(Real) == 4 ? 1e-6 : 1e-12, 200};
}  // namespace

void DampedKick::apply(ForceField& field, double t, Real h, std::span<const Vec3> x, std::span<Vec3> v,
                       IntegratorStats& stats) {
  force_.resize(x.size());
  field.eval(x, v, t, force_);
  ++stats.force_evals;
  const std::span<const Real> inv_mass = field.inv_mass();
  for_points(field, x.size(), [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t i = first; i < last; ++i) v[i] += (h * inv_mass[i]) * force_[i];
  });
}

void DampedKick::apply_second_order(ForceField& field, double t, Real h, Real share, std::span<const Vec3> x,
                                    std::span<Vec3> v, IntegratorStats& stats) {
  if (!field.damped())
    apply(field, t, h, x, v, stats);
  else if (field.stiff_damping(2 * share * h))  // the whole step: the velocity is taken half of one later
    apply_implicit(field, t, h, share, x, v, stats);
  else
    apply_corrected(field, t, h, share, x, v, stats);
}

void DampedKick::apply_corrected(ForceField& field, double t, Real h, Real share, std::span<const Vec3> x,
                                 std::span<Vec3> v, IntegratorStats& stats) {
  start_.assign(v.begin(), v.end());
  apply(field, t, share * h, x, v, stats);
  field.eval(x, v, t, force_);
  ++stats.force_evals;
  const std::span<const Real> inv_mass = field.inv_mass();
  for (std::size_t i = 0; i < x.size(); ++i) v[i] = start_[i] + (h * inv_mass[i]) * force_[i];
}

void DampedKick::apply_implicit(ForceField& field, double t, Real h, Real share, std::span<const Vec3> x,
                                std::span<Vec3> v, IntegratorStats& stats) {
  const std::size_t n = x.size();
  force_.resize(n);
  field.eval(x, v, t, force_);
  ++stats.force_evals;
  pattern_.update(field, n, {&d_});
  dv_.resize(n);
  field.damping(x, v, t, d_);
  ++stats.jacobian_evals;

  // A = M - share h D, b = h f
  const std::span<const Real> mass = field.mass();
  const double scale = -static_cast<double>(share) * static_cast<double>(h);
  for (Mat3d& m : d_.off) m *= scale;
  for (std::size_t i = 0; i < n; ++i) {
    d_.diagonal[i] *= scale;
    d_.diagonal[i].diagonal().array() += static_cast<double>(mass[i]);
    force_[i] *= h;
  }
  const CgResult r = cg_.solve(d_, field.inv_mass(), force_, kDampingSolve, dv_);
  ++stats.linear_solves;
  stats.cg_iterations += static_cast<std::uint64_t>(r.iterations);
  stats.residual = r.residual;
  if (!r.converged) ++stats.unconverged;
  for (std::size_t i = 0; i < n; ++i) v[i] += dv_[i];
}

}  // namespace feder
