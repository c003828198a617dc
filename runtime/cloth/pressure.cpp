// Gas in a closed mesh: an overpressure p that does not depend on the volume (a gas with a supply, as a balloon has
// while it is blown up), as forces p n A/3 at the corners of each triangle of area A. They are the gradient of the
// enclosed volume, so a closed mesh gets no momentum and no angular momentum of them: sums are in double, and what
// rounding to Real leaves of a vertex goes to the next one. Forces are taken at the start of each solver substep; they
// are explicit and have a stiffness of both signs, w^2 <= max p (sum of the edges round a vertex)/(6 m), which sets a
// least number of solver substeps. p is cut, with a warning, to what max_substeps allows, and to what the skin carries:
// its tension grows with the radius R as p R/2 does, so beyond p R/2 of a third of its stiffness it would grow on and
// on. There is no suction: a skin that crosses itself would grow by it without end. A mesh with a hole holds no gas.
// Kept between steps: nothing but the setting. Weak spot: one thread; R is that of a sphere, 3 V/A, whatever the shape.
#include <algorithm>
#include <cmath>

#include "cloth/impl.h"
#include "feder/error.h"

namespace feder {
namespace {
constexpr double kGasShare = 0.1;    // h^2 w^2 that is wanted
constexpr double kGasLimit = 1;      // and the largest
constexpr double kSkinShare = 0.25;  // largest p R/2 at rest, of the stretch stiffness

// Six times the volume between the triangles and their mean vertex.
template <class Position>
double six_volumes(const ClothMesh& m, std::uint32_t points, Position&& x) {
  Double3 middle{0, 0, 0};
  for (std::uint32_t i = 0; i < points; ++i) middle = middle + (1.0 / points) * x(i);
  double sum = 0;
  for (std::size_t t = 0; t < m.triangles.size(); t += 3)
    sum += dot(x(m.triangles[t]) - middle, cross(x(m.triangles[t + 1]) - middle, x(m.triangles[t + 2]) - middle));
  return sum;
}
}  // namespace

// Largest sum of opposite edges over mass, in the shape now.
void Cloth::Impl::measure_gas(Sheet& s) {
  ClothGas& g = s.gas;
  if (g.version != s.version) {
    s.bend_step = -1;
    g.version = s.version;
    g.closed = std::none_of(s.mesh.edges.begin(), s.mesh.edges.end(),
                            [](const ClothEdge& e) { return e.triangle[1] == kNone; });
    const auto rest = [&](std::uint32_t i) { return wide(vertices.rest[s.first + i]); };
    const double volume = six_volumes(s.mesh, s.points, rest) / 6;
    g.outward = volume < 0 ? -1 : 1;
    g.rest_volume = std::fabs(volume);
    // p R/2 of a sphere of as much volume per area
    double area = 0;
    for (std::size_t t = 0; t < s.mesh.triangles.size(); t += 3) {
      const std::uint32_t* v = &s.mesh.triangles[t];
      area += 0.5 * length(cross(rest(v[1]) - rest(v[0]), rest(v[2]) - rest(v[0])));
    }
    const ClothStiffness& k = s.settings.stiffness;
    g.skin = 2 * kSkinShare * double(std::min(k.along(), k.across())) * area / (3 * g.rest_volume);
  }
  gas_force.assign(s.points, Double3{0, 0, 0});
  for (std::size_t t = 0; t < s.mesh.triangles.size(); t += 3) {
    const std::uint32_t* v = &s.mesh.triangles[t];
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = s.first + v[(k + 1) % 3], b = s.first + v[(k + 2) % 3];
      gas_force[v[k]].x += double(length(current_position(b) - current_position(a)));
    }
  }
  g.rate = 0;
  for (std::uint32_t i = 0; i < s.points; ++i)
    g.rate = std::fmax(g.rate, gas_force[i].x * double(vertices.inv_mass[s.first + i]) / 6);
}

void Cloth::Impl::check_pressure(Sheet& s, StepContext& c) {
  measure_gas(s);
  if (s.gas.closed || s.state.warned_lost) return;
  s.state.warned_lost = 1;
  const auto holes = std::count_if(s.mesh.edges.begin(), s.mesh.edges.end(),
                                   [](const ClothEdge& e) { return e.triangle[1] == kNone; });
  c.events->warn("pressure_lost",
                 objects.describe(s.object) + ": its pressure of " + print_number(double(s.settings.pressure)) +
                     " Pa is lost: the mesh is open at " + std::to_string(holes) +
                     " edges; expected a closed one, each edge between two triangles",
                 s.object);
}

double Cloth::Impl::gas_substeps(const Sheet& s, Real h) const {
  if (!s.gas.closed) return 1;
  return double(h) * std::sqrt(double(s.settings.pressure) * s.gas.rate / kGasShare);
}

// The pressure of this substep, and what else acts on the vertices in it.
void Cloth::Impl::begin_pressure(Sheet& s, StepContext& c) {
  ClothGas& g = s.gas;
  g.pressure = 0;
  if (s.settings.pressure == 0) return;
  measure_gas(s);
  if (!g.closed || !std::isfinite(g.rate)) return;
  const double asked = double(s.settings.pressure), h = double(group_of(s).step);
  const double carried = g.rate > 0 ? kGasLimit / (h * h * g.rate) : double(kInfinity);
  const double most = std::fmin(carried, g.skin);
  g.pressure = g.outward * std::fmin(asked, most);
  if (asked > most && !s.state.warned_pressure) {
    s.state.warned_pressure = 1;
    const double needed = std::ceil(double(c.h) * std::sqrt(asked * g.rate / kGasLimit));
    const std::string cause = carried < g.skin
                                  ? std::to_string(group_of(s).steps) +
                                        " solver substeps carry: max_substeps = " + print_number(needed) +
                                        ", a coarser or a heavier mesh would do"
                                  : "its skin carries without growing on and on: a larger stretch would do";
    c.events->warn("pressure_cap",
                   objects.describe(s.object) + ": its pressure of " + print_number(asked) + " Pa acts as " +
                       print_number(most) + " Pa, the most that " + cause,
                   s.object);
  }
  g.outer.assign(acceleration.begin() + s.first, acceleration.begin() + s.first + s.points);
}

// Accelerations of the solver substep that begins.
void Cloth::Impl::push_gas(Sheet& s, Real h) {
  ClothGas& g = s.gas;
  FEDER_ASSERT(g.outer.size() == s.points && g.closed);
  gas_force.assign(s.points, Double3{0, 0, 0});
  const double sixth = g.pressure / 6;
  const auto edge = [&](std::uint32_t a, std::uint32_t b) {
    return (wide(vertices.position[b]) - wide(vertices.position[a])) +
           (wide(delta_position[b].vec()) - wide(delta_position[a].vec()));
  };
  for (std::size_t t = 0; t < s.mesh.triangles.size(); t += 3) {
    const std::uint32_t* v = &s.mesh.triangles[t];
    const std::uint32_t a = s.first + v[0];
    const Double3 third = sixth * cross(edge(a, s.first + v[1]), edge(a, s.first + v[2]));
    for (int k = 0; k < 3; ++k) gas_force[v[k]] = gas_force[v[k]] + third;
  }
  Double3 left{0, 0, 0};  // N, of the vertices before
  g.momentum = Double3{0, 0, 0};
  for (std::uint32_t i = 0; i < s.points; ++i) {
    const std::uint32_t at = s.first + i;
    const double w = double(delta_position[at].w), mass = double(vertices.mass[at]);
    if (w == 0) continue;
    const Double3 total = gas_force[i] + left;
    acceleration[at] = g.outer[i] + narrow(w * total);
    left = total - mass * (wide(acceleration[at]) - wide(g.outer[i]));
    g.momentum = g.momentum + mass * (wide(velocity[at].vec()) + double(h) * wide(acceleration[at]));
  }
}

// Large kicks every solver substep make rounding of velocities drift: the mean is set right, after the solver and
// before contacts; what rounding takes of a vertex goes to the next one.
void Cloth::Impl::keep_momentum(Sheet& s, Real h) {
  Double3 off = -s.gas.momentum;
  for (std::uint32_t i = s.first; i < s.first + s.points; ++i)
    off = off + (double(vertices.mass[i]) / double(h)) * (wide(delta_position[i].vec()) - wide(before[i].vec()));
  const Double3 back = (-double(h) / double(s.mass)) * off;
  Double3 left{0, 0, 0};  // kg m
  for (std::uint32_t i = s.first; i < s.first + s.points; ++i) {
    const double m = double(vertices.mass[i]);
    const Double3 to = wide(delta_position[i].vec()) + back + (1 / m) * left;
    delta_position[i].set(narrow(to));
    left = m * (to - wide(delta_position[i].vec()));
  }
}

double Cloth::volume(ObjectId id) const {
  const Sheet& s = impl_->sheet(id);
  const Impl& m = *impl_;
  const auto now = [&](std::uint32_t i) { return wide(m.vertices.position[s.first + i]); };
  const auto rest = [&](std::uint32_t i) { return wide(m.vertices.rest[s.first + i]); };
  return six_volumes(s.mesh, s.points, now) / (six_volumes(s.mesh, s.points, rest) < 0 ? -6 : 6);
}

Real Cloth::pressure(ObjectId id) const { return impl_->sheet(id).settings.pressure; }

void Cloth::set_pressure(ObjectId id, Real pressure) {
  const Command command(impl_->commands, "cloth.set_pressure", id, pressure);
  Sheet& s = impl_->sheet(id);
  if (!(pressure >= 0 && is_finite(pressure)))
    throw SceneError(impl_->objects.describe(id) + ": pressure: expected a finite number of Pa, 0 or more, got " +
                     print_number(double(pressure)));
  impl_->wake(s, WakeCause::script, {});
  s.settings.pressure = pressure;
  s.bend_step = -1;
  s.state.warned_pressure = 0;
}

}  // namespace feder
