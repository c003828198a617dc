// Free rotation of awake bodies with uneven moments of inertia that are on no joint, in batches of eight
// (spin_batch.h). Kept between steps: the angular momentum, beside the body. Jointed bodies: jointed_body.h.
#include "base/jobs.h"
#include "base/wide.h"
#include "rigid/impl.h"

namespace feder {
namespace {

constexpr JobGrain kSpinGrain{16, 3'000};  // batches per job

void put(Lane8x3& to, std::uint32_t lane, const Vec3& v) {
  to.x.v[lane] = v[0], to.y.v[lane] = v[1], to.z.v[lane] = v[2];
}
// Minus the middle one of them.
Vec3 from_middle(const Vec3& v) {
  const Real middle = v.sum() - v.maxCoeff() - v.minCoeff();
  int nearest = 0;
  (v - Vec3::Constant(middle)).cwiseAbs().minCoeff(&nearest);
  return v - Vec3::Constant(v[nearest]);
}
Vec3 lane_of(const Lane8x3& from, std::uint32_t lane) { return {from.x.v[lane], from.y.v[lane], from.z.v[lane]}; }

}  // namespace

const SpinKernels& spin_kernels([[maybe_unused]] bool wide) {
#if defined(__x86_64__) || defined(__i386__)
  if (wide && runs_avx2()) return kSpinKernelsAvx2;
#endif
  return kSpinKernelsPlain;
}

// Lanes for the bodies of this step, ascending.
void Rigid::Impl::list_spins(StepContext& c) {
  const std::uint32_t count = static_cast<std::uint32_t>(moving.size());
  spin_lane.resize(count);
  std::uint32_t used = 0;
  for (std::uint32_t p = 0; p < count; ++p) {
    const std::uint32_t i = moving[p];
    const bool spins = asymmetric[i] && bodies.type[i] == BodyType::dynamic && !uneven_body(p + 1);
    spin_lane[p] = spins ? used++ : kNone;
  }
  spin_batches.resize((used + kLanes - 1) / kLanes);
  if (used == 0) return;
  SpinBatch& last = spin_batches.back();
  std::memset(static_cast<void*>(&last), 0, sizeof last);
  each_moving(c, [&](std::uint32_t p) {
    if (spin_lane[p] != kNone) fill_spin(p);
  });
  for (SpinBatch& b : spin_batches) b.count = kLanes;
  last.count = used - (static_cast<std::uint32_t>(spin_batches.size()) - 1) * kLanes;
  for (std::uint32_t k = last.count; k < kLanes; ++k) last.index[k] = last.index[0];
}

void Rigid::Impl::fill_spin(std::uint32_t p) {
  const std::uint32_t i = moving[p], lane = spin_lane[p] % kLanes;
  SpinBatch& b = spin_batches[spin_lane[p] / kLanes];
  b.index[lane] = p + 1;
  put(b.axis, lane, principal[i].vec());
  b.real.v[lane] = principal[i].w;
  put(b.inv_moments, lane, inv_moments[i]);
  put(b.saddle, lane, from_middle(inv_moments[i]));
  b.invariant.v[lane] = bodies.angular_velocity[i] == kept_angular_velocity[i] ? spin_invariant[i] : kUnknownSpin;
  put(b.momentum, lane, angular_momentum[p]);
  put(b.torque, lane, applied_torque[p]);
  put(b.given, lane, bodies.angular_velocity[i]);
  b.damping.v[lane] = bodies.angular_damping[i];
}

void Rigid::Impl::spin(StepContext& c) {
  if (spin_batches.empty()) return;
  SpinPass pass{};
  pass.batches = spin_batches.data();
  pass.bodies = reinterpret_cast<Real*>(solver_bodies.state.data());
  pass.start = c.substep == 0;
  pass.h = c.h;
  pass.close = kEpsilon;
  const SpinKernels& kernels = spin_kernels(solver->wide());
  c.jobs->for_blocks(static_cast<std::uint32_t>(spin_batches.size()), kSpinGrain,
                     [&](std::uint32_t first, std::uint32_t last, int) {
                       SpinPass part = pass;
                       part.first = first, part.last = last;
                       kernels.spin(part);
                     });
}

// Principal axes and moments of inertia.
void Rigid::Impl::load_principal(std::uint32_t i) {
  const Mat3& inv = bodies.inv_inertia[i];
  principal[i] = {};
  inv_moments[i] = inv.diagonal();
  spin_invariant[i] = kUnknownSpin;
  if (inv(0, 1) == 0 && inv(0, 2) == 0 && inv(1, 2) == 0) return;
  Mat3 axes;
  eigen_symmetric(inv, inv_moments[i], axes);
  principal[i] = from_matrix(axes);
}

// Angular momentum now, with the pushes since the last substep began.
Vec3 Rigid::Impl::spin_momentum(std::uint32_t p) {
  const std::uint32_t lane = spin_lane[p] % kLanes;
  const SpinBatch& b = spin_batches[spin_lane[p] / kLanes];
  const Vec3 l = lane_of(b.momentum, lane);
  const Vec3 pushed = solver_bodies.state[p + 1].angular_velocity - lane_of(b.given, lane);
  spin_invariant[moving[p]] = pushed.isZero(0) ? b.invariant.v[lane] : kUnknownSpin;
  if (pushed.isZero(0)) return l;
  Mat3 m;
  for (int k = 0; k < 3; ++k) m(k, k) = b.inertia[k].v[lane];
  m(0, 1) = m(1, 0) = b.inertia[3].v[lane];
  m(0, 2) = m(2, 0) = b.inertia[4].v[lane];
  m(1, 2) = m(2, 1) = b.inertia[5].v[lane];
  return l + m * pushed;
}

void Rigid::Impl::stop_spin(std::uint32_t p) {
  if (spin_lane[p] == kNone) return;
  SpinBatch& b = spin_batches[spin_lane[p] / kLanes];
  put(b.momentum, spin_lane[p] % kLanes, Vec3::Zero());
  put(b.given, spin_lane[p] % kLanes, Vec3::Zero());
}

}  // namespace feder
