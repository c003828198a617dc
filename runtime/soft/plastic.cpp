// Plastic flow, once per step: of the elastic part of F = Fe Fp (multiplicative plasticity; Lee 1969) the shear beyond
// the yield Y relaxes at the rate `flow` (viscoplasticity of Bingham's kind; Perzyna 1966) by implicit Euler, in
// logarithmic principal strains (Weber and Anand 1990), which keeps volumes:
//   d ln Fp/dt = flow (e - Y)/e dev(ln s),  e = sqrt(2/3) |dev(ln s)|, the elongation of a bar that keeps its volume.
// Strain only falls by it, and so does stored energy. A tetrahedron flows until it answers kMostStiffening times as
// much as at first, a third as thick; then a warning. What is inside out does not flow. Kept between steps: the inverse
// of Fp, in the mesh. Weak spot: all of the body takes the solver substeps of what flowed farthest.
#include <cmath>

#include "soft/impl.h"

namespace feder {
namespace {

constexpr Real kMostStiffening = 9;
constexpr double kThinnest = 1e-3;  // of a stretch: what is flatter does not flow

// May the elastic shear be above `yield`? From Green's strain, which bounds it.
bool may_yield(const Mat3d& f, double yield) {
  Mat3d c;
  c.noalias() = f.transpose() * f;
  const double mean = (c(0, 0) + c(1, 1) + c(2, 2)) / 3;
  double square = 0;  // of the deviator
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double d = c(i, j) - (i == j ? mean : 0);
      square += d * d;
    }
  const double spread = std::sqrt(2.0 / 3 * square), least = mean - spread;  // of the eigenvalues of C
  return !(least > 0 && spread / (2 * least) <= yield);
}

}  // namespace

void Soft::Impl::flow(SoftBody& b, StepContext& c) {
  const double yield = double(b.settings.yield), rate = double(b.settings.flow) * double(c.dt);
  bool changed = false, stopped = false;
  for (std::size_t k = 0; k < b.mesh.tetrahedra.size(); ++k) {
    const Mat3d f = b.gradient(k, b.position);
    if (!may_yield(f, yield)) continue;
    const Stretches d = stretches_of(f);
    if (!(d.s[2] > kThinnest)) continue;
    double e[3], mean = 0, square = 0;
    for (int i = 0; i < 3; ++i) e[i] = std::log(d.s[i]), mean += e[i] / 3;
    for (int i = 0; i < 3; ++i) e[i] -= mean, square += e[i] * e[i];
    const double size = std::sqrt(2.0 / 3 * square);
    if (!(size > yield)) continue;
    const double share = rate / (1 + rate) * (size - yield) / size;
    Mat3d back;  // inverse of what flows in this step
    back.setZero();
    for (int i = 0; i < 3; ++i) {
      const Vec3d v = d.v.col(i);
      back.noalias() += std::exp(-share * e[i]) * (v * v.transpose());
    }
    Real* at = &b.mesh.flowed[9 * k];
    const std::array<Real, 9> before = {at[0], at[1], at[2], at[3], at[4], at[5], at[6], at[7], at[8]};
    Mat3d p;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) p(i, j) = double(at[3 * i + j]);
    Mat3d after;
    after.noalias() = p * back;
    const double unit = std::cbrt(determinant(after));
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) at[3 * i + j] = static_cast<Real>(after(i, j) / unit);
    b.mesh.shape(k);
    if (b.mesh.stiffening[k] <= kMostStiffening) {
      changed = true;
      continue;
    }
    std::copy(before.begin(), before.end(), at);
    b.mesh.shape(k);
    stopped = true;
  }
  if (changed) ++b.shape;
  if (!stopped || b.state.warned_flow) return;
  b.state.warned_flow = 1;
  events.warn("plastic_limit",
              objects.describe(b.object) + ": tetrahedra flowed until they answer " +
                  print_number(double(kMostStiffening)) +
                  " times as much as at first; they flow no farther and are elastic: a larger yield, a smaller flow or "
                  "more tetrahedra keep them from it",
              b.object);
}

}  // namespace feder
