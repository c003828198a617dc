// What is special to cloth in fluid (the rest: fluid_skins.h): sheets that fluid reaches wake, take as many solver
// substeps as what flies at them asks for, and know the load that they carry. Kept between calls: impulses on each
// cloth, for waking. Weak spot: a cloth far lighter than a single particle follows single drops in jerks, and wcsph,
// explicit, gains energy on it (tests/couple/test_fluid_cloth_leaks.cpp: 37 kg of water on 0.2 kg/m2 get some 12 W and
// shake at 1 m/s; dfsph and pbf do not).
#include "couple/fluid_cloth.h"

#include <algorithm>
#include <cmath>

#include "couple/coupling.h"
#include "state/cloth_vertices.h"

namespace feder {
namespace {

constexpr Real kWakeCloth = Real(1e-6);  // N s per kg of cloth: more than rounding
constexpr Real kCarried = Real(0.1);     // least share of the weight of the fluid near a cloth that the cloth carries

}  // namespace

const SystemDescriptor& FluidCloth::descriptor() {
  return coupling_descriptor<FluidCloth, Fluid, Cloth>("particles at cloth");
}

FluidCloth::FluidCloth(SystemSetup& s)
    : fluid_(system_of<Fluid>(s)), cloth_(system_of<Cloth>(s)), skins_(FluidSkins::of(s, kName)),
      pressed_(&s.store.arena(kName)) {}

std::size_t FluidCloth::count() const { return skins_.count(); }

void FluidCloth::add_passes(StepPlan& plan) {
  skins_.add_passes(plan, Cloth::kName, kName, {"screen by sheets", "particles on sheets", "connect sheets"});
  if (fluid_.pool_count() == 0 || cloth_.cloth_count() == 0) return;
  using F = FluidCloth;
  plan.add<&F::wake>(Rank::cloth_approach, "wake sheets", kName, this);
  plan.add<&F::finish>(Rank::cloth_load, "loads", kName, this);
}

// Cloth that carries fluid stays awake; cloth that fluid may reach in this step wakes.
void FluidCloth::wake(StepContext& c) {
  const ClothVertices& v = cloth_.vertices();
  for (std::uint32_t n = 0; n < cloth_.cloth_count(); ++n) {
    const Cloth::Info i = cloth_.info(n);
    bool loaded = false;
    for (const Pressed& p : pressed_) loaded = loaded || (p.cloth == i.object && p.all > 0);
    if (!loaded && i.asleep)
      loaded = FluidFaces::near(fluid_, {i.object, i.first, i.triangles, i.thickness / 2, i.group, i.mask, n},
                                {v.position.data(), v.position.size()}, c);
    if (loaded) cloth_.wake(i.object, kFluidCause, fluid_.pool_count() ? fluid_.pool_at(0).object : ObjectId{});
  }
  pressed_.clear();
  for (std::uint32_t n = 0; n < cloth_.cloth_count(); ++n) pressed_.push_back({cloth_.info(n).object, 0, 0, 0});
  for (std::uint32_t n = 0; n < cloth_.cloth_count(); ++n)
    if (!cloth_.info(n).asleep) find_impact(n, c);
}

// What flies at a sheet has to be stopped within a sixteenth of its size: its energy says how fast that has to be, and
// with it how many solver substeps the sheet takes (Cloth::set_impact). With too few, the sheet throws it back faster
// than it came.
void FluidCloth::find_impact(std::size_t n, StepContext& c) {
  const ClothVertices& v = cloth_.vertices();
  const Cloth::Info info = cloth_.info(n);
  Aabb now, swept;
  Vec3 momentum = Vec3::Zero();
  Real mass = 0;
  for (std::uint32_t i = info.first; i < info.first + info.count; ++i) {
    now.include(v.position[i]), swept.include(Vec3(v.position[i] + c.dt * v.velocity[i]));
    momentum += v.mass[i] * v.velocity[i], mass += v.mass[i];
  }
  swept.include(now);
  const Vec3 mean = momentum / mass;
  double energy = 0, arriving = 0;  // twice that of the particles that may arrive in this step, J; their mass, kg
  for (std::size_t k = 0; k < fluid_.pool_count(); ++k) {
    const FluidPool& p = fluid_.pool_at(k);
    if (!(p.desc.group & info.mask) || !(info.group & p.desc.mask)) continue;
    Aabb box = swept;
    box.grow(p.desc.spacing + info.thickness);
    for (std::uint32_t i = 0; i < p.count; ++i) {
      const Vec3 x = p.x[i].vec(), u = p.v[i].vec() - mean, to = x + c.dt * u;
      if (!overlaps(box, Aabb{x.cwiseMin(to), x.cwiseMax(to)})) continue;
      energy += static_cast<double>(p.mass) * static_cast<double>(dot(u, u)), arriving += static_cast<double>(p.mass);
    }
  }
  pressed_[n].near = static_cast<Real>(arriving);
  const Real size = (now.hi - now.lo).maxCoeff();
  if (energy > 0 && size > 0) cloth_.set_impact(n, static_cast<Real>(8 * energy / static_cast<double>(mass * size)), 0);
}

// Load of fluid on each cloth, added to that of bodies.
void FluidCloth::finish(StepContext& c) {
  const Real g = length(c.gravity);
  force_ = 0;
  for (std::size_t n = 0; n < pressed_.size(); ++n) {
    Pressed& p = pressed_[n];
    const FluidSkins::Pressed now = skins_.pressed(p.cloth);
    p.along = now.along, p.all = now.all;
    const Cloth::Info info = cloth_.info(n);
    FEDER_ASSERT(p.cloth == info.object && !(p.all < std::abs(p.along) * Real(0.999)));
    Real own = 0;
    bool held = false;
    for (std::uint32_t i = info.first; i < info.first + info.count; ++i)
      own += cloth_.vertices().mass[i], held = held || cloth_.vertices().inv_mass[i] == 0;
    if (p.all < kWakeCloth * own) p.all = 0;
    force_ += static_cast<double>(p.along / c.dt);
    if (info.asleep || !(g > 0)) continue;
    Real on = std::max(p.along, Real(0)) / (g * c.dt);
    // a cloth without pins lies on something; one with pins carries all the fluid near it, also while that jumps: with
    // a number of substeps that comes and goes, it would go on jumping
    if (held && on > kCarried * p.near) on = p.near;
    cloth_.set_load(n, std::min(cloth_.load(n) + on, std::max(Cloth::kMaxLoad * own, held ? p.near : Real(0))));
  }
  skins_.report();
}

void FluidCloth::residuals(std::vector<Residual>& out) const {
  out.push_back({"fluid_cloth.impulse_mismatch", skins_.mismatch()});
  out.push_back({"fluid_cloth.force_n", force_});
  out.push_back({"fluid_cloth.guarded", skins_.projected()});
}

void FluidCloth::validate() const {
  if (fluid_.pool_count() == 0 || cloth_.cloth_count() == 0) return;
  FEDER_ASSERT(pressed_.size() == cloth_.cloth_count());
  skins_.validate();
}

}  // namespace feder
