// Per substep: sheets screen the particles near them (fluid_faces.h); the fluid moves; particles that lie on a sheet or
// would pass it in this substep become solver bodies, so that the surface substeps solve their contacts together with
// the cloth's stretch and with bodies: the weight of a pool reaches the pins within the substep. Then the particles are
// read back, and projected so that none passes a triangle. Friction (Coulomb, of the fluid's coefficient) follows,
// contact by contact, on the particle and on the point of the sheet below it: half a spacing apart, which is a moment
// that nobody feels. Contacts have no wetting. Kept between calls: impulses on each cloth, for waking. Weak spot: a
// pool of N layers presses its first layer into the sheet by about N g h^2 in each substep and is pushed out again; a
// cloth far lighter than a single particle follows single drops in jerks, and wcsph, explicit, gains energy on it
// (tests/couple/test_fluid_cloth_leaks.cpp: 37 kg of water on 0.2 kg/m2 get some 12 W and shake at 1 m/s; dfsph and pbf
// do not).
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
    : arena_(s.store.arena(kName)), fluid_(system_of<Fluid>(s)), cloth_(system_of<Cloth>(s)),
      surfaces_(s.store.get<Surfaces>()), solver_bodies_(s.store.need<SolverBodies>(kName)), objects_(s.objects),
      contacts_(s.store.need<ContactBook>(kName)), finder_(contacts_.finder(kName)), faces_(arena_) {
  if (solver_bodies_.state.empty()) solver_bodies_.reset();  // without bodies there is only the world
}

std::size_t FluidCloth::count() const { return particle_bodies_.size(); }

void FluidCloth::add_passes(StepPlan& plan) {
  drop_rows();
  particle_bodies_.clear();  // their fluid may be gone, and with it the passes that would list them anew
  if (fluid_.pool_count() == 0 || cloth_.cloth_count() == 0) return;
  contacts_.use();
  using F = FluidCloth;
  plan.add<&F::wake>(Rank::cloth_approach, "wake sheets", kName, this);
  if (cloth_.cloth_count() > 1) plan.add<&F::connect>(Rank::surface_candidates, "connect sheets", kName, this);
  plan.add<&F::begin>(Rank::face_screen, "screen by sheets", kName, this);
  plan.add<&F::make_rows>(Rank::cloth_particles, "particles on sheets", kName, this);
  plan.add<&F::read_back>(Rank::cloth_read_back, "read back and project", kName, this);
  plan.add<&F::finish>(Rank::cloth_load, "loads", kName, this);
}

// Removes the rows of an earlier substep; those of bodies have a contact state.
void FluidCloth::drop_rows() {
  for (std::size_t k = 0; k < surfaces_.group_count; ++k)
    std::erase_if(surfaces_.groups[k]->rows, [](const SurfaceRow& r) { return r.contact_state == kNone; });
}

void FluidCloth::list_surfaces() {
  faces_.surfaces.clear();
  for (std::size_t n = 0; n < cloth_.cloth_count(); ++n) {
    const Cloth::Info i = cloth_.info(n);
    faces_.surfaces.push_back(
        {i.object, i.first, i.triangles, i.thickness / 2, i.group, i.mask, static_cast<std::uint32_t>(n)});
  }
}

ObjectId FluidCloth::fluid_of(std::uint32_t pool) const { return fluid_.pool_at(pool).object; }

// Cloth that carries fluid stays awake; cloth that fluid may reach in this step wakes.
void FluidCloth::wake(StepContext& c) {
  list_surfaces();
  const ClothVertices& v = cloth_.vertices();
  faces_.start.assign(v.position.begin(), v.position.end());
  for (FaceSurface& s : faces_.surfaces) {
    const Cloth::Info info = cloth_.info(s.index);
    bool loaded = false;
    for (const Pressed& p : pressed_) loaded = loaded || (p.cloth == s.object && p.all > 0);
    if (!loaded && info.asleep) {
      Real fastest = 0;
      for (std::size_t n = 0; n < fluid_.pool_count(); ++n) fastest = std::max(fastest, fluid_.pool_at(n).max_speed());
      loaded = faces_.near(fluid_, s, c.dt * (fastest + c.dt * length(c.gravity)));
    }
    if (loaded) cloth_.wake(s.object, kFluidCause, fluid_.pool_count() ? fluid_of(0) : ObjectId{});
  }
  contact_states_.clear();
  pressed_.clear();
  for (const FaceSurface& s : faces_.surfaces) pressed_.push_back({s.object, 0, 0, 0});
  for (const FaceSurface& s : faces_.surfaces)
    if (!cloth_.info(s.index).asleep) find_impact(s.index, c);
  mismatch_ = given_ = force_ = 0;
  projected_ = 0;
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

// Sheets that particles may reach in this step act on each other through them, so they form one group.
void FluidCloth::connect(StepContext& c) {
  const ClothVertices& v = cloth_.vertices();
  const std::uint32_t count = static_cast<std::uint32_t>(cloth_.cloth_count());
  std::uint32_t first = count;
  for (std::uint32_t n = 0; n < count; ++n) {
    const Cloth::Info info = cloth_.info(n);
    Aabb box;
    Real fastest = 0;
    for (std::uint32_t i = info.first; i < info.first + info.count; ++i) {
      box.include(v.position[i]);
      fastest = std::max(fastest, dot(v.velocity[i], v.velocity[i]));
    }
    const Real travel = c.dt * (std::sqrt(fastest) + 2 * c.dt * length(c.gravity));
    box.grow(info.thickness + travel);
    if (!wet(box, c.dt)) continue;
    if (first < n) surfaces_.connections.push_back({first, n, 0});
    first = std::min(first, n);
  }
}

bool FluidCloth::wet(const Aabb& box, Real seconds) const {
  for (std::size_t n = 0; n < fluid_.pool_count(); ++n) {
    const FluidPool& p = fluid_.pool_at(n);
    Aabb swept = box;
    swept.grow(p.desc.spacing + seconds * p.max_speed());
    for (std::uint32_t i = 0; i < p.count; ++i)
      if (overlaps(swept, Aabb{p.x[i].vec(), p.x[i].vec()})) return true;
  }
  return false;
}

void FluidCloth::begin(StepContext& c) {
  const ClothVertices& v = cloth_.vertices();
  const std::span<const Row4> delta_position = surfaces_.delta_position;
  FEDER_ASSERT(delta_position.size() >= v.size());
  faces_.start.resize(v.size()), faces_.end.resize(v.size());
  for (std::uint32_t i = 0; i < v.size(); ++i) faces_.start[i] = v.position[i] + delta_position[i].vec();
  faces_.screen(fluid_, c);
}

void FluidCloth::make_rows(StepContext& c) {
  drop_rows();
  particle_bodies_.clear();
  const std::span<const Row4> velocity = surfaces_.velocity;
  const ClothVertices& v = cloth_.vertices();
  // contacts, with the vertices predicted by their velocities
  for (std::uint32_t i = 0; i < v.size(); ++i) faces_.end[i] = faces_.start[i] + c.h * velocity[i].vec();
  faces_.find(fluid_);
  own_bodies_ = static_cast<std::uint32_t>(solver_bodies_.state.size());
  FEDER_ASSERT(own_bodies_ > 0 && solver_bodies_.mass.size() == own_bodies_);  // the first is the world
  const std::span<const Row4> delta_position = surfaces_.delta_position;
  for (const FaceContact& k : faces_.contacts) {
    const FluidPool& p = fluid_.pool_at(k.pool);
    // the first contact of a particle makes its solver body
    if (particle_bodies_.empty() || particle_bodies_.back().pool != k.pool ||
        particle_bodies_.back().particle != k.particle) {
      FEDER_ASSERT(k.particle < p.count && p.origin.size() > k.particle);
      ParticleBody body;
      body.pool = k.pool, body.particle = k.particle;
      body.solver_index = static_cast<std::uint32_t>(solver_bodies_.state.size());
      body.given = (p.x[k.particle].vec() - p.origin[k.particle].vec()) / c.h;
      SolverBody s;
      s.velocity = body.given;
      SolverMass m;
      m.inv_mass = 1 / p.mass, m.inv_mass_axes = Vec3::Constant(1 / p.mass);
      m.center = p.origin[k.particle].vec();
      solver_bodies_.state.push_back(s), solver_bodies_.mass.push_back(m);
      particle_bodies_.push_back(body);
    }
    // one row per contact, in the group of the cloth
    SurfaceRow r;
    Vec3 d = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
      r.vertex[i] = k.vertex[i], r.weight[i] = k.weight[i];
      d += k.weight[i] * delta_position[k.vertex[i]].vec();
    }
    FEDER_ASSERT(r.vertex[0] < v.size() && v.cloth[r.vertex[0]] == faces_.surfaces[k.surface].object);
    r.vertex[3] = k.vertex[0];
    r.normal = -k.normal;
    r.solver_index = particle_bodies_.back().solver_index;
    r.offset = k.distance - k.rest - dot(r.normal, d);
    const std::size_t cloth = faces_.surfaces[k.surface].index, group = surfaces_.group_of(cloth);
    r.relaxation = cloth_.info(cloth).relaxation;
    surfaces_.groups[group]->use_body(r.solver_index);
    surfaces_.groups[group]->rows.push_back(r);
  }
}

void FluidCloth::read_back(StepContext& c) {
  const Real g = length(c.gravity);
  std::size_t at = 0;
  pressing_.assign(faces_.contacts.size(), Pressing{});
  next_row_.assign(surfaces_.group_count, 0);
  for (std::size_t n = 0; n < faces_.contacts.size(); ++n) {
    const FaceContact& k = faces_.contacts[n];
    // rows are in the order of the contacts, with those of bodies before or after
    const std::size_t group = surfaces_.group_of(faces_.surfaces[k.surface].index);
    const Array<SurfaceRow>& rows = surfaces_.groups[group]->rows;
    std::uint32_t& next = next_row_[group];
    while (next < rows.size() && rows[next].contact_state != kNone) ++next;
    FEDER_ASSERT(next < rows.size());  // no row, and with it its impulse, is lost
    const SurfaceRow& r = rows[next++];
    while (particle_bodies_[at].solver_index != r.solver_index) {
      ++at;
      FEDER_ASSERT(at < particle_bodies_.size());
    }
    // its impulse: on the particle, on the cloth, in the contact state
    const Real net = r.impulse - r.returned;
    particle_bodies_[at].pushed -= net * r.normal;
    FEDER_ASSERT(k.pool == particle_bodies_[at].pool && k.particle == particle_bodies_[at].particle);
    pressing_[n] = {net, -r.normal};
    if (net > 0) record(k, net, r.approach, -r.normal);
    Pressed& to = pressed_[faces_.surfaces[k.surface].index];
    to.all += std::abs(net);
    if (g > 0) to.along += net * dot(r.normal, c.gravity) / g;
    given_ += static_cast<double>(std::abs(net));
  }
  // particles move as their solver bodies did
  FEDER_ASSERT(solver_bodies_.state.size() == own_bodies_ + particle_bodies_.size());
  for (const ParticleBody& k : particle_bodies_) {
    FluidPool& p = fluid_.pool_at(k.pool);
    const Vec3 gain = solver_bodies_.state[k.solver_index].velocity - k.given;
    if (k.solver_index >= own_bodies_ && !gain.isZero(0)) {
      const Vec3 now = p.origin[k.particle].vec() + surfaces_.body_delta_position[k.solver_index];
      faces_.particle_moved(length(Vec3(now - p.x[k.particle].vec())));
      p.x[k.particle].set(now);
      p.v[k.particle].set(p.v[k.particle].vec() + gain);
    }
    for (int i = 0; i < 3; ++i)
      mismatch_ = std::max(mismatch_, std::abs(static_cast<double>(p.mass * gain[i] - k.pushed[i])));
  }
  solver_bodies_.state.resize(own_bodies_), solver_bodies_.mass.resize(own_bodies_);
  drop_rows();
  for (std::size_t n = 0; n < faces_.contacts.size(); ++n)
    rub(faces_.contacts[n], faces_.contacts[n].weight, pressing_[n].normal, pressing_[n].impulse);
  // non-penetration projection against the faces where they are now
  const auto now = [&](std::uint32_t i) {
    return Vec3(cloth_.vertices().position[i] + surfaces_.delta_position[i].vec());
  };
  faces_.follow(fluid_, now);
  faces_.project(fluid_, [&](const FaceContact& k, const FaceHit& hit) { project_out(k, hit, c); });
  contact_states_.end_substep();
}

// Projection of a particle that passed a face, or is too near to it: back to where it met the face, and the closing
// velocity becomes zero, by an impulse on both sides.
void FluidCloth::project_out(const FaceContact& k, const FaceHit& hit, StepContext& c) {
  FluidPool& p = fluid_.pool_at(k.pool);
  ++projected_;
  p.x[k.particle].set(hit.position);
  Real response;
  const Vec3 u = slip(k, hit.weight, response);
  const Real closing = -dot(hit.normal, u);
  if (!(closing > 0)) return;
  FEDER_ASSERT(!(response < 0) && is_direction(hit.normal));
  const Vec3 impulse = (closing / response) * hit.normal;
  exchange(k, hit.weight, impulse);
  rub(k, hit.weight, hit.normal, length(impulse));
  record(k, length(impulse), closing, hit.normal);
  Pressed& to = pressed_[faces_.surfaces[k.surface].index];
  to.all += length(impulse);
  if (length(c.gravity) > 0) to.along -= dot(impulse, c.gravity) / length(c.gravity);
}

// Friction of a contact that pressed with that impulse, N s.
void FluidCloth::rub(const FaceContact& k, const Real (&weight)[3], const Vec3& normal, Real pressing) {
  FluidPool& p = fluid_.pool_at(k.pool);
  if (!(pressing > 0) || !(p.desc.friction > 0)) return;
  Real response;
  const Vec3 u = slip(k, weight, response);
  exchange(k, weight, friction_impulse(u - dot(u, normal) * normal, response, p.desc.friction * pressing));
}

// Velocity of a particle against the point of the face with these weights, and the change of it by an impulse, 1/kg.
Vec3 FluidCloth::slip(const FaceContact& k, const Real (&weight)[3], Real& response) const {
  const FluidPool& p = fluid_.pool_at(k.pool);
  Vec3 u = p.v[k.particle].vec();
  response = 1 / p.mass;
  for (int i = 0; i < 3; ++i) {
    u -= weight[i] * surfaces_.velocity[k.vertex[i]].vec();
    response += weight[i] * weight[i] * surfaces_.delta_position[k.vertex[i]].w;
  }
  return u;
}

// An impulse on the particle, and its opposite on the face.
void FluidCloth::exchange(const FaceContact& k, const Real (&weight)[3], const Vec3& impulse) {
  FluidPool& p = fluid_.pool_at(k.pool);
  p.v[k.particle].set(p.v[k.particle].vec() + impulse / p.mass);
  for (int i = 0; i < 3; ++i) cloth_.push(k.vertex[i], -weight[i] * impulse);
}

// Load of fluid on each cloth, added to that of bodies.
void FluidCloth::finish(StepContext& c) {
  const Real g = length(c.gravity);
  for (std::size_t n = 0; n < pressed_.size(); ++n) {
    Pressed& p = pressed_[n];
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
  contact_states_.report(contacts_, finder_, objects_);
}

void FluidCloth::record(const FaceContact& k, Real impulse, Real speed, const Vec3& normal) {
  contact_states_.record(faces_.surfaces[k.surface].object, fluid_of(k.pool), k.particle,
                         fluid_.pool_at(k.pool).x[k.particle].vec(), impulse, speed, normal);
}

void FluidCloth::residuals(std::vector<Residual>& out) const {
  out.push_back({"fluid_cloth.impulse_mismatch", given_ > 0 ? mismatch_ / given_ : 0});
  out.push_back({"fluid_cloth.force_n", force_});
  out.push_back({"fluid_cloth.guarded", static_cast<double>(projected_)});
}

void FluidCloth::validate() const {
  FEDER_ASSERT(contact_states_.empty());  // reported
  for (std::size_t k = 0; k < surfaces_.group_count; ++k)
    for (const SurfaceRow& r : surfaces_.groups[k]->rows)
      FEDER_ASSERT(r.contact_state != kNone);  // rows of particles live within a substep
  for (std::size_t k = 0; k < particle_bodies_.size(); ++k)
    FEDER_ASSERT(particle_bodies_[k].solver_index == own_bodies_ + k && particle_bodies_[k].pool < fluid_.pool_count());
  if (fluid_.pool_count() == 0 || cloth_.cloth_count() == 0) return;
  FEDER_ASSERT(pressed_.size() == cloth_.cloth_count());
  faces_.validate();
}

}  // namespace feder
