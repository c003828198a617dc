// Structure of surface contact. Before a step: swept boxes of all surfaces give the candidate pairs. The loop of solver
// substeps finds and solves the contacts of those pairs together with self-contact, in one search, because a fold that
// lies on another cloth is one pile; both sides take the opposite impulse at the same moment. After the step: the
// momenta that both sides received give the mismatch of the residuals, and pairs in contact are reported to the contact
// book. A sleeper in contact with an active surface wakes.
#include <algorithm>
#include <cmath>

#include "base/wide.h"
#include "contact/impl.h"
#include "contact/seen_pairs.h"
#include "contact/tangles.h"

namespace feder {
namespace {

constexpr Real kSpeedMargin = Real(1.5);  // times the fastest point: others may be drawn along faster in the step

}  // namespace

const SystemDescriptor& SurfaceContact::descriptor() {
  static const char* const joins[] = {"surface"};
  static const SystemDescriptor d = {
      .name = kName, .units = "contact pairs", .joins = joins, .make = &make_system<SurfaceContact>};
  return d;
}

SurfaceContact::SurfaceContact(SystemSetup& setup) : impl_(std::make_unique<Impl>(setup)) {}
SurfaceContact::~SurfaceContact() = default;

SurfaceContact::Impl::Impl(SystemSetup& s)
    : arena(s.store.arena(kName)), store(s.store), objects(s.objects), contacts(s.store.need<ContactBook>(kName)),
      structure_changed(s.structure_changed), finder(contacts.finder(kName)), surfaces(s.store.need<Surfaces>(kName)),
      list(surfaces.list), position(surfaces.position), mass(surfaces.mass), delta_position(surfaces.delta_position),
      before(surfaces.before), velocity(surfaces.velocity), surface_pairs(surfaces.pairs) {
#if defined(__x86_64__) || defined(__i386__)
  if (runs_avx2()) kernels = &kNearKernelsAvx2;
#endif
}

void SurfaceContact::add_passes(StepPlan& plan) {
  Impl* m = impl_.get();
  m->wake_left();
  m->surfaces.forget();  // objects that it names may be gone
  std::erase_if(m->all_parts, [&](const Impl::PartsOf& p) { return !m->objects.alive(p.object); });
  std::erase_if(m->all_searches, [&](const Impl::SearchOf& p) { return !m->objects.alive(p.object); });
  m->surfaces.solver_bodies = m->store.find<SolverBodies>();
  if (!m->surfaces.wanted()) return;
  m->sync_links();
  m->link_marks.clear(), m->held_links.clear(), m->link_gap = 0;
  const SurfaceLinks* links = m->store.find<SurfaceLinks>();
  const bool linked = links && !links->list.empty();
  const bool pairs = m->surfaces.declared() > 1;
  const bool near = pairs || m->surfaces.any_owner([](const Surfaces::Owner& o) { return o.self; });
  const bool coasts = m->surfaces.any_owner([](const Surfaces::Owner& o) { return !o.loops; });
  const bool solver_bodies = m->surfaces.solver_bodies != nullptr;
  plan.add<&Impl::begin_step>(Rank::surface_begin, "begin", kName, m);
  if (pairs) plan.add<&Impl::list_pairs>(Rank::surface_pairs, "surface pairs", kName, m);
  if (linked) plan.add<&Impl::connect_links>(Rank::append_points, "connect links", kName, m);
  plan.add<&Impl::form_groups>(Rank::surface_groups, "groups", kName, m);
  const bool self = m->surfaces.any_owner([](const Surfaces::Owner& o) { return o.self && o.loops; });
  if (self) plan.add<&Impl::untangle>(Rank::surface_tangles, "tangles", kName, m);
  plan.add<&Impl::begin_substep>(Rank::surface_start, "begin substep", kName, m);
  if (near) plan.add<&Impl::find_near>(Rank::surface_near, "near surfaces", kName, m);
  if (coasts) plan.add<&Impl::coast>(Rank::surface_coast, "coast", kName, m);
  if (solver_bodies) plan.add<&Impl::advance_bodies>(Rank::surface_bodies, "bodies", kName, m);
  if (solver_bodies) plan.add<&Impl::solve_attachments>(Rank::surface_attachments, "attachments", kName, m);
  if (linked) plan.add<&Impl::solve_links>(Rank::surface_attachments, "links", kName, m);
  if (near || solver_bodies) plan.add<&Impl::solve>(Rank::surface_rows, "contacts", kName, m);
  if (coasts) plan.add<&Impl::read_velocities>(Rank::surface_velocities, "velocities", kName, m);
  if (near || solver_bodies) plan.add<&Impl::rebound>(Rank::surface_rebound, "rebound", kName, m);
  if (near) plan.add<&Impl::project>(Rank::surface_project, "non-penetration", kName, m);
  if (pairs) m->contacts.use();
  if (pairs) plan.add<&Impl::finish>(Rank::surface_events, "contact states", kName, m);
}

std::size_t SurfaceContact::count() const { return count_pairs(impl_->contacts, impl_->finder); }

void SurfaceContact::Impl::begin_step(StepContext& c) {
  jobs = c.jobs;
  surfaces.begin();
  surfaces.row_updates = 0;
  projected = widened = search_total = 0;
  mismatch = given = 0;
  pairs_seen = 0;
}

void SurfaceContact::Impl::wake(ObjectId sleeper, ObjectId other) {
  const Surface* s = surface_of(surfaces, other);
  surfaces.wakes.push_back({sleeper, other, s ? s->wakes : WakeCause::contact});
}

// Surfaces that were in contact with an object that is gone wake.
void SurfaceContact::Impl::wake_left() {
  each_left(contacts, finder, objects, [&](ObjectId left, ObjectId gone) {
    surfaces.wakes.push_back({left, gone, WakeCause::destroyed});
  });
}

// Where a surface may be in this step, with what approaching bodies may do to it.
Aabb SurfaceContact::Impl::swept_bounds(const Surface& s, StepContext& c) const {
  FEDER_ASSERT(s.count > 0 && s.first + s.total <= surfaces.size());
  Aabb all;
  for (std::uint32_t i = s.first; i < s.first + s.count; ++i) all.include(position[i]);
  const Real speed = kSpeedMargin * s.fastest + s.approach_speed + (s.active ? c.dt * length(c.gravity) : Real(0));
  all.grow(s.thickness + c.dt * speed);
  return all;
}

void SurfaceContact::Impl::list_pairs(StepContext& c) {
  FEDER_ASSERT(surface_pairs.empty());  // none of this step yet
  const auto count = static_cast<std::uint32_t>(list.size());
  if (count < 2) return;
  box.resize(count);
  for (std::uint32_t n = 0; n < count; ++n) box[n] = swept_bounds(list[n], c);
  for (std::uint32_t i = 0; i < count; ++i)
    for (std::uint32_t j = i + 1; j < count; ++j) {
      const Surface &a = list[i], &b = list[j];
      if ((!a.active && !b.active) || !(a.group & b.mask) || !(b.group & a.mask)) continue;
      if (!overlaps(box[i], box[j])) continue;
      SurfacePair k;
      k.a = a.object < b.object ? i : j, k.b = a.object < b.object ? j : i;
      surface_pairs.push_back(k);
    }
  pairs_seen = surface_pairs.size();
}

// Impulses of the step on a pair: mismatch, contact book, wakes.
void SurfaceContact::Impl::report(const SurfacePair& k) {
  for (int j = 0; j < 3; ++j) mismatch = std::max(mismatch, std::abs(k.given[0][j] + k.given[1][j]));
  given += static_cast<double>(k.impulse);
  if (!(k.impulse > 0)) return;
  const Surface &a = list[k.a], &b = list[k.b];
  FEDER_ASSERT(a.object < b.object && k.index < a.count);
  FEDER_ASSERT(is_direction(k.normal) && !(k.strongest > Real(1.001) * k.impulse));
  ContactFinding n;
  n.key = {a.object, b.object};
  n.index = k.index, n.point = k.point, n.normal = k.normal;
  n.speed = k.speed, n.slip = k.slip, n.impulse = k.impulse;
  contacts.see(finder, n);
  if (!a.active && b.active && !b.sleep_candidate) wake(a.object, b.object);
  if (!b.active && a.active && !a.sleep_candidate) wake(b.object, a.object);
}

void SurfaceContact::Impl::finish(StepContext&) {
  for (const SurfacePair& k : surface_pairs) report(k);
  contacts.each(finder, [&](const ContactRecord& r) {
    const Surface *a = surface_of(surfaces, r.key.a), *b = surface_of(surfaces, r.key.b);
    if (a && b && !a->active && !b->active) contacts.keep(finder, r);
  });
}

void SurfaceContact::hash(Hash& h) const {
  hash_pairs(impl_->contacts, impl_->finder, h);
  if (const SurfaceLinks* links = impl_->store.find<SurfaceLinks>())
    for (const SurfaceLink& l : links->list)
      h.add(l.a.slot), h.add(l.b.slot), h.add(l.point), h.add(l.other), h.add(l.local);
}

void SurfaceContact::save(Writer& w) const {
  const SurfaceLinks* links = impl_->store.find<SurfaceLinks>();
  const bool any = links && !links->list.empty();
  w.add(static_cast<std::uint8_t>(any));
  if (any) w.list(links->list);
  impl_->save_kept(w);
}

void SurfaceContact::load(Reader& r) {
  SurfaceLinks* links = impl_->store.find<SurfaceLinks>();
  if (links) links->list.clear();
  if (r.get<std::uint8_t>() != 0) r.list(impl_->store.need<SurfaceLinks>(kName).list);
  impl_->load_kept(r);
  *impl_->structure_changed = true;
  impl_->surfaces.forget();
  impl_->surfaces.wakes.clear();
}

void SurfaceContact::residuals(std::vector<Residual>& out) const {
  const Impl& m = *impl_;
  out.push_back({"contact.guarded", static_cast<double>(m.projected)});
  out.push_back({"contact.widened", static_cast<double>(m.widened)});
  out.push_back({"contact.searches", static_cast<double>(m.search_total)});
  out.push_back({"contact.impulse_mismatch", m.given > 0 ? m.mismatch / m.given : 0});
  out.push_back({"contact.impulse_ns", m.given});
  out.push_back({"contact.pairs", static_cast<double>(m.pairs_seen)});
  if (!m.held_links.empty()) out.push_back({"contact.link_gap_m", m.link_gap});
}

}  // namespace feder
