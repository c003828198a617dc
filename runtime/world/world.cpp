// A world: makes systems and couplings, builds the plan, steps, and sums over its systems.
#include "feder/world.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "feder/error.h"
#include "forces/forces.h"
#include "state/command_log.h"
#include "state/contact_book.h"
#include "step/watch.h"
#include "world/own.h"
#include "world/recorded_force.h"

namespace feder {

void check(const WorldDesc& d) {
  if (!is_finite(d.gravity)) throw SceneError("world.gravity: expected three finite numbers");
  if (!(d.dt > 0 && d.dt <= 1))
    throw SceneError("world.dt: expected a number above 0 and at most 1 s, got " + std::to_string(d.dt));
  if (d.substeps < 1 || d.substeps > 1000)
    throw SceneError("world.substeps: expected a whole number from 1 to 1000, got " + std::to_string(d.substeps));
  if (!(static_cast<Real>(d.dt / d.substeps) > 0))
    throw SceneError(std::string("world.dt: too small for ") + kRealName + ", where a substep would last 0 s");
  if (d.threads < 1 || d.threads > 64)
    throw SceneError("world.threads: expected a whole number from 1 to 64, got " + std::to_string(d.threads));
  if (d.dimension != 2 && d.dimension != 3)
    throw SceneError("world.dimension: expected 2 or 3, got " + std::to_string(d.dimension));
}

bool Helper::help() const { return jobs_ && jobs_->help(); }

Rng& World::rng() { return own_->rng; }

namespace {

// Checked before workers are made.
WorldDesc checked(WorldDesc desc, const Executor& executor) {
  if (executor.call) desc.threads = executor.threads;
  check(desc);
  return desc;
}

}  // namespace

World::World(const WorldDesc& desc, Catalog catalog, const Executor& executor)
    : desc_(checked(desc, executor)), catalog_(catalog), commands_(std::make_unique<CommandLog>()),
      watch_(store_.need<Watch>("watch")), events_(store_.arena("events")),
      own_(std::make_unique<Own>(desc_, executor, store_)) {
  objects_.know(kForceKind);
  objects_.log_to(*commands_);
  for (const SystemDescriptor* d : catalog_)
    for (ObjectKind kind : d->kinds) objects_.know(kind);
}

World::~World() {
  // couplings refer to their partners: last made, first destroyed
  while (!systems_.empty()) systems_.pop_back();
}

CommandLog& World::commands() { return *commands_; }

void World::set_gravity(const Vec3& g) {
  const Command command(*commands_, "world.set_gravity", g);
  if (!feder::is_finite(g)) throw SceneError("gravity: expected three finite numbers");
  desc_.gravity = g;
}

System* World::find_system(std::string_view name) {
  for (Present& p : systems_)
    if (name == p.descriptor->name) return p.system.get();
  return nullptr;
}

const SystemDescriptor* World::find_descriptor(std::string_view name) const {
  for (const SystemDescriptor* d : catalog_)
    if (name == d->name) return d;
  return nullptr;
}

System& World::need_system(std::string_view name) {
  if (System* s = find_system(name)) return *s;
  const Command command(*commands_, "world.need_system", name);
  const SystemDescriptor* d = find_descriptor(name);
  if (!d) throw SceneError("this build leaves out the module '" + std::string(name) + "'");
  System& made = make_system(*d);
  make_couplings();
  return made;
}

System& World::make_system(const SystemDescriptor& d) {
  for (const char* need : d.needs) {
    if (find_system(need)) continue;
    const SystemDescriptor* nd = find_descriptor(need);
    if (!nd)
      throw SceneError(std::string("the module '") + d.name + "' needs '" + need + "', which this build leaves out");
    make_system(*nd);
  }
  const auto it = desc_.systems.find(d.name);
  const Params& options = it == desc_.systems.end() ? no_options_ : it->second;
  SystemSetup setup{store_,     objects_,           events_, options, desc_.options, desc_.dimension, *this,
                    *commands_, &structure_changed_};
  FEDER_ASSERT(!find_system(d.name));
  auto system = d.make(setup);
  FEDER_ASSERT(system);
  options.check_all_read(d.name);
  systems_.push_back({&d, std::move(system)});
  structure_changed_ = true;
  return *systems_.back().system;
}

void World::make_couplings() {
  for (const SystemDescriptor* d : catalog_) {
    if (d->joins.empty() || find_system(d->name)) continue;
    const auto there = [&](const char* name) {
      return std::any_of(systems_.begin(), systems_.end(), [&](const Present& p) {
        const char* shown = p.descriptor->shows;
        return std::strcmp(p.descriptor->name, name) == 0 || (shown && std::strcmp(shown, name) == 0);
      });
    };
    if (std::all_of(d->joins.begin(), d->joins.end(), there)) make_system(*d);
  }
}

std::vector<std::string> World::absent() const {
  std::vector<std::string> names;
  for (const SystemDescriptor* d : catalog_) {
    bool present = false;
    for (const Present& p : systems_) present = present || p.descriptor == d;
    if (!present) names.emplace_back(d->name);
  }
  return names;
}

void World::begin_step(void* self, StepContext&) {
  World& w = *static_cast<World*>(self);
  w.events_.clear();
  w.own_->scratch.reset();
}

void World::finish_step(void* self, StepContext& c) {
  World& w = *static_cast<World*>(self);
  if (w.events_.wanted(EventKind::step)) w.events_.add(Event{});
  w.warn_of_forces();
  if (!w.watch_.suspects.empty()) w.warn_of_energy(c);
  w.events_.finish();
  w.time_ = static_cast<double>(c.step + 1) * w.desc_.dt;
  ++w.steps_;
}

void World::merge_contacts(void* self, StepContext& c) {
  c.store->get<ContactBook>().merge(c.step, static_cast<World*>(self)->objects_, *c.events);
}

void World::warn_of_forces() {
  Forces* forces = store_.find<Forces>();
  if (!forces) return;
  for (ForceEntry& f : forces->list) {
    if (f.warned || !f.force || f.force->faults() == 0) continue;
    f.warned = true;
    events_.warn("force_domain",
                 objects_.describe(f.object) +
                     " had no value at some point (division by zero, root or "
                     "logarithm of a negative number, overflow) and counted as 0 there; guard it with max or min",
                 f.object);
  }
}

void World::rebuild_plan() {
  plan_.clear();
  plan_.add(Rank::begin, "begin", "world", &World::begin_step, this);
  ContactBook* book = store_.find<ContactBook>();
  if (book) book->begin_plan();
  for (Present& p : systems_) p.system->add_passes(plan_);
  if (book && book->wanted())
    plan_.add(after(Rank::contact_events), "contact events", "world", &World::merge_contacts, this);
  plan_.add(Rank::finish, "finish", "world", &World::finish_step, this);
  plan_.finish();
  if constexpr (kAsserts) check_names();
  structure_changed_ = false;
}

const StepPlan& World::plan() {
  if (structure_changed_) {
    const Command command(*commands_, "world.plan");
    rebuild_plan();
  }
  return plan_;
}

StepContext World::context() {
  StepContext c;
  c.dt = static_cast<Real>(desc_.dt);
  c.h = static_cast<Real>(desc_.dt / desc_.substeps);
  c.substeps = desc_.substeps;
  c.step = steps_;
  c.time = time_;
  c.dimension = desc_.dimension;
  c.sleeping = desc_.sleeping;
  c.gravity = desc_.gravity;
  c.store = &store_;
  c.objects = &objects_;
  c.events = &events_;
  c.jobs = own_->jobs.get();
  c.scratch = &own_->scratch;
  return c;
}

void World::prepare_queries(Rank rank) {
  if (stepping_) throw SceneError("world: query inside a step");
  const Command command(*commands_, "world.prepare_queries", static_cast<int>(rank) - kRankCount);
  if (structure_changed_) rebuild_plan();
  StepContext c = context();
  plan_.run_queries(rank, c);
}

void World::step() {
  if (stepping_) throw SceneError("world: step() called inside a step");
  commands_->begin_step();
  if (desc_.rebuild) load_image(save_image());
  if (structure_changed_) rebuild_plan();
  StepContext c = context();
  FEDER_ASSERT(plan_.nodes().size() >= 2);  // begin and finish, whatever the systems add
  stepping_ = true;
  plan_.run(c);
  stepping_ = false;
  commands_->end_step();
  if constexpr (kAsserts) validate();
}

ObjectId World::add_force(std::string_view kind, const Params& options, ForceEntry target, std::string name,
                          TagMask tags) {
  const Command command(*commands_, "world.add_force", kind, options, target, name, tags);
  Arena& arena = store_.arena("forces");
  target.force = find_variant(force_kinds(), kind, "force kind").make(arena, options);
  options.check_all_read("force");
  return add_force(std::move(target), std::move(name), tags);
}

ObjectId World::add_force(ForceEntry entry, std::string name, TagMask tags) {
  const Command command(*commands_, "world.add_host_force", traits_of(entry.force.get()), entry, name, tags);
  if (entry.force && command.outermost()) entry.force = recorded_force(std::move(entry.force), *commands_);
  Forces& forces = store_.need<Forces>("forces");
  entry.object = objects_.add(kForceKind, static_cast<std::uint32_t>(forces.list.size()), std::move(name), tags);
  forces.list.push_back(std::move(entry));
  structure_changed_ = true;
  return forces.list.back().object;
}

void World::remove_force(ObjectId force, std::string where) {
  FEDER_ASSERT(objects_.alive(force) && objects_.kind(force) == kForceKind);
  const Command command(*commands_, "world.remove_force", force, where);
  Forces& forces = store_.need<Forces>("forces");
  for (std::size_t i = 0; i < forces.list.size(); ++i) {
    if (forces.list[i].object != force) continue;
    forces.list.erase(forces.list.begin() + static_cast<std::ptrdiff_t>(i));
    objects_.remove(force, std::move(where));
    structure_changed_ = true;
    return;
  }
}

ForceEntry* World::find_force(ObjectId force) const {
  if (Forces* forces = store_.find<Forces>())
    for (ForceEntry& f : forces->list)
      if (f.object == force) return &f;
  return nullptr;
}

void World::set_force_enabled(ObjectId force, bool enabled) {
  const Command command(*commands_, "world.set_force_enabled", force, enabled);
  if (ForceEntry* entry = find_force(force)) entry->enabled = enabled;
}

bool World::force_enabled(ObjectId force) const {
  const ForceEntry* entry = find_force(force);
  return entry && entry->enabled;
}

Energy World::energy() const {
  Energy sum;
  for (const Present& p : systems_) {
    const Energy e = p.system->energy(desc_.gravity);
    sum.kinetic += e.kinetic, sum.potential += e.potential, sum.elastic += e.elastic;
  }
  return sum;
}

Momentum World::momentum() const {
  Momentum sum;
  for (const Present& p : systems_) {
    const Momentum m = p.system->momentum();
    for (int i = 0; i < 3; ++i) sum.linear[i] += m.linear[i], sum.angular[i] += m.angular[i];
  }
  return sum;
}

std::vector<Residual> World::residuals() const {
  std::vector<Residual> all;
  for (const Present& p : systems_) p.system->residuals(all);
  return all;
}

bool World::is_finite() const {
  for (const Present& p : systems_)
    if (!p.system->finite()) return false;
  // numbers that are finite one by one may have an energy that is not
  const Energy e = energy();
  return std::isfinite(e.kinetic) && std::isfinite(e.potential) && std::isfinite(e.elastic);
}

std::uint64_t World::hash() const {
  Hash h;
  h.add(steps_);
  for (const Present& p : systems_) p.system->hash(h);
  return h.value();
}

std::vector<KindCount> World::counts() const {
  std::vector<KindCount> rows;
  for (const SystemDescriptor* d : catalog_) {
    for (const ObjectKind& kind : d->kinds) {
      KindCount row{kind, objects_.count(kind), nullptr, 0};
      const bool holds = &kind == d->kinds.data() && std::string_view(kind.plural()) != d->units;
      if (holds) row.parts = d;
      for (const Present& p : systems_)
        if (holds && p.descriptor == d) row.part_count = p.system->count();
      rows.push_back(row);
    }
  }
  rows.push_back({kForceKind, objects_.count(kForceKind), nullptr, 0});
  return rows;
}

std::vector<SystemReport> World::report() const {
  std::vector<SystemReport> rows;
  for (const Present& p : systems_) {
    SystemReport r{p.descriptor->name, p.descriptor->units, p.system->count(), 0, {}};
    std::vector<Note> notes;
    p.system->notes(notes);
    for (const Note& note : notes) r.notes.push_back(objects_.describe(note.object) + ": " + note.text);
    for (const auto& a : store_.arenas())
      if (a->name() == r.name) r.bytes = a->bytes();
    rows.push_back(std::move(r));
  }
  return rows;
}

std::size_t World::bytes() const {
  std::size_t sum = objects_.bytes();
  for (const auto& a : store_.arenas()) sum += a->bytes();
  return sum;
}

std::uint64_t World::allocations() const {
  std::uint64_t sum = 0;
  for (const auto& a : store_.arenas()) sum += a->allocations();
  return sum;
}

}  // namespace feder
