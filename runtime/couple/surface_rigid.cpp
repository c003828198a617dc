// Structure of the coupling, candidates of a step, and reports to the contact book. The contact rows are made in
// surface_rigid_rows.cpp. Kept between steps: the pairs of which a warning of pins was sent.
#include "couple/surface_rigid.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "contact/body_point.h"
#include "contact/seen_pairs.h"
#include "contact/surface_contact.h"
#include "couple/coupling.h"
#include "couple/surface_triangle.h"

namespace feder {
namespace {

constexpr Real kMargin = Real(1.6);  // thicknesses round the path of a point: rows are made up to 1.5 of them away
constexpr Real kMarginCoasting = Real(0.75);  // the same for surfaces that coast
constexpr Real kAside = Real(0.3);    // of its displacement in a step: a fast body draws cloth in from beside its path
constexpr Real kSupport = Real(0.3);  // least cosine to gravity of a contact that carries
constexpr Real kStill = Real(0.01);   // m/s: a body that moves faster wakes what is attached to it
constexpr Real kInside = Real(0.1);   // thicknesses: pins less deep inside a shape lie on its surface
constexpr Real kWayOut = 2;           // depths: a rope leaves what holds it at 30 degrees to the surface, or steeper

}  // namespace

const SystemDescriptor& SurfaceRigid::descriptor() {
  return coupling_descriptor<SurfaceRigid, SurfaceContact, Rigid>("contact pairs");
}

SurfaceRigid::SurfaceRigid(SystemSetup& s)
    : arena_(s.store.arena(kName)), store_(s.store), surfaces_(s.store.get<Surfaces>()), rigid_(system_of<Rigid>(s)),
      collide_(system_of<Collide>(s)), colliders_(collide_.colliders()),
      solver_bodies_(s.store.need<SolverBodies>(Rigid::kName)), objects_(s.objects),
      contacts_(s.store.need<ContactBook>(kName)), finder_(contacts_.finder(kName)) {
  surfaces_.bodies = &rigid_.bodies();
}

SurfaceRigid::~SurfaceRigid() { surfaces_.bodies = nullptr; }

void SurfaceRigid::add_passes(StepPlan& plan) {
  wake_left();
  candidates_.clear();  // objects they name may be gone, and without passes of this coupling nothing renews them
  cfl_number_.clear();
  if (!surfaces_.wanted() || rigid_.count() == 0) return;
  contacts_.use();
  using S = SurfaceRigid;
  plan.add<&S::begin>(Rank::cloth_approach, "begin", kName, this);
  plan.add<&S::find_candidates>(Rank::surface_candidates, "find candidates", kName, this);
  plan.add<&S::make_rows>(Rank::surface_contact, "contacts", kName, this);
  if (const SurfaceLinks* links = links_of())
    if (std::any_of(links->list.begin(), links->list.end(), [](const SurfaceLink& l) { return l.to_body != 0; }))
      plan.add<&S::hold_links>(Rank::cloth_attachments, "attachments", kName, this);
  plan.add<&S::refresh_rows>(Rank::surface_refresh, "refresh contacts", kName, this);
  plan.add<&S::collect>(Rank::surface_collect, "collect", kName, this);
  plan.add<&S::finish>(Rank::surface_events, "bodies loaded", kName, this);
}

std::size_t SurfaceRigid::count() const { return count_pairs(contacts_, finder_); }

// A surface that was in contact with a body that is gone wakes.
void SurfaceRigid::wake_left() {
  each_left(contacts_, finder_, objects_, [&](ObjectId left, ObjectId gone) {
    if (objects_.kind(left) != kBodyKind) surfaces_.wakes.push_back({left, gone, WakeCause::destroyed});
  });
  std::erase_if(warned_, [&](const Warned& w) { return !objects_.alive(w.body) || !objects_.alive(w.surface); });
}

SurfaceRigid::BodyPose SurfaceRigid::body_pose(std::uint32_t k) const {
  BodyPose p;
  const Bodies& b = rigid_.bodies();
  const std::uint32_t body = colliders_.owner_index[k];
  FEDER_ASSERT(colliders_.owner[k] == ColliderOwner::body && b.object[body] == colliders_.object[k]);
  p.solver_index = solver_bodies_.index[b.solver_slot[body]];
  if (p.solver_index == 0) {
    p.center = b.position[body];
    p.pose = b.com_pose(body) * colliders_.local[k];
    return p;
  }
  FEDER_ASSERT(p.solver_index < solver_bodies_.state.size() && p.solver_index < solver_bodies_.mass.size());
  const SolverBody& s = solver_bodies_.state[p.solver_index];
  p.center = solver_bodies_.mass[p.solver_index].center + s.delta_position;
  p.velocity = s.velocity, p.angular_velocity = s.angular_velocity;
  Quat rotation = s.rotation;
  if (refreshing()) {
    p.center += surfaces_.body_delta_position[p.solver_index];
    rotation = integrate_rotation(rotation, surfaces_.body_delta_rotation[p.solver_index]);
  }
  p.pose = Pose{p.center, rotation} * colliders_.local[k];
  return p;
}

// A point that is attached to a body does not collide with it.
bool SurfaceRigid::anchored(std::uint32_t point, ObjectId body) const {
  for (const Surfaces::Anchor& a : surfaces_.anchors)
    if (a.point == point && a.body == body) return true;
  return false;
}

// Marks points of a rope that cannot be, or hardly, where contact with the collider wants them: along the rope from
// where it is held to the body, inside the shape or beside it, as far as twice the depth there.
void SurfaceRigid::leave_alone(const Surface& s, std::uint32_t k) {
  left_alone_.assign(s.count, 0);
  const Real radius = Real(0.5) * s.thickness;
  const bool pins = s.active && colliders_.motion[k] != ColliderMotion::dynamic;
  for (std::uint32_t i = 0; i < s.count; ++i) {
    const std::uint32_t held = s.first + i;
    const bool attached = anchored(held, colliders_.object[k]);
    if (attached) left_alone_[i] = 1;
    if (!attached && !(pins && surfaces_.delta_position[held].w == 0)) continue;
    Vec3 normal;
    const Vec3 x = to_local(colliders_.pose[k], surfaces_.position[held]);
    const Real way_out = kWayOut * (radius - colliders_.shape[k]->distance(x, radius, normal));
    const auto along = [&](std::uint32_t from, std::uint32_t to) {
      return length(Vec3(surfaces_.position[s.first + to] - surfaces_.position[s.first + from]));
    };
    Real far = 0;
    for (std::uint32_t j = i + 1; j < s.count && (far += along(j - 1, j)) < way_out; ++j) left_alone_[j] = 1;
    far = 0;
    for (std::uint32_t j = i; j-- > 0 && (far += along(j + 1, j)) < way_out;) left_alone_[j] = 1;
  }
}

// Wakes a surface: it is fixed in this step and moves from the next.
void SurfaceRigid::wake(Surface& surface, ObjectId by) {
  surface.active = true, surface.sleep_candidate = false;
  surfaces_.wakes.push_back({surface.object, by, WakeCause::contact});
}

std::uint32_t SurfaceRigid::state_of(const Surface& surface, ObjectId body) {
  for (std::uint32_t k = 0; k < contact_states_.size(); ++k)
    if (contact_states_[k].surface == surface.object && contact_states_[k].body == body) return k;
  FEDER_ASSERT(objects_.alive(surface.object) && objects_.kind(body) == kBodyKind);
  ContactState t;
  t.surface = surface.object, t.body = body;
  contact_states_.push_back(t);
  return static_cast<std::uint32_t>(contact_states_.size() - 1);
}

void SurfaceRigid::begin(StepContext&) {
  wake_left();  // a body may be destroyed without a new plan
  contact_states_.clear();
}

void SurfaceRigid::find_candidates(StepContext& c) {
  candidates_.clear();
  smallest_.resize(colliders_.size());
  box_.resize(surfaces_.size());
  const auto count = static_cast<std::uint32_t>(surfaces_.list.size());
  point_shapes_.resize(count);
  farthest_ = (1 + kAside) * c.dt * colliders_.fastest();
  for (std::uint32_t n = 0; n < count; ++n) {
    const Real radius = Real(0.5) * surfaces_.list[n].thickness;
    if (!point_shapes_[n] || point_shapes_[n]->radius() != radius) point_shapes_[n] = make_point(radius);
    candidates_of(n, c);
  }
  for (const Surfaces::Anchor& a : surfaces_.anchors)
    if (objects_.alive(a.body)) connect(a.surface, rigid_.index(a.body));
}

// Surfaces that act on the same dynamic body act on each other through it within a substep: one group.
void SurfaceRigid::connect(std::uint32_t surface, std::uint32_t body) {
  const Bodies& b = rigid_.bodies();
  const std::uint32_t solver_index = solver_bodies_.index[b.solver_slot[body]];
  if (b.type[body] == BodyType::dynamic && solver_index != 0)
    surfaces_.connections.push_back({surface, 0, solver_index});
}

// A pin inside a shape contradicts its contact. One warning for a surface and a body, with the deepest pin.
void SurfaceRigid::warn_of_pins(const Surface& s, std::uint32_t k, StepContext& c) {
  const ObjectId body = colliders_.object[k];
  for (const Warned& w : warned_)
    if (w.surface == s.object && w.body == body) return;
  // number and depth of the pins inside
  Real deepest = 0;
  int count = 0;
  std::uint32_t point = 0;
  for (std::uint32_t i = s.first; i < s.first + s.count; ++i) {
    if (surfaces_.delta_position[i].w != 0 || !overlaps(box_[i], colliders_.box[k]) || anchored(i, body)) continue;
    Vec3 normal;
    const Real depth =
        -colliders_.shape[k]->distance(to_local(colliders_.pose[k], surfaces_.position[i]), s.thickness, normal);
    count += depth > kInside * s.thickness;
    if (depth > deepest) deepest = depth, point = i - s.first;
  }
  if (count == 0) return;
  warned_.push_back({s.object, body});
  char millimetres[32];
  std::snprintf(millimetres, sizeof millimetres, "%.3g mm", static_cast<double>(1000 * deepest));
  const std::string others = count > 1 ? " (the deepest of " + std::to_string(count) + ")" : "";
  c.events->warn("pinned_inside",
                 objects_.describe(s.object) + " vertex " + std::to_string(point + 1) + others + " is pinned " +
                     millimetres + " inside " + objects_.describe(body) +
                     ", which cannot push it out: pin it outside, attach it to the body, or let the two not collide",
                 s.object);
}

// A body that would come farther than `s.way` within a solver substep would be seen when it is through.
void SurfaceRigid::follow(std::uint32_t n, Real speed, Real h) {
  Surface& s = surfaces_.list[n];
  const Real wanted = std::ceil((speed + s.fastest) * h / s.way);
  if (wanted > static_cast<Real>(s.steps))
    s.steps = std::max(s.steps, static_cast<int>(std::min(wanted, static_cast<Real>(s.most_steps))));
}

void SurfaceRigid::candidates_of(std::uint32_t n, StepContext& c) {
  const Surface& s = surfaces_.list[n];
  if (s.balls && s.triangles.empty()) return;
  // boxes of points, swept over the step
  const Vec3 fall = c.gravity * (c.dt * c.dt);
  Aabb all;
  for (std::uint32_t i = s.first; i < s.first + s.count; ++i) {
    const Vec3 x = surfaces_.position[i], u = surfaces_.velocity[i].vec();
    Aabb& b = box_[i];
    const Vec3 far = surfaces_.delta_position[i].w == 0 ? x : Vec3(x + c.dt * u + fall);
    b.lo = x.cwiseMin(far), b.hi = x.cwiseMax(far);
    b.grow((s.coasts ? kMarginCoasting : kMargin) * s.thickness);
    all.include(b);
  }
  // colliders near the surface, by their swept boxes
  Aabb wide = all;
  wide.grow(farthest_);
  collide_.near(wide, near_);
  for (const std::uint32_t k : near_) {
    if (!colliders_.meets(k, s.group, s.mask)) continue;
    Aabb box = colliders_.swept(k, c.dt);
    if (colliders_.motion[k] != ColliderMotion::fixed) box.grow(kAside * c.dt * length(colliders_.velocity[k]));
    if (!overlaps(all, box)) continue;
    const bool body_moves = colliders_.awake[k] && colliders_.motion[k] != ColliderMotion::fixed;
    if (!s.active && !body_moves) continue;
    if (s.most_steps > 0 && body_moves) follow(n, length(colliders_.velocity[k]), c.h);
    // points, unless they are colliders of their own
    connect(n, colliders_.owner_index[k]);
    const Shape& shape = *colliders_.shape[k];
    const Aabb own = shape.bounds(Pose{});
    const Vec3 half = Real(0.5) * (own.hi - own.lo);
    smallest_[k] = shape.convex() ? half.minCoeff() : Real(0);
    FEDER_ASSERT(!(smallest_[k] < 0));
    const ObjectId body = colliders_.object[k];
    const bool rope = !s.balls && s.triangles.empty();
    if (rope) leave_alone(s, k);
    if (!s.balls) {
      if (s.active && colliders_.motion[k] != ColliderMotion::dynamic) warn_of_pins(s, k, c);
      for (std::uint32_t i = s.first; i < s.first + s.count; ++i)
        if (overlaps(box_[i], box) && !(rope ? left_alone_[i - s.first] != 0 : anchored(i, body)))
          candidates_.push_back({n, k, i, 1});
    }
    // triangles and segments: not against planes, which corners alone can be in contact with
    if (!s.active || !is_finite(shape.extent(Vec3(0, 0, 0)))) continue;
    const std::uint32_t* ends = s.edges.ends;
    for (std::uint32_t e = 0; rope && e < s.edges.count; ++e, ends += s.edges.stride) {
      Aabb b = box_[s.first + ends[0]];
      b.include(box_[s.first + ends[1]]);
      if (!overlaps(b, box) || left_alone_[ends[0]] || left_alone_[ends[1]]) continue;
      candidates_.push_back({n, k, e, 2});
    }
    for (std::uint32_t t = 0; t < s.triangles.size() / 3; ++t) {
      const std::uint32_t* q = &s.triangles[3 * t];
      Aabb b = box_[s.first + q[0]];
      b.include(box_[s.first + q[1]]), b.include(box_[s.first + q[2]]);
      if (!overlaps(b, box)) continue;
      if (anchored(s.first + q[0], body) || anchored(s.first + q[1], body) || anchored(s.first + q[2], body)) continue;
      candidates_.push_back({n, k, t, 3});
    }
  }
}

// Links of points to places on bodies, as attachments of the substep. The side that moves wakes the other.
void SurfaceRigid::hold_links(StepContext& c) {
  const Bodies& b = rigid_.bodies();
  for (SurfaceLink& l : links_of()->list) {
    if (!l.to_body || !objects_.alive(l.a) || !objects_.alive(l.b)) continue;
    const auto at =
        std::find_if(surfaces_.list.begin(), surfaces_.list.end(), [&](const Surface& s) { return s.object == l.a; });
    if (at == surfaces_.list.end() || l.point >= at->count + at->inner) continue;
    const std::uint32_t body = rigid_.index(l.b);
    SurfaceAttachment k;
    k.vertex = at->first + l.point;
    k.solver_index = solver_bodies_.index[b.solver_slot[body]];
    const Vec3 local = l.local - b.local_com[body];
    const bool moves = k.solver_index != 0;
    const Vec3 center =
        moves ? Vec3(solver_bodies_.mass[k.solver_index].center + solver_bodies_.state[k.solver_index].delta_position)
              : b.position[body];
    k.arm = rotate(moves ? solver_bodies_.state[k.solver_index].rotation : b.rotation[body], local);
    k.error = surfaces_.position[k.vertex] - center - k.arm;
    surfaces_.groups[at->loop]->use_body(k.solver_index);
    surfaces_.groups[at->loop]->attachments.push_back(k);
    if (c.substep > 0) continue;
    warn_of_gap(l, surfaces_, *at, length(k.error), "a place of " + objects_.describe(l.b), objects_, *c.events);
    if (b.type[body] != BodyType::dynamic) continue;
    if (!at->active && b.awake[body] && b.sleep_energy[body] > kStill * kStill)
      surfaces_.wakes.push_back({l.a, l.b, WakeCause::contact});
    if (at->active && !at->sleep_candidate && !b.awake[body]) rigid_.wake(l.b, at->wakes, l.a);
  }
}

// Impulses of the rows of this substep, for the contact states.
void SurfaceRigid::collect(StepContext& c) {
  for (std::size_t k = 0; k < surfaces_.group_count; ++k) collect_group(k, c), place_attached(*surfaces_.groups[k], c);
}

// The rigid solver moves bodies by their last velocity for the whole substep. What surfaces saw of their motion in it
// differs from that: without the difference a stiff sheet and what is attached to it would be a spring integrated with
// the long step.
void SurfaceRigid::place_attached(const SurfaceGroup& group, StepContext& c) {
  for (const SurfaceAttachment& a : group.attachments) {
    const std::uint32_t m = a.solver_index;
    if (m == 0) continue;
    SolverBody& s = solver_bodies_.state[m];
    const Vec3 moves = c.h * s.velocity, turns = c.h * s.angular_velocity;
    const Vec3 turn = surfaces_.body_delta_rotation[m] - turns;
    s.delta_position += surfaces_.body_delta_position[m] - moves, s.delta_rotation += turn;
    s.rotation = integrate_rotation(s.rotation, turn);
    surfaces_.body_delta_position[m] = moves, surfaces_.body_delta_rotation[m] = turns;  // once
  }
}

void SurfaceRigid::collect_group(std::size_t group, StepContext& c) {
  const Real g = length(c.gravity);
  for (const SurfaceRow& r : surfaces_.groups[group]->rows) {
    if (r.contact_state == kNone) continue;
    FEDER_ASSERT(r.contact_state < contact_states_.size());
    ContactState& t = contact_states_[r.contact_state];
    if (!(r.impulse > 0)) continue;
    t.impulse += r.impulse;
    if (g > 0 && dot(r.normal, c.gravity) > kSupport * g) t.support += r.impulse;
    t.speed = std::max(t.speed, r.approach);
    if (r.impulse <= t.strongest) continue;
    // point, normal and slip of the strongest row
    t.strongest = r.impulse;
    int heaviest = 0;
    for (int k = 1; k < 3; ++k)
      if (r.weight[k] > r.weight[heaviest]) heaviest = k;
    for (const Surface& s : surfaces_.list)
      if (s.object == t.surface) t.index = r.vertex[heaviest] - s.first;
    t.point = current_position(r.vertex[heaviest]);
    t.normal = -r.normal;
    Vec3 u = Vec3::Zero();
    for (int k = 0; k < 3; ++k) u += r.weight[k] * surfaces_.velocity[r.vertex[k]].vec();
    if (r.solver_index) u -= velocity_at(solver_bodies_.state[r.solver_index], r.arm);
    t.slip = length(Vec3(u - dot(u, r.normal) * r.normal));
  }
}

// Reports in the order of the objects.
void SurfaceRigid::finish(StepContext&) {
  std::sort(contact_states_.begin(), contact_states_.end(), [](const ContactState& x, const ContactState& y) {
    return x.surface != y.surface ? x.surface < y.surface : x.body < y.body;
  });
  for (const ContactState& t : contact_states_) {
    const Surface* s = surface_of(surfaces_, t.surface);
    FEDER_ASSERT(s && objects_.alive(t.body));
    if (t.impulse > 0 && s->active) report(t, *s);
  }
  contacts_.each(finder_, [&](const ContactRecord& r) {
    const Surface* s = surface_of(surfaces_, objects_.kind(r.key.a) == kBodyKind ? r.key.b : r.key.a);
    if (s && !s->active) contacts_.keep(finder_, r);
  });
  surfaces_.clear_rows();
}

// Points of nets are reported by collide, with the two objects in their order: so are their faces.
void SurfaceRigid::report(const ContactState& t, const Surface& s) {
  FEDER_ASSERT(!(t.support > Real(1.001) * t.impulse));  // support is a part of it
  surfaces_.carried.push_back({t.surface, t.body, t.impulse, t.support});
  const Bodies& b = rigid_.bodies();
  const std::uint32_t body = rigid_.index(t.body);
  if (!s.sleep_candidate && b.type[body] == BodyType::dynamic && !b.awake[body])
    rigid_.wake(t.body, s.wakes, t.surface);
  ContactFinding n;
  const bool flipped = s.balls && t.body < t.surface;
  n.key = {flipped ? t.body : t.surface, flipped ? t.surface : t.body};
  n.index = t.index, n.point = t.point, n.normal = flipped ? Vec3(-t.normal) : t.normal;
  n.speed = t.speed, n.slip = t.slip, n.impulse = t.impulse;
  contacts_.see(finder_, n);
}

void SurfaceRigid::hash(Hash& h) const { hash_pairs(contacts_, finder_, h); }

void SurfaceRigid::save(Writer& w) const { w.list(warned_); }

void SurfaceRigid::load(Reader& r) {
  r.list(warned_);
  contact_states_.clear();
  candidates_.clear();
  cfl_number_.clear();
}

void SurfaceRigid::validate() const {
  for (const Warned& w : warned_) FEDER_ASSERT(objects_.alive(w.surface) && objects_.alive(w.body));
  for (std::size_t k = 0; k < surfaces_.group_count; ++k)
    for (const SurfaceRow& r : surfaces_.groups[k]->rows)
      FEDER_ASSERT(r.contact_state == kNone);  // rows live within a substep
  FEDER_ASSERT(!refreshing());
}

}  // namespace feder
