// Structure of the coupling, candidates of a step, attachments, and what is asked and told. The contact rows are made
// in cloth_rigid_rows.cpp.
// Kept between steps: which cloth touches which body, for the events, and which pins were warned of.
#include "couple/cloth_rigid.h"

#include <algorithm>
#include <cstdio>

#include "couple/cloth_triangle.h"

namespace feder {
namespace {

constexpr Real kReach = Real(1.6);    // thicknesses about the way of a vertex: rows are made up to 1.5 of them away
constexpr Real kSupport = Real(0.3);  // cosine to gravity, from which on a contact carries
constexpr Real kInside = Real(0.1);   // thicknesses: pins less deep inside a shape lie on its surface

}  // namespace

const SystemDescriptor& ClothRigid::descriptor() {
  static const char* const joins[] = {Cloth::kName, Rigid::kName};
  static const SystemDescriptor d = {kName, {}, joins, [](SystemSetup& setup) -> std::unique_ptr<System> {
                                       return std::make_unique<ClothRigid>(setup);
                                     }};
  return d;
}

ClothRigid::ClothRigid(SystemSetup& s)
    : cloth_(static_cast<Cloth&>(*s.systems.find_system(Cloth::kName))), surfaces_(s.store.get<Surfaces>()),
      rigid_(static_cast<Rigid&>(*s.systems.find_system(Rigid::kName))),
      collide_(static_cast<Collide&>(*s.systems.find_system(Collide::kName))), colliders_(collide_.colliders()),
      movers_(s.store.need<Movers>(Rigid::kName)), objects_(s.objects), events_(s.events),
      structure_changed_(s.structure_changed), candidates_(&s.store.arena(kName)), touches_(&s.store.arena(kName)),
      box_(&s.store.arena(kName)), smallest_(&s.store.arena(kName)), pin_depth_(&s.store.arena(kName)),
      deep_pins_(&s.store.arena(kName)), hurry_(&s.store.arena(kName)), warned_(&s.store.arena(kName)) {}

void ClothRigid::add_passes(StepPlan& plan) {
  sync();
  if (cloth_.cloth_count() == 0 || rigid_.count() == 0) return;
  using S = ClothRigid;
  plan.add<&S::look_ahead>(Rank::cloth_approach, "look ahead", kName, this);
  plan.add<&S::find_candidates>(Rank::cloth_candidates, "find candidates", kName, this);
  plan.add<&S::make_rows>(Rank::cloth_contact, "contacts", kName, this);
  plan.add<&S::refresh_rows>(Rank::cloth_refresh, "refresh contacts", kName, this);
  plan.add<&S::collect>(Rank::cloth_collect, "collect", kName, this);
  plan.add<&S::finish>(Rank::keep_awake, "touches", kName, this);
}

std::size_t ClothRigid::count() const { return touches_.size(); }

// Attachments to bodies that are gone end.
void ClothRigid::sync() {
  std::vector<ObjectId> gone;
  for (const Cloth::Attachment& a : cloth_.attachments())
    if (!objects_.alive(a.body)) gone.push_back(a.body);
  for (const ObjectId body : gone) cloth_.detach_body(body);
  end_contacts();
  candidates_.clear();  // what they name may be gone: without rows of this coupling in the plan nobody renews them
  hurry_.clear();
  vertex_shapes_.clear();
  for (std::size_t n = 0; n < cloth_.cloth_count(); ++n)
    vertex_shapes_.push_back(make_sphere(Real(0.5) * cloth_.info(n).thickness));
  surfaces_.clear_rows();
}

// Contacts with what is gone end; a cloth that lay on it wakes.
void ClothRigid::end_contacts() {
  for (const Touch& t : touches_) {
    if (objects_.alive(t.body) && objects_.alive(t.cloth)) continue;
    if (objects_.alive(t.cloth)) cloth_.wake(t.cloth, WakeCause::destroyed, t.body);
    open_.count(EventKind::contact_end);
    Event e;
    e.kind = EventKind::contact_end;
    e.a = t.cloth, e.b = t.body, e.index = t.index, e.point = t.point, e.normal = t.normal;
    events_.add_pending(e);
  }
  std::erase_if(touches_, [&](const Touch& t) { return !objects_.alive(t.body) || !objects_.alive(t.cloth); });
  std::erase_if(warned_, [&](const Warned& w) { return !objects_.alive(w.body) || !objects_.alive(w.cloth); });
}

ClothRigid::Place ClothRigid::place(std::uint32_t k) const {
  Place p;
  const Bodies& b = rigid_.bodies();
  const std::uint32_t body = colliders_.owner_index[k];
  FEDER_ASSERT(colliders_.owner[k] == ObjectKind::body && b.object[body] == colliders_.object[k]);
  p.solver = movers_.solver[b.mover[body]];
  if (p.solver == 0) {
    p.center = b.position[body];
    p.pose = b.com_pose(body) * colliders_.local[k];
    return p;
  }
  FEDER_ASSERT(p.solver < movers_.state.size() && p.solver < movers_.mass.size());
  const MoverState& s = movers_.state[p.solver];
  p.center = movers_.mass[p.solver].center + s.moved;
  p.velocity = s.velocity, p.spin = s.angular_velocity;
  Quat rotation = s.rotation;
  if (refreshing()) {
    p.center += surfaces_.mover_shift[p.solver];
    rotation = integrate_rotation(rotation, surfaces_.mover_turn[p.solver]);
  }
  p.pose = Pose{p.center, rotation} * colliders_.local[k];
  return p;
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

std::uint32_t ClothRigid::touch_of(ObjectId cloth, ObjectId body) {
  for (std::uint32_t k = 0; k < touches_.size(); ++k)
    if (touches_[k].cloth == cloth && touches_[k].body == body) return k;
  FEDER_ASSERT(objects_.kind(cloth) == ObjectKind::cloth && objects_.kind(body) == ObjectKind::body);
  Touch t;
  t.cloth = cloth, t.body = body;
  touches_.push_back(t);
  return static_cast<std::uint32_t>(touches_.size() - 1);
}

// Where a collider may be in this step: boxes of collide may look less far ahead than the body comes.
Aabb ClothRigid::reach_of(std::uint32_t k, StepContext& c) const {
  Aabb box = colliders_.box[k];
  if (colliders_.motion[k] == ColliderMotion::fixed) return box;
  const Vec3 ahead = c.dt * colliders_.velocity[k];
  Aabb end = box;
  end.lo += ahead, end.hi += ahead;
  box.include(end);
  return box;
}

// What would pass through a sleeper between two looks wakes it before it strikes.
void ClothRigid::wake_ahead(const Cloth::Info& cloth, StepContext& c) {
  Aabb all;
  bool boxed = false;
  for (std::uint32_t k = 0; k < colliders_.size(); ++k) {
    if (!may_touch(cloth, k) || colliders_.motion[k] == ColliderMotion::fixed || !colliders_.awake[k] ||
        c.dt * length(colliders_.velocity[k]) <= cloth.thickness)
      continue;
    for (std::uint32_t i = cloth.first; !boxed && i < cloth.first + cloth.count; ++i)
      all.include(cloth_.vertices().position[i]);
    if (!boxed) all.grow(cloth.thickness);
    boxed = true;
    if (overlaps(all, reach_of(k, c))) return cloth_.wake(cloth.object, WakeCause::contact, colliders_.object[k]);
  }
}

// What comes at a cloth has to be stopped within a quarter of its size: that takes small steps, from the first touch.
void ClothRigid::look_ahead(StepContext& c) {
  end_contacts();  // a body may go without a new plan
  const ClothVertices& v = cloth_.vertices();
  const Bodies& b = rigid_.bodies();
  for (std::size_t n = 0; n < cloth_.cloth_count(); ++n) {
    if (cloth_.info(n).asleep) wake_ahead(cloth_.info(n), c);
    const Cloth::Info info = cloth_.info(n);
    if (info.asleep) continue;
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
    Real impact = 0, speed = 0;
    for (std::uint32_t k = 0; k < colliders_.size(); ++k) {
      if (colliders_.motion[k] == ColliderMotion::none || colliders_.motion[k] == ColliderMotion::fixed ||
          colliders_.sensor[k] || colliders_.owner[k] != ObjectKind::body || !colliders_.awake[k] ||
          !overlaps(all, reach_of(k, c)))
        continue;
      const std::uint32_t body = colliders_.owner_index[k];
      const Real share = b.type[body] == BodyType::dynamic ? std::min(b.mass[body] / mass, Cloth::kMostLoad) : Real(1);
      const Vec3 u = colliders_.velocity[k] - mean / mass;
      impact = std::max(impact, 2 * dot(u, u) / size * share);
      speed = std::max(speed, length(u));
    }
    cloth_.set_impact(n, impact, speed);
  }
}

void ClothRigid::find_candidates(StepContext& c) {
  candidates_.clear();
  for (Touch& t : touches_) t.seen = 0, t.impulse = t.support = t.speed = t.slip = t.strongest = 0;
  const ClothVertices& v = cloth_.vertices();
  if (surfaces_.moved.size() < v.size()) return;
  FEDER_ASSERT(vertex_shapes_.size() == cloth_.cloth_count());
  smallest_.resize(colliders_.size());
  box_.resize(v.size());
  for (std::size_t n = 0; n < cloth_.cloth_count(); ++n) candidates_of(n, c);
  for (const Cloth::Attachment& a : cloth_.attachments())
    if (objects_.alive(a.body)) connect(objects_.index(a.cloth), rigid_.index(a.body));
}

// What a dynamic body gets from one cloth reaches the others that act on it within a substep.
void ClothRigid::connect(std::size_t cloth, std::uint32_t body) {
  const Bodies& b = rigid_.bodies();
  const std::uint32_t solver = movers_.solver[b.mover[body]];
  if (b.type[body] == BodyType::dynamic && solver != 0) 
    surfaces_.connections.push_back({static_cast<std::uint32_t>(cloth), 0, solver});
}

// A pin inside a shape asks for what cannot be. Said once for a cloth and a body, with the deepest pin.
void ClothRigid::warn_of_pins(const Cloth::Info& cloth, std::uint32_t k, StepContext& c) {
  const ClothVertices& v = cloth_.vertices();
  const ObjectId body = colliders_.object[k];
  for (const Warned& w : warned_)
    if (w.cloth == cloth.object && w.body == body) return;
  Real deepest = 0;
  int count = 0;
  std::uint32_t vertex = 0;
  for (std::uint32_t i = cloth.first; i < cloth.first + cloth.count; ++i) {
    if (v.inv_mass[i] != 0 || !overlaps(box_[i], colliders_.box[k]) || attached(i, body)) continue;
    Vec3 normal;
    const Real depth =
        -colliders_.shape[k]->distance(to_local(colliders_.pose[k], v.position[i]), cloth.thickness, normal);
    count += depth > kInside * cloth.thickness;
    if (depth > deepest) deepest = depth, vertex = i - cloth.first;
  }
  if (count == 0) return;
  warned_.push_back({cloth.object, body});
  char millimetres[32];
  std::snprintf(millimetres, sizeof millimetres, "%.3g mm", static_cast<double>(1000 * deepest));
  const std::string others = count > 1 ? " (the deepest of " + std::to_string(count) + ")" : "";
  c.events->warn("pinned_inside",
                 objects_.describe(cloth.object) + " vertex " + std::to_string(vertex + 1) + others + " is pinned " +
                     millimetres + " inside " + objects_.describe(body) +
                     ", which cannot push it out: pin it outside, attach it to the body, or let the two not collide",
                 cloth.object);
}

bool ClothRigid::may_touch(const Cloth::Info& cloth, std::uint32_t k) const {
  return colliders_.motion[k] != ColliderMotion::none && !colliders_.sensor[k] &&
         colliders_.owner[k] == ObjectKind::body && (colliders_.group[k] & cloth.mask) != 0 &&
         (cloth.group & colliders_.mask[k]) != 0;
}

void ClothRigid::candidates_of(std::size_t n, StepContext& c) {
  const Cloth::Info info = cloth_.info(n);
  const ClothVertices& v = cloth_.vertices();
  const Vec3 fall = c.gravity * (c.dt * c.dt);
  Aabb all;
  for (std::uint32_t i = info.first; i < info.first + info.count; ++i) {
    const Vec3 x = v.position[i], u = surfaces_.speed[i].vec();
    Aabb& b = box_[i];
    const Vec3 far = info.asleep || v.inv_mass[i] == 0 ? x : Vec3(x + c.dt * u + fall);
    b.lo = x.cwiseMin(far), b.hi = x.cwiseMax(far);
    b.grow(kReach * info.thickness);
    all.include(b);
  }
  for (std::uint32_t k = 0; k < colliders_.size(); ++k) {
    if (!may_touch(info, k)) continue;
    // a fast body draws cloth in from beside its path
    Aabb box = reach_of(k, c);
    if (colliders_.motion[k] != ColliderMotion::fixed) box.grow(Real(0.3) * c.dt * length(colliders_.velocity[k]));
    if (!overlaps(all, box)) continue;
    const bool body_moves = colliders_.awake[k] && colliders_.motion[k] != ColliderMotion::fixed;
    if (info.asleep && !body_moves) continue;
    connect(n, colliders_.owner_index[k]);
    const Shape& shape = *colliders_.shape[k];
    const Aabb own = shape.bounds(Pose{});
    const Vec3 half = Real(0.5) * (own.hi - own.lo);
    smallest_[k] = shape.convex() ? half.minCoeff() : Real(0);
    FEDER_ASSERT(!(smallest_[k] < 0));
    if (!info.asleep && colliders_.motion[k] != ColliderMotion::dynamic) warn_of_pins(info, k, c);
    const ObjectId body = colliders_.object[k];
    const std::uint32_t place = static_cast<std::uint32_t>(n);
    for (std::uint32_t i = info.first; i < info.first + info.count; ++i)
      if (overlaps(box_[i], box) && !attached(i, body)) candidates_.push_back({place, k, i, 0});
    if (info.asleep) continue;
    for (std::uint32_t t = 0; t < info.triangles.size() / 3; ++t) {
      const std::uint32_t* q = &info.triangles[3 * t];
      Aabb b = box_[info.first + q[0]];
      b.include(box_[info.first + q[1]]), b.include(box_[info.first + q[2]]);
      if (!overlaps(b, box)) continue;
      if (attached(info.first + q[0], body) || attached(info.first + q[1], body) || attached(info.first + q[2], body))
        continue;
      candidates_.push_back({place, k, t, 1});
    }
  }
}

void ClothRigid::make_holds() {
  const Bodies& b = rigid_.bodies();
  for (const Cloth::Attachment& a : cloth_.attachments()) {
    if (!objects_.alive(a.body)) {
      *structure_changed_ = true;  // the next sync drops it
      continue;
    }
    const std::uint32_t body = rigid_.index(a.body);
    FEDER_ASSERT(cloth_.vertices().cloth[a.vertex] == a.cloth && b.object[body] == a.body);
    SurfaceHold k;
    k.vertex = a.vertex;
    k.mover = movers_.solver[b.mover[body]];
    FEDER_ASSERT(k.mover < movers_.state.size());
    const Vec3 local = a.local - b.local_com[body];
    const Vec3 center = k.mover ? Vec3(movers_.mass[k.mover].center + movers_.state[k.mover].moved) : b.position[body];
    k.arm = rotate(k.mover ? movers_.state[k.mover].rotation : b.rotation[body], local);
    k.error = cloth_.vertices().position[a.vertex] - center - k.arm;
    const std::size_t group = surfaces_.group_of(objects_.index(a.cloth));
    surfaces_.groups[group]->use_mover(k.mover);
    surfaces_.groups[group]->holds.push_back(k);
  }
}

// What the rows of this substep did.
void ClothRigid::collect(StepContext& c) {
  for (std::size_t k = 0; k < surfaces_.group_count; ++k) collect_group(k, c);
}

void ClothRigid::collect_group(std::size_t group, StepContext& c) {
  const Real g = length(c.gravity);
  for (const SurfaceRow& r : surfaces_.groups[group]->rows) {
    if (r.touch == kNone) continue;
    FEDER_ASSERT(r.touch < touches_.size());
    Touch& t = touches_[r.touch];
    if (!(r.impulse > 0)) continue;
    t.seen = 1;
    t.impulse += r.impulse;
    if (g > 0 && dot(r.normal, c.gravity) > kSupport * g) t.support += r.impulse;
    t.speed = std::max(t.speed, r.approach);
    if (r.impulse <= t.strongest) continue;
    t.strongest = r.impulse;
    int heaviest = 0;
    for (int k = 1; k < 3; ++k)
      if (r.weight[k] > r.weight[heaviest]) heaviest = k;
    FEDER_ASSERT(cloth_.vertices().cloth[r.vertex[heaviest]] == t.cloth);
    t.index = r.vertex[heaviest] - cloth_.info(objects_.index(t.cloth)).first;
    t.point = vertex_place(r.vertex[heaviest]);
    t.normal = -r.normal;
    Vec3 u = Vec3::Zero();
    for (int k = 0; k < 3; ++k) u += r.weight[k] * surfaces_.speed[r.vertex[k]].vec();
    if (r.mover) u -= movers_.state[r.mover].velocity + cross(movers_.state[r.mover].angular_velocity, r.arm);
    t.slip = length(Vec3(u - dot(u, r.normal) * r.normal));
  }
}

void ClothRigid::finish(StepContext& c) {
  const Bodies& b = rigid_.bodies();
  const auto event = [&](EventKind kind, const Touch& t) {
    open_.count(kind);
    Event e;
    e.kind = kind;
    e.a = t.cloth, e.b = t.body;
    e.index = t.index;
    e.point = t.point, e.normal = t.normal;
    e.impulse = t.impulse, e.speed = t.speed, e.slip = t.slip;
    return e;
  };
  for (std::size_t n = 0; n < cloth_.cloth_count(); ++n) {
    const Cloth::Info info = cloth_.info(n);
    if (info.asleep) continue;
    Real load = 0, own = 0, hung = 0;
    for (std::uint32_t i = info.first; i < info.first + info.count; ++i) own += cloth_.vertices().mass[i];
    for (const Touch& t : touches_) {
      if (t.cloth != info.object || !t.seen || !objects_.alive(t.body)) continue;
      FEDER_ASSERT(!(t.support > Real(1.001) * t.impulse));  // a part of it
      const std::uint32_t body = rigid_.index(t.body);
      if (t.support > Real(0.1) * t.impulse && b.type[body] == BodyType::dynamic) load += b.mass[body];
      if (info.moving && b.type[body] == BodyType::dynamic && !b.awake[body])
        rigid_.wake(t.body, WakeCause::cloth, t.cloth);
    }
    for (const Cloth::Attachment& a : cloth_.attachments()) {
      if (a.cloth != info.object || !objects_.alive(a.body)) continue;
      const std::uint32_t body = rigid_.index(a.body);
      if (b.type[body] != BodyType::dynamic) continue;
      // by vertex: one body hangs on many
      hung += b.mass[body] / attachments_of(a.body, a.cloth);
      if (info.moving && !b.awake[body]) rigid_.wake(a.body, WakeCause::cloth, a.cloth);
    }
    cloth_.set_load(n, std::min(load, Cloth::kMostLoad * own) + hung);
  }
  // begin, stay and end, in the order of the objects
  std::sort(touches_.begin(), touches_.end(),
            [](const Touch& x, const Touch& y) { return x.cloth != y.cloth ? x.cloth < y.cloth : x.body < y.body; });
  for (Touch& t : touches_) {
    if (cloth_.asleep(t.cloth) && t.begun) {
      t.seen = 1;
      continue;
    }
    if (t.seen && !t.begun) {
      c.events->add(event(EventKind::contact_begin, t));
      if (c.events->wanted(EventKind::hit)) c.events->add(event(EventKind::hit, t));
    } else if (t.seen && c.events->wanted(EventKind::contact_stay)) {
      c.events->add(event(EventKind::contact_stay, t));
    }
    if (!t.seen && t.begun) c.events->add(event(EventKind::contact_end, t));
    t.begun = t.seen;
  }
  std::erase_if(touches_, [](const Touch& t) { return !t.begun; });
  surfaces_.clear_rows();
}

void ClothRigid::hash(Hash& h) const {
  for (const Touch& t : touches_) h.add(t.cloth.slot), h.add(t.body.slot);
}

void ClothRigid::save(Writer& w) const { w.list(touches_), w.list(warned_); }

void ClothRigid::load(Reader& r) {
  r.list(touches_), r.list(warned_);
  open_.set(touches_.size());
  candidates_.clear();
  hurry_.clear();
  surfaces_.clear_rows();
}

// How deep the cloth, half its thickness included, is in a collider: by the distances of vertices, and where something
// pokes between them by the narrow phase.
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
    const ClothTriangle triangle(v.position[at[1]] - a, v.position[at[2]] - a, radius);
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

// Of the state as it is, so that it holds whatever the rows of the last substep knew.
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
      if (may_touch(info, k))
        deepest = std::max(deepest, penetration(info, k, b.com_pose(colliders_.owner_index[k]) * colliders_.local[k]));
  }
  out.push_back({"cloth_rigid.penetration_m", static_cast<double>(deepest)});
}

void ClothRigid::validate() const {
  validate_records<Touch>({touches_.data(), touches_.size()}, &Touch::cloth, ObjectKind::cloth, &Touch::body,
                          ObjectKind::body, objects_, open_);
  for (const Touch& t : touches_) FEDER_ASSERT(t.begun == 1 && t.seen == 1);
  for (const Warned& w : warned_) FEDER_ASSERT(objects_.alive(w.cloth) && objects_.alive(w.body));
  for (std::size_t k = 0; k < surfaces_.group_count; ++k)
    for (const SurfaceRow& r : surfaces_.groups[k]->rows) FEDER_ASSERT(r.touch == kNone);  // they live in a substep
  FEDER_ASSERT(vertex_shapes_.size() == cloth_.cloth_count() && !refreshing());
}

}  // namespace feder
