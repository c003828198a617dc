// Per substep: faces screen the particles near them (fluid_faces.h); the fluid moves; particles that lie on a face or
// would pass it in this substep become solver bodies, so that the surface substeps solve their contacts together with
// the elasticity of sheets and soft bodies and with bodies: the weight of a pool reaches the pins, and its pressure the
// inside of a block, within the substep. Then the particles are read back, and projected so that none passes a
// triangle. Friction (Coulomb, of the fluid's coefficient) follows, contact by contact, on the particle and on the
// point of the face below it: half a spacing apart, which is a moment that nobody feels. Contacts have no wetting. Kept
// between calls: nothing. Weak spot: a pool of N layers presses its first layer into a face by about N g h^2 in each
// substep and is pushed out again.
#include "couple/fluid_skins.h"

#include <algorithm>
#include <cmath>

#include "couple/coupling.h"

namespace feder {
namespace {

// Of a particle between a soft body and a wall: spacings from it, and cosine between the normals.
constexpr Real kLeans = Real(0.6), kOpposite = Real(0.7);
constexpr Real kRests = Real(0.08);  // spacings in a substep, against the body: one that is faster is not held

}  // namespace

FluidSkins& FluidSkins::of(SystemSetup& s, const char* coupling) {
  FluidSkins& f = s.store.need<FluidSkins>(coupling);
  if (f.fluid_) return f;
  f.fluid_ = &system_of<Fluid>(s), f.surfaces_ = &s.store.get<Surfaces>();
  f.solver_bodies_ = &s.store.need<SolverBodies>(coupling);
  f.objects_ = &s.objects, f.contacts_ = &s.store.need<ContactBook>(coupling);
  f.finder_ = f.contacts_->finder(coupling);
  if (f.solver_bodies_->state.empty()) f.solver_bodies_->reset();  // without bodies there is only the world
  return f;
}

void FluidSkins::add_passes(StepPlan& plan, std::string_view owner, const char* coupling, const Names& names) {
  drop_rows();
  particle_bodies_.clear();  // their fluid may be gone, and with it the passes that would list them anew
  std::string_view first;
  std::uint32_t count = 0;
  for (const Surfaces::Owner& o : surfaces_->owners) {
    if (!o.loops || !o.faces || o.count == 0) continue;
    if (first.empty()) first = o.name;
    count += o.count;
  }
  if (fluid_->pool_count() == 0 || first != owner) return;
  contacts_->use();
  using F = FluidSkins;
  if (count > 1) plan.add<&F::connect>(Rank::surface_candidates, names.connect, coupling, this);
  plan.add<&F::begin>(Rank::face_screen, names.screen, coupling, this);
  plan.add<&F::make_rows>(Rank::cloth_particles, names.rows, coupling, this);
  plan.add<&F::read_back>(Rank::cloth_read_back, "read back and project", coupling, this);
}

FluidSkins::Pressed FluidSkins::pressed(ObjectId object) const {
  for (const Pressed& p : pressed_)
    if (p.object == object) return p;
  return {object, 0, 0};
}

// Removes the rows of an earlier substep; those of bodies have a contact state.
void FluidSkins::drop_rows() {
  for (std::size_t k = 0; k < surfaces_->group_count; ++k)
    std::erase_if(surfaces_->groups[k]->rows, [](const SurfaceRow& r) { return r.contact_state == kNone; });
}

// Of the step.
void FluidSkins::list_surfaces() {
  faces_.surfaces.clear(), pressed_.clear();
  std::uint32_t points = 0;
  for (std::uint32_t n = 0; n < surfaces_->list.size(); ++n) {
    const Surface& s = surfaces_->list[n];
    if (!takes(s)) continue;
    faces_.surfaces.push_back({s.object, s.first, s.triangles, s.thickness / 2, s.group, s.mask, n, s.solid});
    pressed_.push_back({s.object, 0, 0});
    points = std::max(points, s.first + s.total);
  }
  faces_.start.resize(points), faces_.end.resize(points);
  std::erase_if(warned, [&](const Expelled& e) { return !objects_->alive(e.object) || !objects_->alive(e.fluid); });
  contact_states_.clear();
  mismatch_ = given_ = 0;
  projected_ = 0;
}

// Surfaces that particles may reach in this step act on each other through them, so they form one group.
void FluidSkins::connect(StepContext& c) {
  std::uint32_t first = kNone;
  for (std::uint32_t n = 0; n < surfaces_->list.size(); ++n) {
    const Surface& s = surfaces_->list[n];
    if (!takes(s)) continue;
    Aabb box;
    for (std::uint32_t i = s.first; i < s.first + s.count; ++i) box.include(surfaces_->position[i]);
    box.grow(s.thickness + c.dt * (s.fastest + 2 * c.dt * length(c.gravity)));
    if (!wet(box, c.dt)) continue;
    if (first < n) surfaces_->connections.push_back({first, n, 0});
    first = std::min(first, n);
  }
}

bool FluidSkins::wet(const Aabb& box, Real seconds) const {
  for (std::size_t n = 0; n < fluid_->pool_count(); ++n) {
    const FluidPool& p = fluid_->pool_at(n);
    Aabb swept = box;
    swept.grow(p.desc.spacing + seconds * p.max_speed());
    for (std::uint32_t i = 0; i < p.count; ++i)
      if (overlaps(swept, Aabb{p.x[i].vec(), p.x[i].vec()})) return true;
  }
  return false;
}

void FluidSkins::begin(StepContext& c) {
  if (c.substep == 0) list_surfaces();
  FEDER_ASSERT(surfaces_->size() >= faces_.start.size());
  for (std::uint32_t i = 0; i < faces_.start.size(); ++i)
    faces_.start[i] = surfaces_->position[i] + surfaces_->delta_position[i].vec();
  faces_.screen(*fluid_, c);
  if (c.substep == 0) expel(c);
}

// Particles that were filled into a soft body, or that tore through its skin where it was crushed, are moved out.
void FluidSkins::expel(StepContext& c) {
  expelled_.clear();
  faces_.expel(*fluid_, c, [&](const FaceContact& k, const FaceHit& way) {
    project_out(k, way, c);
    FluidPool& p = fluid_->pool_at(k.pool);
    p.origin[k.particle].set(way.position);
    const Expelled own{faces_.surfaces[k.surface].object, p.object, 1};
    const auto same = [&](const Expelled& e) { return e.object == own.object && e.fluid == own.fluid; };
    if (const auto at = std::find_if(expelled_.begin(), expelled_.end(), same); at != expelled_.end())
      ++at->count;
    else
      expelled_.push_back(own);
  });
  if (expelled_.empty()) return;
  contact_states_.end_substep();
  for (const Expelled& e : expelled_) {
    const auto same = [&](const Expelled& o) { return o.object == e.object && o.fluid == e.fluid; };
    if (std::any_of(warned.begin(), warned.end(), same)) continue;
    warned.push_back(e);
    c.events->warn("fluid_inside",
                   objects_->describe(e.fluid) + ": " + std::to_string(e.count) + " particles were inside " +
                       objects_->describe(e.object) +
                       " and are moved out: they were filled there, or struck it harder than it can bear; fill beside "
                       "it, or take a larger young",
                   e.fluid);
  }
}

// Whether a contact presses its particle against a solid that fluids do not move: it then gives way no more than that
// does, or the particle would be taken through the skin.
bool FluidSkins::leans(const FluidPool& p, const FaceContact& k) const {
  if (p.touches) return false;  // the contacts are those of the mixture that it was in
  const Boundary& boundary = fluid_->boundary();
  for (const BoundaryContact& w : p.contacts_of(k.particle)) {
    const bool near = w.distance(p.x[k.particle].vec()) < kLeans * p.desc.spacing;
    if (near && dot(w.normal, k.normal) < -kOpposite && !boundary.body_of(w).dynamic) return true;
  }
  return false;
}

void FluidSkins::make_rows(StepContext& c) {
  drop_rows();
  particle_bodies_.clear();
  const std::span<const Row4> velocity = surfaces_->velocity;
  // contacts, with the points predicted by their velocities
  for (std::uint32_t i = 0; i < faces_.start.size(); ++i) faces_.end[i] = faces_.start[i] + c.h * velocity[i].vec();
  faces_.find(*fluid_);
  own_bodies_ = static_cast<std::uint32_t>(solver_bodies_->state.size());
  FEDER_ASSERT(own_bodies_ > 0 && solver_bodies_->mass.size() == own_bodies_);  // the first is the world
  const std::span<const Row4> delta_position = surfaces_->delta_position;
  for (const FaceContact& k : faces_.contacts) {
    const FluidPool& p = fluid_->pool_at(k.pool);
    // the first contact of a particle makes its solver body
    if (particle_bodies_.empty() || particle_bodies_.back().pool != k.pool ||
        particle_bodies_.back().particle != k.particle) {
      FEDER_ASSERT(k.particle < p.count && p.origin.size() > k.particle);
      ParticleBody body;
      body.pool = k.pool, body.particle = k.particle;
      body.solver_index = static_cast<std::uint32_t>(solver_bodies_->state.size());
      body.given = (p.x[k.particle].vec() - p.origin[k.particle].vec()) / c.h;
      SolverBody s;
      s.velocity = body.given;
      SolverMass m;
      Vec3 slip = body.given;  // against the face
      for (int i = 0; i < 3; ++i) slip -= k.weight[i] * velocity[k.vertex[i]].vec();
      const bool rests = length(slip) * c.h < kRests * p.desc.spacing;
      body.held = rests && faces_.surfaces[k.surface].solid && leans(p, k);
      m.inv_mass = body.held ? Real(0) : 1 / p.mass, m.inv_mass_axes = Vec3::Constant(m.inv_mass);
      m.center = p.origin[k.particle].vec();
      solver_bodies_->state.push_back(s), solver_bodies_->mass.push_back(m);
      particle_bodies_.push_back(body);
    }
    // one row per contact, in the group of the surface
    SurfaceRow r;
    Vec3 d = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
      r.vertex[i] = k.vertex[i], r.weight[i] = k.weight[i];
      d += k.weight[i] * delta_position[k.vertex[i]].vec();
    }
    const std::size_t at = faces_.surfaces[k.surface].index;
    const Surface& s = surfaces_->list[at];
    FEDER_ASSERT(r.vertex[0] >= s.first && r.vertex[0] < s.first + s.total);
    r.vertex[3] = k.vertex[0];
    r.normal = -k.normal;
    r.solver_index = particle_bodies_.back().solver_index;
    r.offset = k.distance - k.rest - dot(r.normal, d);
    const std::size_t group = surfaces_->group_of(at);
    r.relaxation = s.relaxation;
    surfaces_->groups[group]->use_body(r.solver_index);
    surfaces_->groups[group]->rows.push_back(r);
  }
}

void FluidSkins::read_back(StepContext& c) {
  const Real g = length(c.gravity);
  std::size_t at = 0;
  pressing_.assign(faces_.contacts.size(), Pressing{});
  next_row_.assign(surfaces_->group_count, 0);
  for (std::size_t n = 0; n < faces_.contacts.size(); ++n) {
    const FaceContact& k = faces_.contacts[n];
    // rows are in the order of the contacts, with those of bodies before or after
    const std::size_t group = surfaces_->group_of(faces_.surfaces[k.surface].index);
    const Array<SurfaceRow>& rows = surfaces_->groups[group]->rows;
    std::uint32_t& next = next_row_[group];
    while (next < rows.size() && rows[next].contact_state != kNone) ++next;
    FEDER_ASSERT(next < rows.size());  // no row, and with it its impulse, is lost
    const SurfaceRow& r = rows[next++];
    while (particle_bodies_[at].solver_index != r.solver_index) {
      ++at;
      FEDER_ASSERT(at < particle_bodies_.size());
    }
    // its impulse: on the particle, on the surface, in the contact state
    const Real net = r.impulse - r.returned;
    particle_bodies_[at].pushed -= net * r.normal;
    FEDER_ASSERT(k.pool == particle_bodies_[at].pool && k.particle == particle_bodies_[at].particle);
    pressing_[n] = {net, -r.normal};
    if (net > 0) record(k, net, r.approach, -r.normal);
    Pressed& to = pressed_[k.surface];
    to.all += std::abs(net);
    if (g > 0) to.along += net * dot(r.normal, c.gravity) / g;
    given_ += static_cast<double>(std::abs(net));
  }
  // particles move as their solver bodies did
  FEDER_ASSERT(solver_bodies_->state.size() == own_bodies_ + particle_bodies_.size());
  for (const ParticleBody& k : particle_bodies_) {
    FluidPool& p = fluid_->pool_at(k.pool);
    const Vec3 gain = solver_bodies_->state[k.solver_index].velocity - k.given;
    if (k.solver_index >= own_bodies_ && !gain.isZero(0)) {
      const Vec3 now = p.origin[k.particle].vec() + surfaces_->body_delta_position[k.solver_index];
      faces_.particle_moved(length(Vec3(now - p.x[k.particle].vec())));
      p.x[k.particle].set(now);
      p.v[k.particle].set(p.v[k.particle].vec() + gain);
    }
    for (int i = 0; i < 3 && !k.held; ++i)
      mismatch_ = std::max(mismatch_, std::abs(static_cast<double>(p.mass * gain[i] - k.pushed[i])));
  }
  solver_bodies_->state.resize(own_bodies_), solver_bodies_->mass.resize(own_bodies_);
  drop_rows();
  for (std::size_t n = 0; n < faces_.contacts.size(); ++n)
    rub(faces_.contacts[n], faces_.contacts[n].weight, pressing_[n].normal, pressing_[n].impulse);
  // non-penetration projection against the faces where they are now
  const auto now = [&](std::uint32_t i) { return Vec3(surfaces_->position[i] + surfaces_->delta_position[i].vec()); };
  faces_.follow(*fluid_, now);
  faces_.project(*fluid_, [&](const FaceContact& k, const FaceHit& hit) { project_out(k, hit, c); });
  contact_states_.end_substep();
}

// Projection of a particle that passed a face, or is too near to it: back to where it met the face, and the closing
// velocity becomes zero, by an impulse on both sides.
void FluidSkins::project_out(const FaceContact& k, const FaceHit& hit, StepContext& c) {
  FluidPool& p = fluid_->pool_at(k.pool);
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
  Pressed& to = pressed_[k.surface];
  to.all += length(impulse);
  if (length(c.gravity) > 0) to.along -= dot(impulse, c.gravity) / length(c.gravity);
}

// Friction of a contact that pressed with that impulse, N s.
void FluidSkins::rub(const FaceContact& k, const Real (&weight)[3], const Vec3& normal, Real pressing) {
  FluidPool& p = fluid_->pool_at(k.pool);
  if (!(pressing > 0) || !(p.desc.friction > 0)) return;
  Real response;
  const Vec3 u = slip(k, weight, response);
  exchange(k, weight, friction_impulse(u - dot(u, normal) * normal, response, p.desc.friction * pressing));
}

// Velocity of a particle against the point of the face with these weights, and the change of it by an impulse, 1/kg.
Vec3 FluidSkins::slip(const FaceContact& k, const Real (&weight)[3], Real& response) const {
  const FluidPool& p = fluid_->pool_at(k.pool);
  Vec3 u = p.v[k.particle].vec();
  response = 1 / p.mass;
  for (int i = 0; i < 3; ++i) {
    u -= weight[i] * surfaces_->velocity[k.vertex[i]].vec();
    response += weight[i] * weight[i] * surfaces_->delta_position[k.vertex[i]].w;
  }
  return u;
}

// An impulse on the particle, and its opposite on the face.
void FluidSkins::exchange(const FaceContact& k, const Real (&weight)[3], const Vec3& impulse) {
  FluidPool& p = fluid_->pool_at(k.pool);
  p.v[k.particle].set(p.v[k.particle].vec() + impulse / p.mass);
  for (int i = 0; i < 3; ++i)
    surfaces_->velocity[k.vertex[i]].add(surfaces_->delta_position[k.vertex[i]].w * Vec3(-weight[i] * impulse));
}

void FluidSkins::record(const FaceContact& k, Real impulse, Real speed, const Vec3& normal) {
  const FluidPool& p = fluid_->pool_at(k.pool);
  contact_states_.record(faces_.surfaces[k.surface].object, p.object, k.particle, p.x[k.particle].vec(), impulse, speed,
                         normal);
}

// The contacts of the step; of several calls the first does it.
void FluidSkins::report() { contact_states_.report(*contacts_, finder_, *objects_); }

void FluidSkins::validate() const {
  FEDER_ASSERT(contact_states_.empty());  // reported
  for (std::size_t k = 0; k < surfaces_->group_count; ++k)
    for (const SurfaceRow& r : surfaces_->groups[k]->rows)
      FEDER_ASSERT(r.contact_state != kNone);  // rows of particles live within a substep
  for (std::size_t k = 0; k < particle_bodies_.size(); ++k)
    FEDER_ASSERT(particle_bodies_[k].solver_index == own_bodies_ + k &&
                 particle_bodies_[k].pool < fluid_->pool_count());
  FEDER_ASSERT(pressed_.size() == faces_.surfaces.size());
  faces_.validate();
}

}  // namespace feder
