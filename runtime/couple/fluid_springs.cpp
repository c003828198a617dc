// Per substep: the net's integrator has moved its points; its faces screen the particles near them (fluid_faces.h); the
// fluid moves; then contacts push both sides apart by their masses, a few times over all of them (projected
// Gauss-Seidel). Points in contact with bodies are handed to the rigid solver with the fluid's impulses. Friction
// (Coulomb, of the fluid's coefficient) goes with each of these impulses. Kept between calls: nothing. Weak spot:
// points much lighter than the particles that lie on them yield between one substep and the next, as springs are not
// solved together with the contacts.
#include "couple/fluid_springs.h"

#include <algorithm>
#include <cmath>

#include "couple/coupling.h"

namespace feder {
namespace {

constexpr int kRounds = 6;
constexpr Real kPush = Real(0.1);  // of the spacing: largest correction of older overlap in a substep

}  // namespace

const SystemDescriptor& FluidSprings::descriptor() {
  return coupling_descriptor<FluidSprings, Fluid, Springs>("faces that meet fluid");
}

FluidSprings::FluidSprings(SystemSetup& s)
    : fluid_(system_of<Fluid>(s)), springs_(system_of<Springs>(s)), points_(s.store.need<Particles>(Springs::kName)),
      objects_(s.objects), contacts_(s.store.need<ContactBook>(kName)), finder_(contacts_.finder(kName)),
      faces_(s.store.arena(kName)), contact_states_(s.store.arena(kName)), pushes_(&s.store.arena(kName)) {}

std::size_t FluidSprings::count() const {
  std::size_t sum = 0;
  for (std::size_t n = 0; n < springs_.net_count(); ++n) sum += springs_.net_info(n).faces.size() / 3;
  return sum;
}

void FluidSprings::add_passes(StepPlan& plan) {
  if (fluid_.pool_count() == 0 || count() == 0) return;
  contacts_.use();
  using F = FluidSprings;
  plan.add<&F::remember>(Rank::net_faces, "remember points", kName, this);
  plan.add<&F::begin>(Rank::face_screen, "screen by faces", kName, this);
  plan.add<&F::solve>(Rank::net_contact, "particles on faces", kName, this);
  plan.add<&F::report>(Rank::fluid_events, "contacts", kName, this);
}

void FluidSprings::list_surfaces() {
  faces_.surfaces.clear();
  for (std::size_t n = 0; n < springs_.net_count(); ++n) {
    const Springs::NetInfo i = springs_.net_info(n);
    if (i.faces.empty()) continue;
    FEDER_ASSERT(i.faces.size() % 3 == 0 && i.first + i.count <= points_.size());
    const Real half = points_.radius[i.first];
    faces_.surfaces.push_back({i.object, i.first, i.faces, half, i.group, i.mask, static_cast<std::uint32_t>(n)});
  }
}

void FluidSprings::remember(StepContext& c) {
  if (c.substep == 0) {
    list_surfaces();
    contact_states_.clear();
    mismatch_ = given_ = 0;
    projected_ = 0;
  }
  faces_.start.assign(points_.position.begin(), points_.position.end());
}

void FluidSprings::begin(StepContext& c) { faces_.screen(fluid_, c); }

void FluidSprings::solve(StepContext&) {
  FEDER_ASSERT(faces_.start.size() == points_.size());  // remembered in this substep
  faces_.end.assign(points_.position.begin(), points_.position.end());
  faces_.find(fluid_);
  if (faces_.contacts.empty()) return;
  pushes_.assign(faces_.contacts.size(), Push{});
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t n = 0; n < faces_.contacts.size(); ++n) push_apart(faces_.contacts[n], pushes_[n]);
  for (std::size_t n = 0; n < faces_.contacts.size(); ++n) record(faces_.contacts[n], pushes_[n]);
  const auto now = [&](std::uint32_t i) { return points_.position[i]; };
  faces_.follow(fluid_, now);
  faces_.project(fluid_, [&](const FaceContact& k, const FaceHit& hit) {
    ++projected_;
    fluid_.pool_at(k.pool).x[k.particle].set(hit.position);
    Push push;
    exchange(k, hit.weight, hit.normal, push);
    record(k, push);
  });
  contact_states_.end_substep();
}

void FluidSprings::record(const FaceContact& k, const Push& total) {
  if (!(total.impulse > 0)) return;
  const FluidPool& p = fluid_.pool_at(k.pool);
  contact_states_.record(faces_.surfaces[k.surface].object, p.object, k.particle, p.x[k.particle].vec(), total.impulse,
                         total.speed, total.normal);
}

void FluidSprings::report(StepContext&) { contact_states_.report(contacts_, finder_, objects_); }

// Along the line from the face's nearest point, where both are now, to the particle: what slides along a face is not
// held back by the point that it has left, and no torque is left.
void FluidSprings::push_apart(const FaceContact& k, Push& total) {
  FluidPool& p = fluid_.pool_at(k.pool);
  const auto corner = [&](int i) { return points_.position[k.vertex[i]]; };
  Vec3 q;
  Real weight[3], response = 1 / p.mass;
  nearest_weights(p.x[k.particle].vec(), corner(0), corner(1), corner(2), q, weight);
  for (int i = 0; i < 3; ++i) response += weight[i] * weight[i] * points_.inv_mass[k.vertex[i]];
  const Vec3 apart = p.x[k.particle].vec() - q;
  Vec3 n = normalized_or(apart, k.normal);
  if (dot(n, k.normal) < Real(0.5)) n = k.normal;  // it passed, or lies far beside the face
  const Real gap = dot(n, apart) - k.rest;
  if (!(gap < 0)) return;
  exchange(k, weight, n, total);
  // overlap from before the substep is undone slowly
  const Real older = std::max(k.rest - k.distance, Real(0));
  const Real need = std::max(-gap - older, Real(0)) + std::min({older, -gap, kPush * p.desc.spacing});
  const Real push = std::min(need, -gap) / response;
  FEDER_ASSERT(!(push < 0));
  p.x[k.particle].set(p.x[k.particle].vec() + (push / p.mass) * n);
  total.moved += push / p.mass;
  faces_.particle_moved(total.moved);
  for (int i = 0; i < 3; ++i) {
    const std::uint32_t v = k.vertex[i];
    points_.move(v, (-push * weight[i] * points_.inv_mass[v]) * n);
  }
}

// The closing velocity becomes zero, by an impulse on both sides.
void FluidSprings::exchange(const FaceContact& k, const Real (&weight)[3], const Vec3& n, Push& total) {
  FluidPool& p = fluid_.pool_at(k.pool);
  Vec3 u = p.v[k.particle].vec();
  Real response = 1 / p.mass;
  for (int i = 0; i < 3; ++i) {
    u -= weight[i] * points_.velocity[k.vertex[i]];
    response += weight[i] * weight[i] * points_.inv_mass[k.vertex[i]];
  }
  const Real closing = -dot(n, u);
  if (!(closing > 0)) return;
  FEDER_ASSERT(!(response < 0) && is_direction(n) && k.particle < p.count);
  const Vec3 slip = u - dot(u, n) * n, pressing = (closing / response) * n;
  const Vec3 impulse = pressing + friction_impulse(slip, response, p.desc.friction * length(pressing));
  // momentum before and after, for the mismatch
  double before[3], after[3];
  const auto sum = [&](double(&out)[3]) {
    for (int j = 0; j < 3; ++j) {
      out[j] = static_cast<double>(p.mass) * static_cast<double>(p.v[k.particle].vec()[j]);
      for (int i = 0; i < 3; ++i)
        if (points_.inv_mass[k.vertex[i]] != 0)
          out[j] +=
              static_cast<double>(points_.mass[k.vertex[i]]) * static_cast<double>(points_.velocity[k.vertex[i]][j]);
    }
  };
  sum(before);
  Vec3 held = Vec3::Zero();  // impulse on pinned points, N s
  p.v[k.particle].set(p.v[k.particle].vec() + impulse / p.mass);
  for (int i = 0; i < 3; ++i) {
    const std::uint32_t v = k.vertex[i];
    if (points_.inv_mass[v] == 0) held += weight[i] * impulse;
    points_.velocity[v] -= (weight[i] * points_.inv_mass[v]) * impulse;
  }
  sum(after);
  for (int j = 0; j < 3; ++j)
    mismatch_ = std::max(mismatch_, std::abs(after[j] - before[j] - static_cast<double>(held[j])));
  given_ += static_cast<double>(length(impulse));
  total.impulse += length(pressing), total.normal = n;
  total.speed = std::max(total.speed, closing);
}

void FluidSprings::residuals(std::vector<Residual>& out) const {
  out.push_back({"fluid_springs.impulse_mismatch", given_ > 0 ? mismatch_ / given_ : 0});
  out.push_back({"fluid_springs.impulse_ns", given_});
  out.push_back({"fluid_springs.guarded", static_cast<double>(projected_)});
}

void FluidSprings::validate() const {
  if (fluid_.pool_count() == 0 || count() == 0) return;  // the lists are of an earlier step
  FEDER_ASSERT(contact_states_.empty());                 // reported
  faces_.validate();
  for (const FaceSurface& s : faces_.surfaces) FEDER_ASSERT(s.first < points_.size() && s.index < springs_.net_count());
}

}  // namespace feder
