// XPBD of the stable neo-Hookean rows (kernel.h), in solver substeps: what the step resolves pushes as forces at the
// state that the last solver substep left, which is exact at rest, loses no energy, and keeps momentum and angular
// momentum; what it does not, in tetrahedra that are strained much, is solved as XPBD rows at the predicted positions,
// which is stable for any strain. A sweep of XPBD rows alone leaves a body softer by h^2 w^2 of its tetrahedra, and,
// as the two rows balance each other at rest, of another size: seven times the solver substeps for two per cent.
// Damping acts between two half pushes, where velocities and positions are of one time, once in a substep. Kept between
// steps: batches of the mesh. Weak spot: solver substeps grow with the speed of sound over the size of cells; where
// they may not, all of the body acts softer, with a warning (step.cpp).
#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/jobs.h"
#include "soft/batches.h"
#include "soft/stability.h"
#include "state/angular_momentum.h"

namespace feder {
namespace {

constexpr JobGrain kGrain{1024, 4'000};  // points per job
constexpr double kDamped = 2;            // solver substeps at least: damping wants to know what contacts do

class SoftXpbd final : public SoftSolver {
 public:
  SoftXpbd(Arena& a, const Params& p) : batches_(a), predicted_(&a) { batches_.pick(wide_kernels(p)); }

  double wanted_substeps(const SoftView& v, Real h) override {
    batches_.build(v);
    const double least = v.damping > 0 ? kDamped : 1;
    return std::fmax(double(h) * std::sqrt(batches_.fastest() / kResolved), least);
  }

  bool takes(const ElasticLaw& law) const override { return std::strcmp(law.name, "neo_hookean") == 0; }

  SoftStiffness prepare(const SoftView& v, Real h, StepContext&) override {
    batches_.build(v);
    const double z = batches_.fastest() * double(h) * double(h);
    const SoftStiffness stiffness{z > kResolved * kRounding ? kResolved / z : 1};
    batches_.set_step(v, h, stiffness.share);
    batches_.current_position(v);
    return stiffness;
  }

  void advance(const SoftView& v, Real h, StepContext& c) override {
    const bool damped = v.damping > 0 && c.inner.index == turn(c);
    const bool left = damped ? push_damped(v, h, c) : batches_.push(v, h, c);
    const Real time = damped ? h / 2 : h;
    c.jobs->for_blocks(v.points, kGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t i = first; i < last; ++i) {
        Row4& d = v.delta_position[i];
        v.before[i] = {d.x, d.y, d.z, 0};
        if (d.w != 0) v.velocity[i].add(time * v.acceleration[i]);
        d.add(h * v.velocity[i].vec());
        if (!left) v.before[i] = {d.x, d.y, d.z, 1};
      }
    });
    if (left) solve_remainder(v, h, c);
  }

  void validate(const SoftView& v) const override { batches_.validate(v); }

 private:
  static constexpr double kRounding = 1.0001;

  // Rows push along gradients at positions that they move, which is a torque about those where the solver substep
  // began; of a part that nothing holds it is taken out as a rotation of it.
  void solve_remainder(const SoftView& v, Real h, StepContext& c) {
    predicted_.resize(v.points);
    std::copy(v.delta_position, v.delta_position + v.points, predicted_.begin());
    batches_.solve_remainder(v, h, c);
    for (std::uint32_t n = 0; n < v.mesh->parts(); ++n) take_out(v, v.mesh->part(n));
  }

  void take_out(const SoftView& v, std::span<const std::uint32_t> part) {
    const auto place = [&](std::uint32_t k) {
      return Vec3(v.position[part[k]] - v.position[part[0]] + v.before[part[k]].vec());
    };
    const auto mass = [&](std::uint32_t k) { return 1 / predicted_[part[k]].w; };
    const auto count = static_cast<std::uint32_t>(part.size());
    Vec3 gained = Vec3::Zero();  // kg m^2
    Real total = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
      const std::uint32_t i = part[k];
      if (predicted_[i].w == 0) return;
      gained += mass(k) * cross(place(k), Vec3(v.delta_position[i].vec() - predicted_[i].vec()));
      total += mass(k);
    }
    take_out_spin(gained, count, total, 0, mass, place,
                  [&](std::uint32_t k, const Vec3& change) { v.delta_position[part[k]].add(change); });
  }

  // The solver substep in which damping acts in this substep. Always the same one would spare modes that stand still
  // then, and those that are strained much change their frequency until they do.
  static int turn(const StepContext& c) {
    constexpr double kGolden = 0.6180339887498949;
    const double count = static_cast<double>(c.step % (1u << 20)) * c.substeps + c.substep, x = count * kGolden;
    return static_cast<int>((x - std::floor(x)) * c.inner.count);
  }

  // Damping between two half pushes of all forces, those of contacts as the last solver substep had them: at rest there
  // is then nothing to damp. Contacts act later, so their part is taken back; the other half of the forces from outside
  // is left to the caller.
  bool push_damped(const SoftView& v, Real h, StepContext& c) {
    const auto add = [&](Real time, Real contact) {
      c.jobs->for_blocks(v.points, kGrain, [&](std::uint32_t first, std::uint32_t last, int) {
        for (std::uint32_t i = first; i < last; ++i)
          if (v.delta_position[i].w != 0) v.velocity[i].add(time * v.acceleration[i] + contact * v.steady_contact[i]);
      });
    };
    batches_.push(v, h / 2, c);
    add(h / 2, h / 2);
    batches_.damp(v, c.h, c);
    add(0, -h / 2);
    return batches_.push(v, h / 2, c);
  }

  SoftBatches batches_;
  Array<Row4> predicted_;  // displacements before rows moved them, m
};

}  // namespace

Variant<SoftSolver> soft_xpbd() {
  return {"xpbd", "stable neo-Hookean rows in solver substeps: what they resolve is exact, the rest stable",
          [](Arena& a, const Params& p) -> std::unique_ptr<SoftSolver> { return std::make_unique<SoftXpbd>(a, p); }};
}

}  // namespace feder
