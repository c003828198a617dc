// The system of soft bodies: descriptions are checked, bodies made and destroyed, and the passes listed.
#include "feder/soft.h"

#include <cmath>

#include "soft/impl.h"

namespace feder {
namespace {

void need_soft(bool ok, const std::string& owner, const std::string& what, const char* expected, double got) {
  if (!ok) throw SceneError(owner + ": " + what + ": expected " + expected + ", got " + print_number(got));
}

void check_soft(const SoftDesc& d, const std::string& owner) {
  const auto positive = [](Real x) { return x > 0 && is_finite(x); };
  const auto not_negative = [](Real x) { return x >= 0 && is_finite(x); };
  need_soft(is_finite(d.pose.position), owner, "position", "finite numbers", double(d.pose.position[0]));
  need_soft(is_finite(d.velocity), owner, "velocity", "finite numbers", double(d.velocity[0]));
  need_soft(is_finite(d.angular_velocity), owner, "angular_velocity", "finite numbers", double(d.angular_velocity[0]));
  need_soft(positive(d.density), owner, "density", "a number above 0", double(d.density));
  need_soft(positive(d.young), owner, "young", "a number above 0", double(d.young));
  need_soft(d.poisson > -1 && d.poisson <= Real(0.499), owner, "poisson",
            "a number above -1, up to 0.499 (at 0.5 nothing could change its volume)", double(d.poisson));
  need_soft(not_negative(d.damping), owner, "damping", "a finite number, 0 or more", double(d.damping));
  need_soft(not_negative(d.thickness), owner, "thickness", "a finite number, 0 or more", double(d.thickness));
  need_soft(not_negative(d.friction), owner, "friction", "a finite number, 0 or more", double(d.friction));
  need_soft(d.yield >= 0, owner, "plastic.yield", "a number, 0 or more", double(d.yield));
  need_soft(not_negative(d.flow), owner, "plastic.flow", "a finite number, 0 or more", double(d.flow));
  need_soft(d.fracture_stress > 0, owner, "fracture_stress", "a number above 0", double(d.fracture_stress));
  need_soft(is_finite(d.gravity_scale), owner, "gravity_scale", "a finite number", double(d.gravity_scale));
  need_soft(d.substeps >= 0 && d.substeps <= 10000, owner, "substeps", "a whole number from 0 to 10000", d.substeps);
  need_soft(d.max_substeps >= 0 && d.max_substeps <= 10000, owner, "max_substeps", "a whole number from 0 to 10000",
            d.max_substeps);
}

}  // namespace

Soft::Impl::Impl(SystemSetup& s)
    : arena(s.store.arena(kName)), store(s.store), objects(s.objects), commands(s.commands), events(s.events),
      watched(s.store.need<Watch>("watch")), structure_changed(s.structure_changed),
      surfaces(s.store.need<Surfaces>("contact")) {}

const SystemDescriptor& Soft::descriptor() {
  static const char* const needs[] = {"contact"};
  static constexpr ObjectKind kinds[] = {kSoftKind};
  static constexpr WakeCause causes[] = {kSoftCause};
  static constexpr EventKind kinds_of_events[] = {kFracture};
  static const SystemDescriptor d = {.name = kName,
                                     .units = "tetrahedra",
                                     .unit = "tetrahedron",
                                     .needs = needs,
                                     .shows = "surface",
                                     .kinds = kinds,
                                     .causes = causes,
                                     .events = kinds_of_events,
                                     .make = &make_system<Soft>};
  return d;
}

Soft::Soft(SystemSetup& setup) : impl_(std::make_unique<Impl>(setup)) {}
Soft::~Soft() = default;

void Soft::add_passes(StepPlan& plan) {
  Impl* m = impl_.get();
  m->drain_wakes();
  if (m->bodies.empty()) return;
  std::size_t count = 0;
  if (const Forces* forces = m->store.find<Forces>()) count = forces->list.size();
  if (count != m->force_count)
    for (auto& b : m->bodies) m->wake(*b, WakeCause::force, {});
  m->force_count = count;
  plan.add<&Impl::show>(Rank::net_surface, "surfaces", kName, m);
  plan.add<&Impl::gather>(Rank::cloth_gather, "gather", kName, m);
  plan.add<&Impl::begin_substep>(Rank::cloth_forces, "forces", kName, m);
  plan.add<&Impl::advance>(Rank::cloth_integrate, "advance", kName, m);
  plan.add<&Impl::read_velocities>(Rank::cloth_velocities, "velocities", kName, m);
  plan.add<&Impl::wake_touched>(Rank::cloth_wake, "wake", kName, m);
  plan.add<&Impl::commit>(Rank::commit, "commit", kName, m);
}

void SoftBody::derive_mass() {
  total_mass = 0;
  any_pin = false;
  for (std::uint32_t i = 0; i < size(); ++i) total_mass += mass[i], any_pin = any_pin || inv_mass[i] == 0;
}

void SoftBody::share_mass() {
  std::fill(mass.begin(), mass.end(), Real(0));
  for (std::size_t k = 0; k < mesh.tetrahedra.size(); ++k)
    for (const std::uint32_t i : mesh.tetrahedra[k]) mass[i] += settings.density * mesh.volume[k] / 4;
}

void SoftBody::derive() {
  material = soft_material(double(settings.young), double(settings.poisson));
  ++version;
  mesh.derive();
  acceleration.assign(size(), Vec3::Zero());
  derive_mass();
}

void Soft::Impl::attach_solver(SoftBody& b, const std::string& name, const Params& options, const std::string& law,
                               const std::string& owner) {
  b.solver = find_variant(soft_solvers(), name, "solver of soft bodies").make(arena, options);
  options.check_all_read(name);
  b.law = &find_variant(elastic_laws(), law, "law of elasticity");
  if (!b.solver->takes(*b.law)) {
    const Params none;
    std::string laws, solvers;
    const auto add = [](std::string& list, const char* word) {
      list += (list.empty() ? "" : ", ") + std::string(word);
    };
    for (const ElasticLaw& l : elastic_laws())
      if (b.solver->takes(l)) add(laws, l.name);
    for (const Variant<SoftSolver>& s : soft_solvers())
      if (s.make(arena, none)->takes(*b.law)) add(solvers, s.name);
    throw SceneError(owner + ": elasticity: expected what " + name + " has (" + laws + "), got " + law +
                     (solvers.empty() ? "" : "; solvers that have it: " + solvers));
  }
  b.solver_name = name, b.solver_options = options;
}

ObjectId Soft::add_soft(const SoftDesc& desc) {
  const Command command(impl_->commands, "soft.add_soft", desc);
  const std::string owner = desc.name.empty() ? "soft" : "soft '" + desc.name + "'";
  check_soft(desc, owner);
  Impl& m = *impl_;
  auto b = std::make_unique<SoftBody>(m.arena);
  make_tetrahedra(desc, owner, b->mesh);
  const auto n = static_cast<std::uint32_t>(b->mesh.rest.size());
  b->settings = {desc.density,  desc.young,         desc.poisson, desc.damping, desc.thickness,
                 desc.friction, desc.gravity_scale, desc.group,   desc.mask,    desc.self_collision,
                 desc.substeps, desc.max_substeps,  desc.yield,   desc.flow,    desc.fracture_stress};
  if (desc.thickness == 0) b->settings.thickness = static_cast<Real>(b->mesh.mean_edge / 10);
  need_soft(b->settings.thickness > 0, owner, "points", "a skin of some size", b->mesh.mean_edge);
  if (b->settings.flows()) {
    for (std::size_t k = 0; k < 9 * b->mesh.tetrahedra.size(); ++k) b->mesh.flowed.push_back(Real(k % 9 % 4 == 0));
  }
  b->mass.assign(n, 0);
  b->share_mass();
  Double3 middle{0, 0, 0};
  double total = 0;
  for (std::uint32_t i = 0; i < n; ++i) {
    need_soft(b->mass[i] > 0 && is_finite(1 / b->mass[i]), owner, "density", "points heavier than nothing",
              double(b->mass[i]));
    b->inv_mass.push_back(1 / b->mass[i]);
    b->position.push_back(to_world(desc.pose, b->mesh.rest[i]));
    middle = middle + double(b->mass[i]) * wide(b->position[i]), total += double(b->mass[i]);
  }
  const Vec3 center = narrow((1 / total) * middle);
  for (std::uint32_t i = 0; i < n; ++i)
    b->velocity.push_back(desc.velocity + cross(desc.angular_velocity, Vec3(b->position[i] - center)));
  for (Array<Vec3>* a : {&b->script_force, &b->contact, &b->steady_contact}) a->assign(n, Vec3::Zero());
  for (const std::uint32_t i : desc.pins) {
    need_soft(i < n, owner, "pins", ("point numbers from 1 to " + std::to_string(n)).c_str(), double(i) + 1);
    b->inv_mass[i] = 0, b->velocity[i] = Vec3::Zero();
  }
  b->search_name = desc.self;
  b->find_search();
  m.attach_solver(*b, desc.solver, desc.solver_options, desc.elasticity, owner);
  if (b->settings.flows() && !b->solver->flows())
    throw SceneError(owner + ": plastic: expected a solver whose tetrahedra have shapes that flow, " + desc.solver +
                     " has springs; xpbd, vbd and implicit do");
  b->derive();

  // nothing can fail from here on
  b->object = m.objects.add(kSoftKind, static_cast<std::uint32_t>(m.bodies.size()), desc.name, desc.tags);
  m.bodies.push_back(std::move(b));
  m.declare_surfaces();
  *m.structure_changed = true;
  return m.bodies.back()->object;
}

void Soft::destroy_soft(ObjectId id, std::string where) {
  const Command command(impl_->commands, "soft.destroy_soft", id, where);
  Impl& m = *impl_;
  const std::uint32_t index = m.objects.index(id);
  FEDER_ASSERT(index < m.bodies.size() && m.bodies[index]->object == id);
  m.bodies.erase(m.bodies.begin() + index);
  for (std::uint32_t k = index; k < m.bodies.size(); ++k) m.objects.set_index(m.bodies[k]->object, k);
  m.declare_surfaces();
  m.surfaces.forget();
  m.objects.remove(id, std::move(where));
  *m.structure_changed = true;
}

void Soft::Impl::declare_surfaces() {
  bool self = false;
  for (const auto& b : bodies) self = self || b->settings.self_collision;
  surfaces.declare({kName, static_cast<std::uint32_t>(bodies.size()), true, self, true});
}

}  // namespace feder
