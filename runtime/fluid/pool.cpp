// Particles as arrays: constants of the fluid, growing, sorting, density sums.
#include "fluid/pool.h"

#include <algorithm>
#include <cmath>

namespace feder {
namespace {

// Of the energy of a flat face of a lattice, that the surface of a drop has with color_field once its outermost layers
// have settled: by the periods of swings of 2,000 to 4,000 particles of dfsph, tests/fluid/test_droplet.cpp.
constexpr double kSettled[2] = {0.758, 1.31};

constexpr Real kFar = Real(1e9);  // m, of the sentinel; its square is finite in float

Real power(Real x, int n) {
  Real p = 1;
  for (int k = 0; k < n; ++k) p *= x;
  return p;
}

}  // namespace

FluidPool::FluidPool(Arena& a, const FluidDesc& from, int dim) : arena(a), desc(from), dimension(dim) {
  FEDER_ASSERT(dim == 2 || dim == 3);
  if (desc.surface_model.empty()) desc.surface_model = default_surface_model(desc.solver);
  if (desc.kernel.empty()) desc.kernel = default_fluid_kernel(desc.solver);
  const Kernel& named = kernel_by_name(desc.kernel);
  if (desc.viscosity_kernel.empty()) desc.viscosity_kernel = named.viscosity_name;
  kernel_with_viscosity(named, kernel_by_viscosity(desc.viscosity_kernel));
  // factors that make the sum over a lattice at rest 1
  const double in_spacings = desc.support > 0 ? static_cast<double>(desc.support) : kernel->support[dim - 2];
  support = static_cast<Real>(in_spacings) * desc.spacing;
  volume = power(desc.spacing, dim);
  mass = desc.density * volume;
  unit = volume / static_cast<Real>(lattice_sums(*kernel, dim, in_spacings).whole);
  const Real value_norm = static_cast<Real>(kernel->norm_density[dim - 2]);
  const Real slope_norm = static_cast<Real>(kernel->norm_gradient[dim - 2]);
  value_factor = unit * value_norm / power(support, dim);
  slope_factor = unit * slope_norm / power(support, dim + 2);
  viscous_factor = unit * static_cast<Real>(kernel->norm_viscosity[dim - 2]) / power(support, dim + 2);
  own_value = unit * static_cast<Real>(kernel->density.value(dim, 0)) / power(support, dim);
  // a fifth of those on a lattice: particles in one position have gradients near zero, and must not be thrown apart
  const LatticeSums lattice = lattice_sums(*kernel, dim, in_spacings);
  least_squares =
      static_cast<Real>(0.2 * lattice.squares / (lattice.whole * lattice.whole)) / (desc.spacing * desc.spacing);
  // sums over few neighbours underestimate a shear: by 5 % in 2D and 19 % in 3D while rows slide over each other, by a
  // little less where a flow has mixed them. The power is measured: the flow rates of channels in 2D and square ducts
  // in 3D are then within 5 % of the true ones, except at the very start of a flow in 3D (9 % too high until the
  // lattice breaks up)
  FEDER_ASSERT(lattice.whole > 0 && lattice.squares > 0 && lattice.viscosity > 0);
  viscous_scale = static_cast<Real>(std::pow(lattice.viscosity, -0.85));
  find_tension();
  slips = desc.wall_slip == "free";
  clearance = Real(0.1) * desc.spacing;
  table = std::make_unique<BoundaryTable>(*kernel, dim, in_spacings);
  search = find_variant(neighbor_searches(), desc.neighbors, "neighbor search").make(a, Params());
  put_sentinel();
}

// Both as they are where they are one.
void FluidPool::kernel_with_viscosity(const Kernel& named, const Kernel& viscous) {
  kernel = &named, sweeps = &sweeps_of(named);
  if (std::string_view(named.viscosity_name) == viscous.viscosity_name) return;
  mixed_kernel = named, mixed_sweeps = *sweeps;
  mixed_kernel.viscosity = viscous.viscosity, mixed_kernel.radial_viscosity = viscous.radial_viscosity;
  mixed_kernel.viscosity_name = viscous.viscosity_name;
  std::copy(viscous.norm_viscosity, viscous.norm_viscosity + 2, mixed_kernel.norm_viscosity);
  mixed_sweeps.viscous = sweeps_of(viscous).viscous, mixed_sweeps.viscous_by = sweeps_of(viscous).viscous_by;
  kernel = &mixed_kernel, sweeps = &mixed_sweeps;
}

// Cohesion by Kirkwood & Buff 1949, for particles spread evenly up to a sharp surface, n of them in a unit of space,
// that pull with F(r): sigma = n^2/3 int r^3 F dr in 2D, pi/8 n^2 int r^4 F dr in 3D; the pull inwards is pi/2 n^2 int
// r^2 F dr and 2 pi/3 n^2 int r^3 F dr. Particles do not lie evenly at a surface: drops of wcsph swing as with 0.6 of
// that tension in 2D and about 0.27 in 3D (5 to 8 spacings across a radius, widely scattered), so the force is divided
// by that: tests/fluid/test_droplet.cpp. The pull inwards is some 5 sigma/d, and R/d times 5 what makes a drop round:
// the particles are pressed together like sand, and where nothing keeps them warm (pbf damps, artificial viscosity
// does) they yield late. With pbf drops become round, with a first swing up to 1.7 times too fast, and do not swing on.
void FluidPool::find_tension() {
  const double r = support, n2 = 1 / (static_cast<double>(volume) * static_cast<double>(volume));
  const double r4 = r * r * r * r, pi = 3.14159265358979323846;
  const double unit_tension =
      dimension == 2 ? n2 / 3 * r4 * cohesion_moment(3) : n2 * pi / 8 * r4 * r * cohesion_moment(4);
  const double unit_pressure =
      dimension == 2 ? n2 * pi / 2 * r * r * r * cohesion_moment(2) : n2 * 2 * pi / 3 * r4 * cohesion_moment(3);
  FEDER_ASSERT(cohesion_moment(2) > cohesion_moment(3) && cohesion_moment(3) > cohesion_moment(4));
  const double measured = dimension == 2 ? 0.6 : 0.27;
  force_of_tension = static_cast<Real>(1 / (measured * unit_tension));
  const double force = static_cast<double>(desc.surface_tension) / (measured * unit_tension);
  cohesion = static_cast<Real>(force);
  colored = desc.surface_model == "color_field";
  inward = colored ? Real(0) : static_cast<Real>(force * unit_pressure);
  color_unit = static_cast<Real>(1 / color_sums(dimension, r / static_cast<double>(desc.spacing)).whole);
  energy_of_tension = energy_unit(desc.spacing);
  color_energy = energy_of_tension * desc.surface_tension;
  wetting = wetting_unit(desc.spacing);
}

Real FluidPool::energy_unit(Real spacing) const {
  const ColorSums sums = color_sums(dimension, static_cast<double>(support) / static_cast<double>(spacing));
  FEDER_ASSERT(sums.whole > 1 && sums.lack > 0);
  return 1 / (static_cast<Real>(kSettled[dimension - 2] * sums.lack) * spacing);
}

Real FluidPool::wetting_unit(Real spacing) const {
  const ColorSums sums = color_sums(dimension, static_cast<double>(support) / static_cast<double>(spacing));
  FEDER_ASSERT(sums.depth > 0);
  return static_cast<Real>(1 / sums.depth) / spacing;
}

void FluidPool::grow(std::uint32_t wanted) {
  if (wanted <= capacity()) return;
  std::uint32_t room = std::max<std::uint32_t>(wanted, capacity() + capacity() / 2);
  room = std::max<std::uint32_t>(wanted, static_cast<std::uint32_t>(std::min<std::size_t>(room, desc.max_particles)));
  for (auto* array : {&x, &v, &start, &move, &extra, &swap4}) array->resize(room + 1);
  for (auto* array : {&lambda, &screen, &sum, &squares, &diagonal, &ratio, &next_weight, &swap1}) array->resize(room);
  for (auto* array : {&id, &order, &swap_id}) array->resize(room);
  for (auto* array : {&origin, &listed_at, &script_force, &surface, &skew})
    if (!array->empty()) array->resize(room + 1);
  for (auto* array : {&residual, &allowed, &air, &shifts, &least, &share})
    if (!array->empty()) array->resize(room + 1);
  if (!phase.empty()) phase.resize(room);
  isolated.resize(room), inside.resize(room), contact_first.resize(room + 1);
  lists.count.resize(room), lists.rounded.resize(room);
  lists.index.resize(static_cast<std::size_t>(room) * lists.stride + 8);
  FEDER_ASSERT(room >= wanted && room <= desc.max_particles && x.size() == room + 1);
  put_sentinel();
}

void FluidPool::keep_origins() {
  if (origin.empty()) origin.resize(x.size());
}

void FluidPool::keep_listed() {
  if (listed_at.empty()) listed_at.resize(x.size());
}

void FluidPool::keep_script_forces() {
  if (script_force.empty()) script_force.resize(x.size());
}

void FluidPool::keep_solved() {
  for (auto* array : {&residual, &allowed, &air, &shifts})
    if (array->empty()) array->resize(x.size());
  if (desc.negative_pressure > 0 && least.empty()) least.resize(x.size());
  if (!images) images = std::make_unique<BoundaryImages>(arena);
}

void FluidPool::put_sentinel() {
  if (x.size() <= count) x.resize(count + 1), v.resize(count + 1), extra.resize(count + 1);
  x[count] = {kFar, kFar, kFar, 0};
  v[count] = {};
  extra[count] = {};
}

void FluidPool::add(const Vec3& position, const Vec3& velocity) {
  FEDER_ASSERT(count < capacity() && next_id != kNone);
  const std::uint32_t i = count++;
  x[i] = {position[0], position[1], position[2], 0};
  v[i] = {velocity[0], velocity[1], velocity[2], 0};
  start[i] = x[i];
  kinetic += 0.5 * static_cast<double>(mass) * static_cast<double>(dot(velocity, velocity));
  lambda[i] = 0;
  ratio[i] = 1;
  screen[i] = 0;
  if (!script_force.empty()) script_force[i] = {};
  if constexpr (kAsserts) ids_there += id_key(next_id);
  id[i] = next_id++;
  put_sentinel();
}

void FluidPool::remove_marked(const Array<std::uint8_t>& marked) {
  FEDER_ASSERT(marked.size() == count);
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (marked[i]) {
      if constexpr (kAsserts) ids_there -= id_key(id[i]);
      continue;
    }
    x[kept] = x[i], v[kept] = v[i], start[kept] = start[i], lambda[kept] = lambda[i], ratio[kept] = ratio[i],
    screen[kept] = screen[i], id[kept] = id[i];
    if (!script_force.empty()) script_force[kept] = script_force[i];
    ++kept;
  }
  count = kept;
  put_sentinel();
}

void FluidPool::sort_by_cell(JobPool& jobs, Real skin) {
  FEDER_ASSERT(skin >= 0 && count <= capacity());
  const bool identity = grid.sort({&x[0].x, 4 * std::size_t(count)}, support + skin, jobs, order);
  if (identity) return;
  FEDER_ASSERT(order.size() >= count);
  const auto reorder = [&](auto& array, auto& work) {
    FEDER_ASSERT(array.size() == work.size());
    jobs.for_blocks(count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
      for (std::uint32_t k = first; k < last; ++k) work[k] = array[order[k]];
    });
    if (work.size() > count) work[count] = array[count];  // the sentinel
    array.swap(work);
  };
  for (auto* array : {&x, &v, &start}) reorder(*array, swap4);
  for (auto* array : {&lambda, &ratio, &screen}) reorder(*array, swap1);
  for (auto* array : {&origin, &script_force, &surface})
    if (!array->empty()) reorder(*array, swap4);
  reorder(id, swap_id);
  if (!phase.empty()) reorder(phase, swap_id);
  if constexpr (kAsserts) validate_order();
}

void FluidPool::find_neighbors(JobPool& jobs, Real skin) {
  search->find({&x[0].x, 4 * std::size_t(count)}, support + skin, jobs, lists);
  if (uneven()) set_shares(jobs);
  if constexpr (kAsserts) validate_neighbors(support + skin);
}

void FluidPool::copy(const Array<Row4>& from, Array<Row4>& to, JobPool& jobs) const {
  jobs.for_blocks(count, kParticleGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    std::copy(from.begin() + first, from.begin() + last, to.begin() + first);
  });
}

SweepInput FluidPool::sweep_input() const {
  FEDER_ASSERT(x[count].x == kFar && x[count].w == 0);  // what padding of the lists points to
  FEDER_ASSERT(lists.count.size() >= count);
  SweepInput in;
  in.points = &x[0].x;
  in.velocity = &v[0].x;
  in.neighbors = lists.index.data();
  in.rounded = lists.rounded.data();
  in.stride = lists.stride;
  in.inv_support = 1 / support;
  in.soft = Real(0.0025) * support * support;  // (0.1 h)^2 with h half the support
  return in;
}

void FluidPool::find_ratios(const Boundary& boundary, JobPool& jobs) {
  if (images) images->build(*this, boundary, jobs);
  if (uneven()) find_skew(jobs);
  const SweepInput in = sweep_input();
  jobs.for_blocks(count, kFluidGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    (uneven() ? sweeps->values_by : sweeps->values)(in, first, last, sum.data());
    for (std::uint32_t i = first; i < last; ++i) {
      Real r = value_factor * sum[i] + share_of(i) * own_value + screen[i];
      if (images)
        r += images->value(i);
      else
        for (const BoundaryContact& c : contacts_of(i)) r += table_of(i).at(c.distance(x[i].vec()) / support).value;
      ratio[i] = r;
    }
  });
}

Aabb FluidPool::bounds() const {
  Aabb box;
  for (std::uint32_t i = 0; i < count; ++i) box.include(x[i].vec());
  return box;
}

Real FluidPool::max_speed() const {
  Real most = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Vec3 u = v[i].vec();
    most = std::max(most, dot(u, u));
  }
  return std::sqrt(most);
}

}  // namespace feder
