// Before a step: boxes of all cloths, swept over it, say which pairs may touch. The cloth's small steps find and solve
// the contacts of those pairs together with self-contact, in one search, because a fold that lies on another cloth is
// one pile; both sides get the opposite impulse at the same moment. After the step: what each side really got makes
// the mismatch of the residuals, and contacts begin and end. A sleeper that is touched by what
// moves wakes. Kept between steps: who touches whom.
#include "couple/cloth_cloth.h"

#include <algorithm>
#include <cmath>

#include "base/checks.h"

namespace feder {
namespace {

constexpr Real kHaste = Real(1.5);  // of the fastest vertex: others may be drawn along faster in the step

}  // namespace

const SystemDescriptor& ClothCloth::descriptor() {
  static const char* const joins[] = {Cloth::kName};
  static const SystemDescriptor d = {kName, {}, joins, [](SystemSetup& setup) -> std::unique_ptr<System> {
                                       return std::make_unique<ClothCloth>(setup);
                                     }};
  return d;
}

ClothCloth::ClothCloth(SystemSetup& s)
    : cloth_(static_cast<Cloth&>(*s.systems.find_system(Cloth::kName))), objects_(s.objects), events_(s.events),
      box_(&s.store.arena(kName)), touches_(&s.store.arena(kName)) {}

void ClothCloth::add_passes(StepPlan& plan) {
  sync();
  if (cloth_.cloth_count() < 2) return;
  using S = ClothCloth;
  plan.add<&S::list_pairs>(Rank::cloth_pairs, "who may touch", kName, this);
  plan.add<&S::finish>(Rank::cloth_pair_events, "touches", kName, this);
}

std::size_t ClothCloth::count() const { return touches_.size(); }

// A contact with a cloth that is gone ends; the other one wakes.
void ClothCloth::sync() {
  for (const Touch& t : touches_) {
    if (objects_.alive(t.a) && objects_.alive(t.b)) continue;
    for (const auto& [left, gone] : {std::pair(t.a, t.b), std::pair(t.b, t.a)})
      if (objects_.alive(left)) cloth_.wake(left, WakeCause::destroyed, gone);
    events_.add_pending(event(EventKind::contact_end, t));
  }
  std::erase_if(touches_, [&](const Touch& t) { return !objects_.alive(t.a) || !objects_.alive(t.b); });
}

// Where a cloth may be in this step, whatever strikes it.
Aabb ClothCloth::reach(std::size_t n, StepContext& c) const {
  const Cloth::Info info = cloth_.info(n);
  const ClothVertices& v = cloth_.vertices();
  FEDER_ASSERT(info.count > 0 && info.first + info.count <= v.size());
  Aabb box;
  Real fastest = 0;
  for (std::uint32_t i = info.first; i < info.first + info.count; ++i) {
    box.include(v.position[i]);
    if (!info.asleep) fastest = std::max(fastest, dot(v.velocity[i], v.velocity[i]));
  }
  const Real speed = kHaste * std::sqrt(fastest) + info.strike + (info.asleep ? Real(0) : c.dt * length(c.gravity));
  box.grow(info.thickness + c.dt * speed);
  return box;
}

void ClothCloth::list_pairs(StepContext& c) {
  mismatch_ = given_ = 0;
  for (Touch& t : touches_) t.seen = 0;
  const auto count = static_cast<std::uint32_t>(cloth_.cloth_count());
  box_.resize(count);
  for (std::uint32_t n = 0; n < count; ++n) box_[n] = reach(n, c);
  Array<Cloth::Between>& list = cloth_.between();
  FEDER_ASSERT(list.empty());  // of this step there are none yet
  list.clear();
  for (std::uint32_t i = 0; i < count; ++i)
    for (std::uint32_t j = i + 1; j < count; ++j) {
      const Cloth::Info a = cloth_.info(i), b = cloth_.info(j);
      if ((a.asleep && b.asleep) || !(a.group & b.mask) || !(b.group & a.mask)) continue;
      if (!overlaps(box_[i], box_[j])) continue;
      Cloth::Between k;
      k.a = a.object < b.object ? i : j, k.b = a.object < b.object ? j : i;
      list.push_back(k);
    }
  pairs_ = list.size();
}

// What the step did to a pair.
void ClothCloth::gather(const Cloth::Between& k) {
  for (int j = 0; j < 3; ++j) mismatch_ = std::max(mismatch_, std::abs(k.given[0][j] + k.given[1][j]));
  given_ += static_cast<double>(k.impulse);
  if (!(k.impulse > 0)) return;
  const ObjectId a = cloth_.info(k.a).object, b = cloth_.info(k.b).object;
  FEDER_ASSERT(a < b && k.index < cloth_.info(k.a).count);
  FEDER_ASSERT(is_direction(k.normal) && !(k.strongest > Real(1.001) * k.impulse));
  auto t = std::find_if(touches_.begin(), touches_.end(), [&](const Touch& x) { return x.a == a && x.b == b; });
  if (t == touches_.end()) {
    Touch fresh;
    fresh.a = a, fresh.b = b;
    t = touches_.insert(
        std::find_if(touches_.begin(), touches_.end(), [&](const Touch& x) { return a != x.a ? a < x.a : b < x.b; }),
        fresh);
  }
  t->what = k;
  t->seen = 1;
}

Event ClothCloth::event(EventKind kind, const Touch& t) {
  open_.count(kind);
  Event e;
  e.kind = kind;
  e.a = t.a, e.b = t.b;
  e.index = t.what.index, e.point = t.what.point, e.normal = t.what.normal;
  e.speed = t.what.speed, e.impulse = t.what.impulse;
  return e;
}

void ClothCloth::report(Touch& t, StepContext& c) {
  const Cloth::Info a = cloth_.info(objects_.index(t.a)), b = cloth_.info(objects_.index(t.b));
  FEDER_ASSERT(a.object == t.a && b.object == t.b);
  if (a.asleep && b.asleep && t.begun) t.seen = 1;  // nothing has moved
  if (t.seen && a.asleep && b.moving) cloth_.wake(t.a, WakeCause::cloth, t.b);
  if (t.seen && b.asleep && a.moving) cloth_.wake(t.b, WakeCause::cloth, t.a);
  if (t.seen && !t.begun) {
    c.events->add(event(EventKind::contact_begin, t));
    if (c.events->wanted(EventKind::hit)) c.events->add(event(EventKind::hit, t));
  } else if (t.seen && c.events->wanted(EventKind::contact_stay)) {
    c.events->add(event(EventKind::contact_stay, t));
  } else if (!t.seen && t.begun) {
    c.events->add(event(EventKind::contact_end, t));
  }
  t.begun = t.seen;
}

void ClothCloth::finish(StepContext& c) {
  for (const Cloth::Between& k : cloth_.between()) gather(k);
  for (Touch& t : touches_) report(t, c);
  std::erase_if(touches_, [](const Touch& t) { return !t.begun; });
}

void ClothCloth::hash(Hash& h) const {
  for (const Touch& t : touches_) h.add(t.a.slot), h.add(t.b.slot);
}

void ClothCloth::residuals(std::vector<Residual>& out) const {
  if (cloth_.cloth_count() < 2) return;
  out.push_back({"cloth_cloth.impulse_mismatch", given_ > 0 ? mismatch_ / given_ : 0});
  out.push_back({"cloth_cloth.impulse_ns", given_});
  out.push_back({"cloth_cloth.pairs", static_cast<double>(pairs_)});
}

void ClothCloth::validate() const {
  validate_records<Touch>({touches_.data(), touches_.size()}, &Touch::a, ObjectKind::cloth, &Touch::b,
                          ObjectKind::cloth, objects_, open_);
  for (const Touch& t : touches_) {
    FEDER_ASSERT(t.a < t.b);
    FEDER_ASSERT(t.begun == 1 && t.seen == 1);  // others have ended
  }
  FEDER_ASSERT(cloth_.cloth_count() < 2 || box_.size() == cloth_.cloth_count());
}

}  // namespace feder
