// Frequencies at rest, and damping of strain rate at velocities: M v' = -tau K v over a time with the stiffness K, so
// that a mode of frequency w decays at tau w^2/2 (Kelvin-Voigt). Modes of a fine mesh spread over decades, so it acts
// by stages of an explicit Runge-Kutta-Chebyshev method (integrate/damping_stages.h): all tetrahedra push at once in
// each, so that momentum and angular momentum are kept. The stages reach to the response of the stiffest tetrahedron
// alone, which bounds that of any deformed body where no tetrahedron's own exceeds it (kernel.h, damp_begin): beyond
// their range stages grow without bound. Weak spot: kMostStages bounds the time; longer ones act as that.
#include <algorithm>
#include <cmath>

#include "base/jobs.h"
#include "base/rng.h"
#include "integrate/damping_stages.h"
#include "soft/batches.h"
#include "soft/stability.h"

namespace feder {
namespace {
constexpr int kMostStages = 256;
constexpr std::uint32_t kPointGrain = 1024;  // points per job
}  // namespace

SoftMaterial soft_material(double young, double poisson) {
  SoftMaterial m;
  m.mu = young / (2 * (1 + poisson));
  m.lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  m.shear = m.mu * 4 / 3, m.lambda = m.lame + m.mu * 5 / 6;
  m.gamma = 1 + m.mu / m.lambda;
  return m;
}

double gradient_bound(const Corners& g) {
  // in units of the largest gradient, so that float does
  double scale = 0;
  for (const Double3& v : g) scale = std::fmax(scale, dot(v, v));
  Mat3 sum = Mat3::Zero();
  for (const Double3& v : g) {
    const Vec3 n = narrow((1 / std::sqrt(scale)) * v);
    sum += n * n.transpose();
  }
  Vec3 values;
  Mat3 vectors;
  eigen_symmetric(sum, values, vectors);
  return scale * double(values[2]);
}

double fastest_mode(const SoftMesh& mesh, std::uint32_t points, const SoftMaterial& material, double density,
                    std::span<const double> scale, int iterations) {
  std::vector<Double3> u(points), force(points);
  std::vector<double> mass(points, 0);
  for (std::size_t k = 0; k < mesh.tetrahedra.size(); ++k)
    for (const std::uint32_t i : mesh.tetrahedra[k]) mass[i] += density * double(mesh.volume[k]) / 4;
  std::vector<Corners> gradients(mesh.tetrahedra.size());
  for (std::size_t k = 0; k < gradients.size(); ++k) gradients[k] = barycentric_gradients(mesh.rest_corners(k));
  Rng rng(1);
  for (Double3& d : u) d = {double(rng.uniform(-1, 1)), double(rng.uniform(-1, 1)), double(rng.uniform(-1, 1))};
  double fastest = 0;
  for (int n = 0; n < iterations; ++n) {
    std::fill(force.begin(), force.end(), Double3{0, 0, 0});
    for (std::size_t k = 0; k < mesh.tetrahedra.size(); ++k) {
      const TetrahedronPoints& t = mesh.tetrahedra[k];
      const Corners& g = gradients[k];
      Double3 h[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};  // columns of the displacement gradient
      for (std::size_t c = 0; c < 4; ++c) {
        h[0] = h[0] + g[c].x * u[t[c]], h[1] = h[1] + g[c].y * u[t[c]], h[2] = h[2] + g[c].z * u[t[c]];
      }
      const double v = double(mesh.volume[k]) * scale[k], all = material.lame * (h[0].x + h[1].y + h[2].z);
      const double xx = 2 * material.mu * h[0].x + all, yy = 2 * material.mu * h[1].y + all,
                   zz = 2 * material.mu * h[2].z + all, xy = material.mu * (h[0].y + h[1].x),
                   yz = material.mu * (h[1].z + h[2].y), zx = material.mu * (h[2].x + h[0].z);
      for (std::size_t c = 0; c < 4; ++c) {
        const Double3& a = g[c];
        force[t[c]] = force[t[c]] + v * Double3{xx * a.x + xy * a.y + zx * a.z, xy * a.x + yy * a.y + yz * a.z,
                                                zx * a.x + yz * a.y + zz * a.z};
      }
    }
    // Rayleigh quotient of M^-1 K in the product of the masses
    double up = 0, down = 0, norm = 0;
    for (std::uint32_t i = 0; i < points; ++i) {
      up += dot(u[i], force[i]), down += mass[i] * dot(u[i], u[i]);
      u[i] = (1 / mass[i]) * force[i];
      norm = std::fmax(norm, dot(u[i], u[i]));
    }
    if (!(down > 0 && norm > 0)) break;
    fastest = std::fmax(fastest, up / down);
    for (Double3& d : u) d = (1 / std::sqrt(norm)) * d;
  }
  return fastest;
}

// Three-term recurrence: impulses of all tetrahedra at the last stage's velocities, then the next stage by point.
void SoftBatches::damp(const SoftView& v, Real time, StepContext& c) {
  const std::size_t total = std::size_t(v.points) + 1;
  if (damping_.size() != tets_.size()) {
    damping_.resize(tets_.size());
    stage_.resize(total), last_stage_.resize(total), first_rate_.resize(total), pushes_.resize(total);
  }
  const double z = share_ * stiffest_ * double(v.damping) * double(time);
  const int count = DampingStages::needed(z, kMostStages);
  DampingStages stages(count);
  TetPass p = pass(v, time);
  p.damping = damping_.data();
  p.damping_time = static_cast<Real>(double(v.damping) * double(time) * std::fmin(1, stages.stability_limit() / z));
  p.rates = &v.velocity->x, p.pushes = &pushes_[0].x;
  run(kernels_->damp_begin, p, c);
  for (int k = 0; k < count; ++k) {
    const DampingStage s = stages.next();
    c.jobs->for_blocks(static_cast<std::uint32_t>(total), kPointGrain, [&](std::uint32_t a, std::uint32_t b, int) {
      std::fill(pushes_.begin() + a, pushes_.begin() + b, Row4{});
    });
    run(kernels_->damp, p, c);
    p.rates = &stage_[0].x;
    const Real mu = static_cast<Real>(s.mu), nu = static_cast<Real>(s.nu), rate = static_cast<Real>(s.rate);
    c.jobs->for_blocks(static_cast<std::uint32_t>(total), kPointGrain, [&](std::uint32_t a, std::uint32_t b, int) {
      for (std::uint32_t i = a; i < b; ++i) {
        const Vec3 push = v.delta_position[i].w * pushes_[i].vec();
        if (k == 0) {
          first_rate_[i].set(push), last_stage_[i] = Row4{}, stage_[i] = Row4{}, stage_[i].set(rate * push);
          continue;
        }
        const Vec3 now = stage_[i].vec();
        stage_[i].set(mu * now + nu * last_stage_[i].vec() + rate * (first_rate_[i].vec() + push));
        last_stage_[i].set(now);
      }
    });
  }
  c.jobs->for_blocks(static_cast<std::uint32_t>(total), kPointGrain, [&](std::uint32_t a, std::uint32_t b, int) {
    for (std::uint32_t i = a; i < b; ++i) v.velocity[i].add(stage_[i].vec());
  });
}

}  // namespace feder
