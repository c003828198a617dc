// The cloth system: descriptions are checked, cloths made and destroyed, and the passes listed.
#include "feder/cloth.h"

#include <algorithm>
#include <cmath>

#include "cloth/impl.h"
#include "feder/error.h"
#include "forces/area.h"
#include "forces/forces.h"
#include "state/cloth_vertices.h"
#include "state/surface.h"
#include "step/watch.h"

namespace feder {
namespace {

constexpr std::uint32_t kMaxVertices = 1u << 24;

void need(bool ok, const std::string& what, const char* expected, double got) {
  if (!ok) throw SceneError("cloth: " + what + ": expected " + expected + ", got " + std::to_string(got));
}

void check_numbers(const ClothDesc& d) {
  const auto positive = [](Real x) { return x > 0 && is_finite(x); };
  const auto not_negative = [](Real x) { return x >= 0 && is_finite(x); };
  if (d.nx == 0) {
    check_mesh(d.vertices, d.triangles);
    need(d.vertices.size() <= kMaxVertices, "vertices", "at most 2^24", static_cast<double>(d.vertices.size()));
  } else {
    need(positive(d.size[0]), "size[1]", "a number above 0", d.size[0]);
    need(positive(d.size[1]), "size[2]", "a number above 0", d.size[1]);
    need(d.nx >= 2, "resolution[1]", "at least 2 vertices", d.nx);
    need(d.ny >= 2, "resolution[2]", "at least 2 vertices", d.ny);
    need(double(d.nx) * double(d.ny) <= kMaxVertices, "resolution", "at most 2^24 vertices",
         double(d.nx) * double(d.ny));
  }
  need(is_finite(d.pose.position), "position", "finite numbers", d.pose.position[0]);
  const Quat& q = d.pose.rotation;
  need(is_finite(q.vec()) && is_finite(q.w) && is_unit(q), "rotation", "a quaternion of length 1", q.w);
  need(is_finite(d.velocity), "velocity", "finite numbers", d.velocity[0]);
  need(positive(d.area_density), "area_density", "a number above 0", d.area_density);
  need(positive(d.stretch), "stretch", "a number above 0", d.stretch);
  need(d.shear < 0 || is_finite(d.shear), "shear", "a finite number", d.shear);
  need(not_negative(d.bend), "bend", "a finite number, 0 or more", d.bend);
  need(not_negative(d.damping), "damping", "a finite number, 0 or more", d.damping);
  if (d.inside != "guard" && d.inside != "ignore")
    throw SceneError("cloth: inside: expected 'guard' or 'ignore', got '" + d.inside + "'");
  need(positive(d.thickness), "thickness", "a number above 0", d.thickness);
  need(not_negative(d.friction), "friction", "a finite number, 0 or more", d.friction);
  need(not_negative(d.drag), "drag", "a finite number, 0 or more", d.drag);
  need(not_negative(d.lift), "lift", "a finite number, 0 or more", d.lift);
  need(d.tear_strain > 0, "tear_strain", "a number above 0", d.tear_strain);
  need(d.warp < 0 || positive(d.warp), "warp", "a number above 0", d.warp);
  need(d.weft < 0 || positive(d.weft), "weft", "a number above 0", d.weft);
  need(is_finite(d.warp_axis) && length(d.warp_axis) > Real(1e-6), "warp_axis", "a direction, longer than 0",
       length(d.warp_axis));
  need(not_negative(d.pressure), "pressure", "a finite number, 0 or more", d.pressure);
  need(d.yield >= 0, "plastic.yield", "a number, 0 or more", d.yield);
  need(not_negative(d.flow), "plastic.flow", "a finite number, 0 or more", d.flow);
  need(d.max_strain < 0 || d.max_strain > 0, "max_strain", "a number above 0, or false", d.max_strain);
  need(d.max_strain < 0 || !(d.max_strain < d.tear_strain && d.tear_strain < kInfinity), "max_strain",
       "at least tear_strain, or no edge would ever tear", d.max_strain);
  need(is_finite(d.gravity_scale), "gravity_scale", "a finite number", d.gravity_scale);
  need(d.stretch_error < 0 || positive(d.stretch_error), "stretch_error", "a number above 0", d.stretch_error);
  need(d.substeps >= 0 && d.substeps <= 10000, "substeps", "a whole number from 0 to 10000", d.substeps);
  need(d.max_substeps >= 0 && d.max_substeps <= 10000, "max_substeps", "a whole number from 0 to 10000",
       d.max_substeps);
}

constexpr Real kAimed = Real(0.7);  // share of max_strain that rows and ties aim at: the rest is what a sweep leaves

Real max_strain_of(const ClothDesc& d) {
  if (d.max_strain > 0) return kAimed * d.max_strain;
  const bool flows = d.yield < kInfinity && d.flow > 0;
  return flows || d.tear_strain < kInfinity ? kInfinity : kAimed * Cloth::kMaxStrain;
}

// Elements of a sheet, or threads of a mesh; SceneError where shear leaves nothing of the rows.
ClothStiffness stiffness_of(const ClothDesc& d) {
  ClothStiffness k{d.stretch, d.shear < 0 ? d.stretch / 10 : d.shear, d.bend, d.warp, d.weft};
  if (!k.woven()) return k;
  if (d.shear < 0) k.shear = std::min(k.along(), k.across()) / 10;
  const Vec3 axis = normalized_or(d.warp_axis, Vec3(1, 0, 0));
  for (int i = 0; i < 3; ++i) k.axis[i] = axis[i];
  if (d.nx == 0) return k;
  const double aspect = double(d.size[0]) / (d.nx - 1) / (double(d.size[1]) / (d.ny - 1));
  const RowStiffness rows = row_stiffness(k, aspect);
  need(rows.x >= 0 && rows.z >= 0, "shear", "less, for this warp, weft and shape of cells: threads cannot push",
       double(k.shear));
  return k;
}

// The vertices of a named side or corner; `clamped`: the name asks to hold the slope of its edges as well.
std::vector<std::uint32_t> named_vertices(const std::string& what, std::uint32_t nx, std::uint32_t ny, std::string name,
                                          bool& clamped) {
  static const char kSuffix[] = "_clamped";
  const std::string full = name;
  clamped = name.size() > sizeof kSuffix && name.ends_with(kSuffix);
  if (clamped) name.resize(name.size() - (sizeof kSuffix - 1));
  std::vector<std::uint32_t> v;
  if (nx == 0) throw SceneError(what + ": '" + full + "': only sheets have named sides; give vertex numbers");
  if (name == "top_left")
    v = {0};
  else if (name == "top_right")
    v = {nx - 1};
  else if (name == "bottom_left")
    v = {(ny - 1) * nx};
  else if (name == "bottom_right")
    v = {ny * nx - 1};
  else if (name == "top" || name == "bottom")
    for (std::uint32_t i = 0; i < nx; ++i) v.push_back((name == "top" ? 0 : (ny - 1) * nx) + i);
  else if (name == "left" || name == "right")
    for (std::uint32_t j = 0; j < ny; ++j) v.push_back(j * nx + (name == "left" ? 0 : nx - 1));
  else {
    const std::string near =
        nearest_name(name, std::vector<std::string>{"top_left", "top_right", "bottom_left", "bottom_right", "top",
                                                    "bottom", "left", "right"});
    throw SceneError(
        what + ": unknown name '" + full + "'" + (near.empty() ? "" : "; did you mean '" + near + "'?") +
        "; known: top_left, top_right, bottom_left, bottom_right, top, bottom, left, right, each with _clamped");
  }
  return v;
}

// A ghost vertex for each end of the border edges between two of the vertices: the mirror image of its inner neighbour.
void clamp_border(const ClothMesh& mesh, std::span<const std::uint32_t> clamped, std::uint32_t points,
                  std::vector<Vec3>& rest, std::vector<ClothGhost>& ghosts) {
  std::vector<char> clamp(points, 0);
  for (const std::uint32_t i : clamped) clamp[i] = 1;
  for (const ClothEdge& e : mesh.edges) {
    if (e.triangle[1] != kNone || !clamp[e.a] || !clamp[e.b]) continue;
    std::uint32_t inner[2];
    inner_neighbors(mesh, rest, e, inner);
    for (int k = 0; k < 2; ++k) {
      const std::uint32_t middle = k ? e.b : e.a;
      if (std::any_of(ghosts.begin(), ghosts.end(),
                      [&](const ClothGhost& g) { return g.clamped == middle && g.inner == inner[k]; }))
        continue;
      ghosts.push_back({middle, inner[k], points + static_cast<std::uint32_t>(ghosts.size()), Vec3::Zero()});
      rest.push_back(2 * rest[middle] - rest[inner[k]]);
    }
  }
}

}  // namespace

Cloth::Impl::Impl(SystemSetup& s)
    : arena(s.store.arena(kName)), vertices(s.store.need<ClothVertices>(kName)), store(s.store),
      watched(s.store.need<Watch>("watch")), objects(s.objects), commands(s.commands), events(s.events),
      structure_changed(s.structure_changed), air_density(still_air_density(s.world)),
      surfaces(s.store.need<Surfaces>("contact")), delta_position(surfaces.delta_position), before(surfaces.before),
      velocity(surfaces.velocity) {}

const SystemDescriptor& Cloth::descriptor() {
  static const char* const needs[] = {"contact"};
  static constexpr ObjectKind kinds[] = {kClothKind};
  static constexpr WakeCause causes[] = {kClothCause};
  static constexpr EventKind events[] = {kTear};
  static const SystemDescriptor d = {.name = kName,
                                     .units = "vertices",
                                     .unit = "vertex",
                                     .needs = needs,
                                     .shows = "surface",
                                     .kinds = kinds,
                                     .causes = causes,
                                     .events = events,
                                     .make = &make_system<Cloth>};
  return d;
}

Cloth::Cloth(SystemSetup& setup) : impl_(std::make_unique<Impl>(setup)) { impl_->owner = this; }
Cloth::~Cloth() = default;

void Cloth::add_passes(StepPlan& plan) {
  Impl* m = impl_.get();
  m->drain_wakes();
  if (m->sheets.empty()) return;
  std::size_t count = 0;
  if (const Forces* forces = m->store.find<Forces>()) count = forces->list.size();
  if (count != m->force_count)
    for (auto& s : m->sheets) m->wake(*s, WakeCause::force, {});
  m->force_count = count;
  plan.add<&Impl::prepare>(Rank::cloth_prepare, "prepare", kName, m);
  plan.add<&Impl::gather_again>(Rank::cloth_gather, "gather", kName, m);
  plan.add<&Impl::begin_substep>(Rank::cloth_forces, "forces", kName, m);
  plan.add<&Impl::advance>(Rank::cloth_integrate, "advance", kName, m);
  plan.add<&Impl::solve_body_ties>(Rank::cloth_ties, "ties to bodies", kName, m);
  plan.add<&Impl::read_velocities>(Rank::cloth_velocities, "velocities", kName, m);
  plan.add<&Impl::damp>(Rank::cloth_damp, "damping", kName, m);
  plan.add<&Impl::wake_touched>(Rank::cloth_wake, "wake", kName, m);
  plan.add<&Impl::commit>(Rank::commit, "commit", kName, m);
}

void Cloth::Impl::attach_solver(Sheet& s, const std::string& name, const Params& options) {
  s.solver = find_variant(cloth_solvers(), name, "cloth solver").make(arena, options);
  options.check_all_read(name);
  s.still_air.pick(wide_kernels(options));
  s.solver_name = name;
  s.solver_options = options;
}

void Cloth::Impl::lump_mass(Sheet& s) {
  const std::span<Real> mass(vertices.mass.data() + s.first, s.points);
  lump_masses(s.mesh, {vertices.rest.data() + s.first, s.total}, s.settings.area_density, mass);
  s.mass = 0;
  for (const Real m : mass) s.mass += m;
}

ObjectId Cloth::add_cloth(const ClothDesc& desc) {
  const Command command(impl_->commands, "cloth.add_cloth", desc);
  check_numbers(desc);
  Impl& m = *impl_;
  auto s = std::make_unique<Sheet>(m.arena);
  std::vector<Vec3> rest = desc.vertices;
  std::vector<std::uint32_t> triangles = desc.triangles;
  if (desc.nx > 0) make_sheet(desc.size, desc.nx, desc.ny, rest, triangles);
  // pins by number, settings, elements without clamps
  const auto points = static_cast<std::uint32_t>(rest.size());
  std::vector<char> pinned(points, 0);
  for (const std::uint32_t i : desc.pins) {
    need(i < points, "pins", "vertex numbers from 1 to the number of vertices", double(i) + 1);
    pinned[i] = 1;
  }
  std::vector<ClothGhost> ghosts;
  s->mesh.triangles.assign(triangles.begin(), triangles.end());
  s->mesh.grid = desc.nx;
  const ClothStiffness stiffness = stiffness_of(desc);
  const bool limit_free = desc.max_strain > 0;
  s->search_name = desc.self.empty() ? default_box_search() : desc.self;
  s->find_search();
  s->settings = {stiffness,           desc.area_density,
                 desc.damping,        desc.thickness,
                 desc.friction,       desc.drag,
                 desc.lift,           desc.tear_strain,
                 max_strain_of(desc), desc.gravity_scale,
                 desc.stretch_error,  desc.substeps,
                 desc.max_substeps,   desc.group,
                 desc.mask,           desc.self_collision,
                 desc.wind,           desc.inside == "ignore",
                 limit_free,          desc.pressure,
                 desc.yield,          desc.flow};
  make_elements(s->mesh, rest, s->settings.stiffness);
  // pins by name, with a ghost vertex for each end of a clamped border edge
  for (const std::string& name : desc.pin_names) {
    bool clamped = false;
    const std::vector<std::uint32_t> v = named_vertices("cloth: pins", desc.nx, desc.ny, name, clamped);
    for (const std::uint32_t i : v) pinned[i] = 1;
    if (!clamped) continue;
    if (v.size() == 1)  // a corner keeps its slope when its neighbours stay
      for (const ClothEdge& e : s->mesh.edges)
        if (e.a == v[0] || e.b == v[0]) pinned[e.a] = pinned[e.b] = 1;
    clamp_border(s->mesh, v, points, rest, ghosts);
  }
  s->mesh.ghosts.assign(ghosts.begin(), ghosts.end());
  if (!ghosts.empty()) make_elements(s->mesh, rest, s->settings.stiffness);
  // the solver may still refuse its options; the last vertex is the spare of empty lanes
  m.attach_solver(*s, desc.solver, desc.solver_options);
  rest.push_back(Vec3(0, 0, 0));
  FEDER_ASSERT(rest.size() == points + ghosts.size() + 1 && s->mesh.edges.size() <= s->mesh.links.size());

  // nothing can fail from here on: rows of ClothVertices
  ClothVertices& all = m.vertices;
  s->first = all.size();
  s->points = points;
  s->total = static_cast<std::uint32_t>(rest.size());
  s->object = m.objects.add(kClothKind, static_cast<std::uint32_t>(m.sheets.size()), desc.name, desc.tags);
  ClothVertices::each_array(all, [&](auto& array) { array.resize(s->first + s->total); });
  for (std::uint32_t i = 0; i < s->total; ++i) {
    const std::uint32_t at = s->first + i;
    all.rest[at] = rest[i];
    all.position[at] = to_world(desc.pose, rest[i]);
    all.velocity[at] = i < points && !pinned[i] ? desc.velocity : Vec3(0, 0, 0);
    all.mass[at] = all.inv_mass[at] = 0;
    all.cloth[at] = s->object;
    all.script_force[at] = Vec3::Zero();
  }
  m.lump_mass(*s);
  for (std::uint32_t i = 0; i < points; ++i)
    all.inv_mass[s->first + i] = pinned[i] ? Real(0) : 1 / all.mass[s->first + i];
  s->suspect = desc.nx == 0;
  m.sheets.push_back(std::move(s));
  m.declare_surfaces();
  *m.structure_changed = true;
  return m.sheets.back()->object;
}

std::vector<std::uint32_t> Cloth::named(ObjectId id, const std::string& name) const {
  const ClothMesh& mesh = impl_->sheet(id).mesh;
  // tearing adds vertices and takes no triangles
  const auto cells = static_cast<std::uint32_t>(mesh.triangles.size() / 6);
  bool clamped = false;
  auto all = named_vertices("attach", mesh.grid, mesh.grid ? cells / (mesh.grid - 1) + 1 : 0, name, clamped);
  if (clamped) throw SceneError("attach: '" + name + "': an attachment holds places, not slopes; leave _clamped out");
  return all;
}

void Cloth::destroy_cloth(ObjectId id, std::string where) {
  const Command command(impl_->commands, "cloth.destroy_cloth", id, where);
  Impl& m = *impl_;
  const std::uint32_t index = m.objects.index(id);
  FEDER_ASSERT(index < m.sheets.size() && m.sheets[index]->object == id);
  const std::uint32_t first = m.sheets[index]->first, count = m.sheets[index]->total;
  // later vertices, sheets and attachments move down
  ClothVertices::each_array(m.vertices,
                            [&](auto& array) { array.erase(array.begin() + first, array.begin() + first + count); });
  std::erase_if(m.attachments, [&](const Attachment& a) { return a.cloth == id; });
  for (Attachment& a : m.attachments)
    if (a.vertex > first) a.vertex -= count;
  m.sheets.erase(m.sheets.begin() + index);
  for (std::uint32_t k = index; k < m.sheets.size(); ++k) {
    FEDER_ASSERT(m.sheets[k]->first >= first + count);
    m.sheets[k]->first -= count;
    m.objects.set_index(m.sheets[k]->object, k);
  }
  m.declare_surfaces();
  m.surfaces.forget();
  m.objects.remove(id, std::move(where));
  *m.structure_changed = true;
}

}  // namespace feder
