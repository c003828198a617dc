// What is special to soft bodies in fluid (the rest: fluid_skins.h): those that fluid reaches wake, and what it presses
// on stays awake. Pressure reaches the skin as the push of the particles that lie on it, half a spacing outside it: a
// block displaces its volume, and floats. Kept between calls: impulses on each, for waking. Weak spots: a
// fluid that lies on one never sleeps; a single layer of particles that is left on top of a block has no pressure to
// run off by, and presses a block that dived down by a spacing (at 900 kg/m3, from above, 0.43 m deep in place of
// 0.36); under a block that dived to a few spacings above the ground pbf and wcsph lack up to a tenth of the pressure,
// as under rigid ones.
#include "couple/fluid_soft.h"

#include "couple/coupling.h"

namespace feder {
namespace {

constexpr Real kWakeSoft = Real(1e-6);  // m/s: more than rounding

}  // namespace

const SystemDescriptor& FluidSoft::descriptor() {
  return coupling_descriptor<FluidSoft, Fluid, Soft>("particles at soft bodies");
}

FluidSoft::FluidSoft(SystemSetup& s)
    : fluid_(system_of<Fluid>(s)), soft_(system_of<Soft>(s)), skins_(FluidSkins::of(s, kName)),
      pressed_(&s.store.arena(kName)) {}

std::size_t FluidSoft::count() const { return skins_.count(); }

void FluidSoft::add_passes(StepPlan& plan) {
  skins_.add_passes(plan, Soft::kName, kName, {"screen by skins", "particles on skins", "connect skins"});
  if (fluid_.pool_count() == 0 || soft_.soft_count() == 0) return;
  using F = FluidSoft;
  plan.add<&F::wake>(Rank::cloth_approach, "wake soft bodies", kName, this);
  plan.add<&F::finish>(Rank::cloth_load, "pressed skins", kName, this);
}

// A soft body that fluid presses on stays awake; one that fluid may reach in this step wakes.
void FluidSoft::wake(StepContext& c) {
  for (std::uint32_t n = 0; n < soft_.soft_count(); ++n) {
    const Soft::Info i = soft_.info(n);
    bool pressed = false;
    for (const Pressed& p : pressed_) pressed = pressed || (p.soft == i.object && p.all > 0);
    if (!pressed && soft_.asleep(i.object))
      pressed = FluidFaces::near(fluid_, {i.object, 0, i.skin, i.thickness / 2, i.group, i.mask, n}, i.points, c);
    if (pressed) soft_.wake(i.object, kFluidCause, fluid_.pool_at(0).object);
  }
}

void FluidSoft::finish(StepContext& c) {
  pressed_.clear();
  force_ = 0;
  for (std::uint32_t n = 0; n < soft_.soft_count(); ++n) {
    const Soft::Info i = soft_.info(n);
    FluidSkins::Pressed p = skins_.pressed(i.object);
    Real lightest = kInfinity;  // 1/kg, of a point
    for (const Real w : i.inv_mass) lightest = w > 0 ? std::min(lightest, w) : lightest;
    pressed_.push_back({i.object, p.all > kWakeSoft / lightest ? p.all : Real(0)});
    force_ += static_cast<double>(p.along / c.dt);
  }
  skins_.report();
}

void FluidSoft::residuals(std::vector<Residual>& out) const {
  out.push_back({"fluid_soft.impulse_mismatch", skins_.mismatch()});
  out.push_back({"fluid_soft.force_n", force_});
  out.push_back({"fluid_soft.guarded", skins_.projected()});
}

void FluidSoft::validate() const {
  if (fluid_.pool_count() == 0 || soft_.soft_count() == 0) return;
  FEDER_ASSERT(pressed_.size() == soft_.soft_count());
  skins_.validate();
}

}  // namespace feder
