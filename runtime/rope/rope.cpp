// The rope system: descriptions are checked, ropes made and destroyed, and the passes listed.
#include "feder/rope.h"

#include <cmath>

#include "forces/area.h"
#include "rope/impl.h"

namespace feder {
namespace {

constexpr std::size_t kMaxPoints = 1u << 20;

void need(bool ok, const std::string& owner, const std::string& what, const char* expected, double got) {
  if (!ok) throw SceneError(owner + ": " + what + ": expected " + expected + ", got " + std::to_string(got));
}

void check_rope(const RopeDesc& d, const std::string& owner) {
  const auto positive = [](Real x) { return x > 0 && is_finite(x); };
  const auto not_negative = [](Real x) { return x >= 0 && is_finite(x); };
  need(d.points.size() >= 2, owner, "points", "at least 2", static_cast<double>(d.points.size()));
  need(d.points.size() <= kMaxPoints, owner, "points", "at most 2^20", static_cast<double>(d.points.size()));
  for (std::size_t i = 0; i < d.points.size(); ++i) {
    const std::string what = "points[" + std::to_string(i + 1) + "]";
    need(is_finite(d.points[i]), owner, what, "finite numbers", double(d.points[i][0]));
    if (i == 0) continue;
    const Vec3 e = d.points[i] - d.points[i - 1];
    need(length(e) > 0, owner, what, "another place than that of the point before it", double(d.points[i][0]));
  }
  need(is_finite(d.velocity), owner, "velocity", "finite numbers", double(d.velocity[0]));
  need(positive(d.radius), owner, "radius", "a number above 0", double(d.radius));
  need(positive(d.density), owner, "density", "a number above 0", double(d.density));
  need(positive(d.stretch), owner, "stretch", "a number above 0", double(d.stretch));
  need(not_negative(d.bend), owner, "bend", "a finite number, 0 or more", double(d.bend));
  need(not_negative(d.damping), owner, "damping", "a finite number, 0 or more", double(d.damping));
  need(not_negative(d.drag), owner, "drag", "a finite number, 0 or more", double(d.drag));
  need(not_negative(d.friction), owner, "friction", "a finite number, 0 or more", double(d.friction));
  need(is_finite(d.gravity_scale), owner, "gravity_scale", "a finite number", double(d.gravity_scale));
  need(d.substeps >= 0 && d.substeps <= 1000, owner, "substeps", "a whole number from 0 to 1000", d.substeps);
  for (const std::uint32_t i : d.pins)
    need(i < d.points.size(), owner, "pins", "point numbers from 1 to the number of points", double(i) + 1);
}

}  // namespace

Rope::Impl::Impl(SystemSetup& s)
    : arena(s.store.arena(kName)), store(s.store), objects(s.objects), commands(s.commands), events(s.events),
      watched(s.store.need<Watch>("watch")), structure_changed(s.structure_changed),
      air_density(still_air_density(s.world)), surfaces(s.store.need<Surfaces>("contact")) {}

const SystemDescriptor& Rope::descriptor() {
  static const char* const needs[] = {"contact"};
  static constexpr ObjectKind kinds[] = {kRopeKind};
  static constexpr WakeCause causes[] = {kRopeCause};
  static const SystemDescriptor d = {.name = kName,
                                     .units = "points",
                                     .unit = "point",
                                     .needs = needs,
                                     .shows = "surface",
                                     .kinds = kinds,
                                     .causes = causes,
                                     .make = &make_system<Rope>};
  return d;
}

Rope::Rope(SystemSetup& setup) : impl_(std::make_unique<Impl>(setup)) {}
Rope::~Rope() = default;

void Rope::add_passes(StepPlan& plan) {
  Impl* m = impl_.get();
  m->drain_wakes();
  if (m->lines.empty()) return;
  std::size_t count = 0;
  if (const Forces* forces = m->store.find<Forces>()) count = forces->list.size();
  if (count != m->force_count)
    for (auto& l : m->lines) m->wake(*l, WakeCause::force, {});
  m->force_count = count;
  plan.add<&Impl::show>(Rank::net_surface, "surfaces", kName, m);
  plan.add<&Impl::gather>(Rank::cloth_gather, "gather", kName, m);
  if (m->store.find<SolverBodies>()) plan.add<&Impl::remember_bodies>(Rank::body_forces, "remember bodies", kName, m);
  plan.add<&Impl::begin_substep>(Rank::cloth_forces, "forces", kName, m);
  plan.add<&Impl::advance>(Rank::cloth_integrate, "advance", kName, m);
  plan.add<&Impl::read_velocities>(Rank::cloth_velocities, "velocities", kName, m);
  plan.add<&Impl::wake_touched>(Rank::cloth_wake, "wake", kName, m);
  plan.add<&Impl::commit>(Rank::commit, "commit", kName, m);
}

// Masses, of half the segments at each point, stay as they are.
void Line::derive() {
  const std::uint32_t n = size();
  rest.resize(n), edges.clear(), acceleration.assign(n, Vec3::Zero());
  total_mass = full_length = 0;
  any_pin = false;
  for (std::uint32_t i = 0; i < n; ++i) {
    rest[i] = Vec3(full_length, 0, 0);
    total_mass += mass[i];
    any_pin = any_pin || inv_mass[i] == 0;
    if (i + 1 == n) break;
    full_length += rest_length[i];
    edges.push_back({i, i + 1});
  }
}

ObjectId Rope::add_rope(const RopeDesc& desc) {
  const Command command(impl_->commands, "rope.add_rope", desc);
  const std::string owner = desc.name.empty() ? "rope" : "rope '" + desc.name + "'";
  check_rope(desc, owner);
  Impl& m = *impl_;
  const auto n = static_cast<std::uint32_t>(desc.points.size());
  auto l = std::make_unique<Line>(m.arena);
  l->settings = {desc.radius,   desc.density,       desc.stretch, desc.bend, desc.damping,        desc.drag,
                 desc.friction, desc.gravity_scale, desc.group,   desc.mask, desc.self_collision, desc.substeps};
  l->position.assign(desc.points.begin(), desc.points.end());
  l->velocity.assign(n, desc.velocity);
  l->script_force.assign(n, Vec3::Zero());
  l->mass.assign(n, 0);
  l->point_force.assign(n, Vec3::Zero()), l->segment_force.assign(n - 1, Vec3::Zero());
  const Real per_length = Real(3.14159265358979) * desc.radius * desc.radius * desc.density;
  for (std::uint32_t i = 0; i + 1 < n; ++i) {
    l->rest_length.push_back(length(Vec3(desc.points[i + 1] - desc.points[i])));
    const Real half = Real(0.5) * per_length * l->rest_length[i];
    l->mass[i] += half, l->mass[i + 1] += half;
  }
  for (const Real mass : l->mass) {
    need(mass > 0 && is_finite(1 / mass), owner, "density", "points heavier than nothing", double(mass));
    l->inv_mass.push_back(1 / mass);
  }
  const auto hold = [&](std::uint32_t i) { l->inv_mass[i] = 0, l->velocity[i] = Vec3::Zero(); };
  for (const std::uint32_t i : desc.pins) hold(i);
  const bool clamps[2] = {desc.clamp_first, desc.clamp_last};
  for (int k = 0; k < 2; ++k) {
    if (!clamps[k]) continue;
    hold(k ? n - 1 : 0);
    l->state.clamped[k] = 1;
    const std::uint32_t i = k ? n - 2 : 0;
    const Vec3 d = normalized_or(Vec3(l->position[i + 1] - l->position[i]), Vec3(0, 1, 0));
    for (int j = 0; j < 3; ++j) l->state.direction[k][j] = d[j];
  }
  l->derive();

  // nothing can fail from here on
  l->object = m.objects.add(kRopeKind, static_cast<std::uint32_t>(m.lines.size()), desc.name, desc.tags);
  m.lines.push_back(std::move(l));
  m.declare_surfaces();
  *m.structure_changed = true;
  return m.lines.back()->object;
}

void Rope::destroy_rope(ObjectId id, std::string where) {
  const Command command(impl_->commands, "rope.destroy_rope", id, where);
  Impl& m = *impl_;
  const std::uint32_t index = m.objects.index(id);
  FEDER_ASSERT(index < m.lines.size() && m.lines[index]->object == id);
  m.lines.erase(m.lines.begin() + index);
  for (std::uint32_t k = index; k < m.lines.size(); ++k) m.objects.set_index(m.lines[k]->object, k);
  m.declare_surfaces();
  m.surfaces.forget();
  m.objects.remove(id, std::move(where));
  *m.structure_changed = true;
}

void Rope::Impl::declare_surfaces() {
  bool self = false;
  for (const auto& l : lines) self = self || l->settings.self_collision;
  surfaces.declare({kName, static_cast<std::uint32_t>(lines.size()), true, self, false});
}

}  // namespace feder
