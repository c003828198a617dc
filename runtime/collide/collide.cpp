// The collide system: passes, filters by pairs of objects, materials, hash and snapshots.
#include <algorithm>

#include "base/registry.h"
#include "broad/broad_phase.h"
#include "collide/impl.h"
#include "feder/query.h"
#include "geom/surfaces.h"
#include "narrow/narrow_phase.h"
#include "state/colliders.h"
#include "state/contacts.h"

namespace feder {

Collide::Impl::Impl(SystemSetup& setup)
    : arena(setup.store.arena(kName)), commands(setup.commands), colliders(&setup.store.need<Colliders>(kName)),
      contacts(&setup.store.need<Contacts>(kName)), book(&setup.store.need<ContactBook>(kName)),
      narrow(setup.world.text({"narrow_phase"}, "auto", narrow_phase_names())) {
  broad =
      variant_option(setup.world, {"broad_phase"}, broad_phases(), "tree", "broad phase").make(arena, setup.options);
}

Collide::Collide(SystemSetup& setup) : impl_(std::make_unique<Impl>(setup)) {}
Collide::~Collide() = default;

const SystemDescriptor& Collide::descriptor() {
  static const SystemDescriptor d = {.name = kName, .units = "colliders", .make = &make_system<Collide>};
  return d;
}

void Collide::add_passes(StepPlan& plan) {
  if (count() == 0 && impl_->entries.empty()) return;  // what rests belongs to colliders
  impl_->book->use();
  plan.add<&Impl::find_pairs>(Rank::broad, "find pairs", kName, impl_.get());
  plan.add<&Impl::collide>(Rank::narrow, "collide", kName, impl_.get());
  plan.add<&Impl::list_active>(Rank::contact_list, "list contacts", kName, impl_.get());
  plan.add<&Impl::report_contact_states>(Rank::contact_events, "contact states", kName, impl_.get());
}

std::size_t Collide::count() const { return impl_->colliders->size() - impl_->colliders->free_list.size(); }
Colliders& Collide::colliders() { return *impl_->colliders; }
Contacts& Collide::contacts() { return *impl_->contacts; }
const NarrowPhase& Collide::narrow() const { return impl_->narrow; }
void Collide::near(const Aabb& box, Array<std::uint32_t>& found) const { impl_->broad->query(box, found); }
std::span<const Aabb> Collide::boxes() const { return impl_->colliders->box; }
std::span<const BoxMotion> Collide::box_motion() const { return impl_->motion; }
bool Collide::cells_at(int level, void (*take)(void*, const Aabb&), void* to) const {
  return impl_->broad->cells_at(level, take, to);
}
void Collide::forget(std::uint32_t collider) { impl_->forget(collider); }

void Collide::residuals(std::vector<Residual>& out) const {
  out.push_back({"collide.max_penetration_m", static_cast<double>(max_penetration())});
  const NarrowMethod* method = impl_->narrow.method();
  if (!method) return;
  double handed_on = 0;
  for (const ContactEntry& e : impl_->all_entries())
    if (starts_number(e)) handed_on += method->handed_on(impl_->memory[e.pair].cache);
  out.push_back({"collide.handed_on", handed_on});
}

void Collide::notes(std::vector<Note>& out) const {
  const Colliders& c = *impl_->colliders;
  std::vector<const Shape*> known;
  for (std::uint32_t i = 0; i < c.shape.size(); ++i) {
    const Shape* shape = c.shape[i];
    if (!shape || std::find(known.begin(), known.end(), shape) != known.end()) continue;
    const std::string index = shape->describe();
    if (index.empty()) continue;
    known.push_back(shape);
    out.push_back({c.object[i], std::string(shape->kind()) + ": " + index});
  }
}

namespace {

// Position of the pair in the sorted list, or where it would be inserted.
auto place_of(auto& list, ObjectId a, ObjectId b) {
  return std::lower_bound(list.begin(), list.end(), ordered(a, b), [](const Exclusion& e, const auto& pair) {
    return std::pair{e.a, e.b} < pair;
  });
}

}  // namespace

bool Collide::Impl::excluded(ObjectId a, ObjectId b) const {
  const auto it = place_of(exclusions, a, b);
  return it != exclusions.end() && std::pair{it->a, it->b} == ordered(a, b);
}

void Collide::exclude(ObjectId a, ObjectId b) {
  const Command command(impl_->commands, "collide.exclude", a, b);
  Array<Exclusion>& list = impl_->exclusions;
  const auto it = place_of(list, a, b);
  if (impl_->excluded(a, b)) return void(++it->count);
  list.insert(it, {ordered(a, b).first, ordered(a, b).second, 1});
  impl_->recheck_filters = true;
}

void Collide::include(ObjectId a, ObjectId b) {
  const Command command(impl_->commands, "collide.include", a, b);
  if (!impl_->excluded(a, b)) return;
  const auto it = place_of(impl_->exclusions, a, b);
  FEDER_ASSERT(it->count > 0);
  if (--it->count > 0) return;
  impl_->exclusions.erase(it);
  // else a sleeping pair would not be tested
  Colliders& c = *impl_->colliders;
  for (std::uint32_t i = 0; i < c.size(); ++i)
    if (c.motion[i] != ColliderMotion::none && c.object[i] == a) c.changed.push_back(i);
}

void Collide::check_shape(const Shape& shape) const {
  impl_->narrow.prepare(shape);
  if (impl_->narrow.complete()) return;
  const Colliders& c = *impl_->colliders;
  for (std::uint32_t k = 0; k < c.size(); ++k)
    if (c.motion[k] != ColliderMotion::none && impl_->narrow.lacks(shape, *c.shape[k]))
      throw SceneError(std::string("body.shape: this build has no test for ") + shape.kind() + " with " +
                       c.shape[k]->kind());
}

std::uint16_t Collide::material(std::string_view name) {
  const Command command(impl_->commands, "collide.material", name);
  std::vector<std::string>& list = impl_->materials;
  const auto it = std::find(list.begin(), list.end(), name);
  if (it != list.end()) return static_cast<std::uint16_t>(it - list.begin() + 1);
  if (list.size() == 0xffff) throw SceneError("more than 65535 materials");
  list.emplace_back(name);
  return static_cast<std::uint16_t>(list.size());
}

void Collide::define_material(std::string_view name, const SurfaceNumbers& numbers) {
  const Command command(impl_->commands, "collide.define_material", name, numbers);
  const ShapeSurface checked{.numbers = numbers};
  check_surfaces("define_material", {&checked, 1});
  const std::size_t number = material(name);
  Array<SurfaceNumbers>& list = impl_->material_numbers;
  if (list.size() < number) list.resize(number);
  SurfaceNumbers& stored = list[number - 1];
  const auto all = [](const SurfaceNumbers& s) {
    return std::tie(s.friction_static, s.friction_dynamic, s.restitution, s.rolling_friction);
  };
  impl_->recheck_surfaces = impl_->recheck_surfaces || all(stored) != all(numbers);
  stored = numbers;
}

SurfaceNumbers Collide::material_numbers(std::uint16_t material) const {
  const Array<SurfaceNumbers>& list = impl_->material_numbers;
  return material > 0 && material <= list.size() ? list[material - 1] : SurfaceNumbers{};
}

void Collide::set_material_pair(const MaterialPair& pair) {
  const Command command(impl_->commands, "collide.set_material_pair", pair);
  MaterialPair p = pair;
  if (p.a > p.b) std::swap(p.a, p.b);
  if (p.b > impl_->materials.size()) throw SceneError("set_material_pair: expected numbers of known materials");
  std::vector<MaterialPair>& list = impl_->material_pairs;
  const auto same = [&](const MaterialPair& q) { return q.a == p.a && q.b == p.b; };
  const auto it = std::find_if(list.begin(), list.end(), same);
  if (it != list.end())
    *it = p;
  else
    list.push_back(p);
  impl_->recheck_surfaces = true;
}

void Collide::hash(Hash& h) const {
  const std::vector<ContactEntry> all = impl_->all_entries();
  h.add(static_cast<std::uint64_t>(all.size()));
  for (const ContactEntry& e : all) {
    h.add(e.a), h.add(e.b), h.add(e.sub), h.add(static_cast<std::uint16_t>(e.bits & (kTouching | kReported | kNear)));
    if (e.slot == kNone) continue;
    const Contact& contact = impl_->contacts->slots[e.slot];
    if (contact.surface) h.add(contact.surface);
    h.add(contact.normal);
    for (int k = 0; k < contact.point_count; ++k) {
      const ContactPoint& p = contact.points[k];
      h.add(p.arm_a), h.add(p.arm_b), h.add(p.separation), h.add(p.normal_impulse), h.add(p.feature);
    }
    h.add(contact.tangent_impulse[0]), h.add(contact.tangent_impulse[1]), h.add(contact.twist_impulse);
    h.add(contact.rolling_impulse);
  }
  for (const ContactRecord& r : impl_->book->records())
    if (r.count > 0) h.add(r.key.a.slot), h.add(r.key.b.slot), h.add(r.key.index), h.add(r.count);
}

void Collide::save(Writer& w) const {
  const Impl& m = *impl_;
  m.colliders->save(w);
  Impl::each_saved(m, saved_to(w));
  w.add(static_cast<std::uint64_t>(m.materials.size()));
  for (const std::string& name : m.materials) w.text(name);
}

void Collide::load(Reader& r) {
  Impl& m = *impl_;
  m.colliders->load(r);
  Impl::each_saved(m, loaded_from(r));
  m.materials.resize(std::min<std::uint64_t>(r.get<std::uint64_t>(), 0xffff));
  for (std::string& name : m.materials) r.text(name);
  m.watched.clear();
  m.motion.assign(m.seen.size(), BoxMotion::absent);
  m.examined.resize(m.seen.size());
  for (std::uint32_t i = 0; i < m.examined.size(); ++i) m.examined[i] = i;
  m.examine_all = true;
  m.contacts->resting.relist(m.colliders->size());
}

}  // namespace feder
