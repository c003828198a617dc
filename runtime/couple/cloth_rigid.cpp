// Per step: approach speeds of bodies before it, attachments as rows of the group within it, masses that rest on a
// cloth or hang from it after it; residuals from the state itself. Kept between steps: nothing.
#include "couple/cloth_rigid.h"

#include <algorithm>

#include "couple/coupling.h"
#include "couple/surface_triangle.h"
#include "narrow/narrow_phase.h"
#include "state/cloth_vertices.h"

namespace feder {
const SystemDescriptor& ClothRigid::descriptor() {
  return coupling_descriptor<ClothRigid, Cloth, Rigid>("attachments");
}

ClothRigid::ClothRigid(SystemSetup& s)
    : cloth_(system_of<Cloth>(s)), surfaces_(s.store.get<Surfaces>()), rigid_(system_of<Rigid>(s)),
      collide_(system_of<Collide>(s)), colliders_(collide_.colliders()),
      solver_bodies_(s.store.need<SolverBodies>(Rigid::kName)), objects_(s.objects),
      structure_changed_(s.structure_changed), near_(&s.store.arena(kName)) {}

void ClothRigid::add_passes(StepPlan& plan) {
  sync();
  if (cloth_.cloth_count() == 0 || rigid_.count() == 0) return;
  using S = ClothRigid;
  plan.add<&S::find_approach>(Rank::cloth_approach, "approach speeds", kName, this);
  if (!cloth_.attachments().empty())
    plan.add<&S::make_attachments>(Rank::cloth_attachments, "attachments", kName, this);
  plan.add<&S::weigh>(Rank::keep_awake, "loads", kName, this);
}

std::size_t ClothRigid::count() const { return cloth_.attachments().size(); }

// Attachments to bodies that are gone end.
void ClothRigid::sync() {
  std::vector<ObjectId> gone;
  for (const Cloth::Attachment& a : cloth_.attachments())
    if (!objects_.alive(a.body)) gone.push_back(a.body);
  for (const ObjectId body : gone) cloth_.detach_body(body);
}

bool ClothRigid::attached(std::uint32_t vertex, ObjectId body) const {
  for (const Cloth::Attachment& a : cloth_.attachments())
    if (a.vertex == vertex && a.body == body) return true;
  return false;
}

Real ClothRigid::attachments_of(ObjectId body, ObjectId cloth) const {
  Real count = 0;
  for (const Cloth::Attachment& a : cloth_.attachments()) count += a.body == body && a.cloth == cloth;
  return count;
}

// A body that could pass through a sleeper within one step wakes it before the contact.
void ClothRigid::wake_approached(const Cloth::Info& cloth, StepContext& c) {
  if (c.dt * fastest_ <= cloth.thickness) return;
  Aabb all;
  for (std::uint32_t i = cloth.first; i < cloth.first + cloth.count; ++i) all.include(cloth_.vertices().position[i]);
  all.grow(cloth.thickness);
  list_near(all, c);
  for (const std::uint32_t k : near_) {
    if (!colliders_.meets(k, cloth.group, cloth.mask) || colliders_.motion[k] == ColliderMotion::fixed ||
        !colliders_.awake[k] || c.dt * length(colliders_.velocity[k]) <= cloth.thickness)
      continue;
    if (!overlaps(all, colliders_.swept(k, c.dt))) continue;
    return cloth_.wake(cloth.object, WakeCause::contact, colliders_.object[k]);
  }
}

// Colliders whose swept boxes may overlap the box in this step.
void ClothRigid::list_near(Aabb box, StepContext& c) {
  box.grow(c.dt * fastest_);
  collide_.near(box, near_);
}

// Impact: an approaching body has to be stopped within a quarter of the cloth's size, from the first contact; that
// deceleration, and the approach speed, set the number of solver substeps.
void ClothRigid::find_approach(StepContext& c) {
  const ClothVertices& v = cloth_.vertices();
  const Bodies& b = rigid_.bodies();
  fastest_ = colliders_.fastest();
  for (std::size_t n = 0; n < cloth_.cloth_count(); ++n) {
    if (cloth_.info(n).asleep) wake_approached(cloth_.info(n), c);
    const Cloth::Info info = cloth_.info(n);
    if (info.asleep) continue;
    // bounds swept over the step, mean velocity
    Aabb all, now;
    Vec3 mean = Vec3::Zero();
    Real mass = 0;
    for (std::uint32_t i = info.first; i < info.first + info.count; ++i) {
      now.include(v.position[i]);
      all.include(Vec3(v.position[i] + c.dt * v.velocity[i]));
      mean += v.mass[i] * v.velocity[i], mass += v.mass[i];
    }
    all.include(now);
    all.grow(info.thickness);
    const Real size = (now.hi - now.lo).maxCoeff();
    // largest deceleration and speed over the bodies on collision course
    Real impact = 0, speed = 0;
    list_near(all, c);
    for (const std::uint32_t k : near_) {
      if (!colliders_.meets(k, info.group, info.mask) || !overlaps(all, colliders_.swept(k, c.dt))) continue;
      cloth_.set_beside_body(n);
      if (colliders_.motion[k] == ColliderMotion::fixed || !colliders_.awake[k]) continue;
      const std::uint32_t body = colliders_.owner_index[k];
      const Real share = b.type[body] == BodyType::dynamic ? std::min(b.mass[body] / mass, Cloth::kMaxLoad) : Real(1);
      const Vec3 u = colliders_.velocity[k] - mean / mass;
      impact = std::max(impact, 2 * dot(u, u) / size * share);
      speed = std::max(speed, length(u));
    }
    cloth_.set_impact(n, impact, speed);
  }
}

void ClothRigid::make_attachments(StepContext&) {
  const Bodies& b = rigid_.bodies();
  for (const Cloth::Attachment& a : cloth_.attachments()) {
    if (!objects_.alive(a.body)) {
      *structure_changed_ = true;  // the next sync drops it
      continue;
    }
    const std::uint32_t body = rigid_.index(a.body);
    FEDER_ASSERT(cloth_.vertices().cloth[a.vertex] == a.cloth && b.object[body] == a.body);
    SurfaceAttachment k;
    k.vertex = a.vertex;
    k.solver_index = solver_bodies_.index[b.solver_slot[body]];
    FEDER_ASSERT(k.solver_index < solver_bodies_.state.size());
    const Vec3 local = a.local - b.local_com[body];
    const Vec3 center =
        k.solver_index
            ? Vec3(solver_bodies_.mass[k.solver_index].center + solver_bodies_.state[k.solver_index].delta_position)
            : b.position[body];
    k.arm = rotate(k.solver_index ? solver_bodies_.state[k.solver_index].rotation : b.rotation[body], local);
    k.error = cloth_.vertices().position[a.vertex] - center - k.arm;
    const std::size_t group = surfaces_.group_of(objects_.index(a.cloth));
    surfaces_.groups[group]->use_body(k.solver_index);
    surfaces_.groups[group]->attachments.push_back(k);
  }
}

// Load: the mass of the bodies that rest on each cloth or hang from it.
void ClothRigid::weigh(StepContext&) {
  const Bodies& b = rigid_.bodies();
  for (std::size_t n = 0; n < cloth_.cloth_count(); ++n) {
    const Cloth::Info info = cloth_.info(n);
    if (info.asleep) continue;
    Real load = 0, own = 0, hung = 0;
    for (std::uint32_t i = info.first; i < info.first + info.count; ++i) own += cloth_.vertices().mass[i];
    for (const Surfaces::Carried& k : surfaces_.carried) {
      if (k.surface != info.object || !objects_.alive(k.body)) continue;
      const std::uint32_t body = rigid_.index(k.body);
      if (k.support > Real(0.1) * k.impulse && b.type[body] == BodyType::dynamic) load += b.mass[body];
    }
    for (const Cloth::Attachment& a : cloth_.attachments()) {
      if (a.cloth != info.object || !objects_.alive(a.body)) continue;
      const std::uint32_t body = rigid_.index(a.body);
      if (b.type[body] != BodyType::dynamic) continue;
      // shared between the vertices that one body hangs from
      hung += b.mass[body] / attachments_of(a.body, a.cloth);
      if (info.moving && !b.awake[body]) rigid_.wake(a.body, kClothCause, a.cloth);
    }
    cloth_.set_load(n, std::min(load, Cloth::kMaxLoad * own) + hung);
  }
}

// Penetration depth of a cloth, half its thickness included, into a collider: from distances of vertices, and from the
// narrow phase for triangles, where a body penetrates between vertices.
Real ClothRigid::penetration(const Cloth::Info& cloth, std::uint32_t k, const Pose& pose) const {
  const ClothVertices& v = cloth_.vertices();
  const Shape& shape = *colliders_.shape[k];
  const Real radius = Real(0.5) * cloth.thickness;
  const ObjectId body = colliders_.object[k];
  Aabb box = shape.bounds(pose);
  box.grow(radius);
  Real deepest = 0;
  Vec3 normal;
  for (std::uint32_t i = cloth.first; i < cloth.first + cloth.count; ++i)
    if (overlaps(box, Aabb{v.position[i], v.position[i]}) && !attached(i, body))
      deepest = std::max(deepest, radius - shape.distance(to_local(pose, v.position[i]), radius, normal));
  for (std::size_t t = 0; t + 2 < cloth.triangles.size(); t += 3) {
    const std::uint32_t at[3] = {cloth.first + cloth.triangles[t], cloth.first + cloth.triangles[t + 1],
                                 cloth.first + cloth.triangles[t + 2]};
    const Vec3 a = v.position[at[0]];
    const SurfaceTriangle triangle(v.position[at[1]] - a, v.position[at[2]] - a, radius);
    if (!overlaps(box, triangle.bounds({a, Quat{}})) || attached(at[0], body) || attached(at[1], body) ||
        attached(at[2], body))
      continue;
    Manifold m[kMaxManifolds];
    PairCache cache;
    const int count = collide_.narrow().collide(triangle, {a, Quat{}}, shape, pose, 0, cache, m);
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < m[i].count; ++j) deepest = std::max(deepest, -m[i].points[j].separation);
  }
  return deepest;
}

// From the positions alone, independent of the rows of the last substep.
void ClothRigid::residuals(std::vector<Residual>& out) const {
  const Bodies& b = rigid_.bodies();
  double worst = 0;
  for (const Cloth::Attachment& a : cloth_.attachments()) {
    if (!objects_.alive(a.body)) continue;
    const Vec3 anchor = to_world(b.origin_pose(rigid_.index(a.body)), a.local);
    worst = std::max(worst, static_cast<double>(length(cloth_.vertices().position[a.vertex] - anchor)));
  }
  if (!cloth_.attachments().empty()) out.push_back({"cloth_rigid.attachment_error_m", worst});
  Real deepest = 0;
  for (std::size_t n = 0; n < cloth_.cloth_count(); ++n) {
    const Cloth::Info info = cloth_.info(n);
    for (std::uint32_t k = 0; k < colliders_.size(); ++k)
      if (colliders_.meets(k, info.group, info.mask))
        deepest = std::max(deepest, penetration(info, k, b.com_pose(colliders_.owner_index[k]) * colliders_.local[k]));
  }
  out.push_back({"cloth_rigid.penetration_m", static_cast<double>(deepest)});
}

}  // namespace feder
