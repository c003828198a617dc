// Cells are runs of real worlds with one net by an integrator. Each step looks for non-finite and runaway states, so
// that a failure has a time and a point; the verdict on energies and errors follows at the end. Limits: see limit().
#include <algorithm>

#include "integrate/integrator.h"
#include "integrate/limits.h"
#include "study/stability_problem.h"

namespace feder {
namespace {

// Adaptive and Krylov methods may spend so much within one step of a cell, then they count as slow.
constexpr double kEffort = 32;
// Limits: h w from .. to, and the growth that is taken for rounding.
constexpr double kFirst = 0.1, kLast = 1e4, kRounding = 16 * static_cast<double>(kEpsilon);

// One net in a world of its own.
struct Trial {
  Trial(const StabilityScene& scene, const std::string& method, bool single_steps = false)
      : world(net_world(scene), net_catalog()) {
    NetDesc d = scene.net;
    d.integrator = method;
    Arena unused("stability");
    const IntegratorInfo info = find_variant(integrators(), method, "integrator").make(unused, Params())->info();
    implicit = info.implicit;
    if (info.effort_option) d.integrator_options.set(info.effort_option, kEffort);
    if (info.adaptive && single_steps) d.integrator_options.set("adaptive", false);
    net = springs().add_net(d);
    for (const std::size_t p : scene.pins) springs().pin(net, p);
    points = scene.net.points.size();
  }
  Springs& springs() { return world.need<Springs>(); }
  Vec3d position(std::size_t i) { return springs().point(net, i).cast<double>(); }
  Vec3d velocity(std::size_t i) { return springs().velocity(net, i).cast<double>(); }
  bool quarantined() { return springs().quarantined(net); }

  World world;
  ObjectId net;
  std::size_t points = 0;
  bool implicit = false;
};

// Fills verdict, time and entity when a point is non-finite or gone. `largest` gets the fastest point.
bool failed(Trial& t, const StabilityScene& s, const StabilityThresholds& limits, double energy, StabilityCell& cell) {
  std::size_t worst = 0;
  double far = -1, fast = 0;
  bool finite = !t.quarantined();
  for (std::size_t i = 0; i < t.points && finite; ++i) {
    const Vec3d x = t.position(i), v = t.velocity(i);
    finite = std::isfinite(x.norm()) && std::isfinite(v.norm());
    if (!finite || x.norm() > far) worst = i, far = x.norm();
    fast = std::max(fast, v.norm());
  }
  const double size = std::max(s.length, static_cast<double>(t.points));
  if (!finite)
    cell.verdict = t.implicit ? Verdict::nan : Verdict::diverged;
  else if (far > limits.far * size || fast > limits.fast * s.speed || !(energy <= limits.energy * s.energy))
    cell.verdict = Verdict::diverged;
  else
    return false;
  cell.t_fail = t.world.time();
  cell.entity = failed_entity(t.world, t.world.objects().describe(t.net) + ", point " + std::to_string(worst + 1));
  return true;
}

// The fastest mode of a linear scene is an oscillator of its own: its matrix, from one step of a world that starts with
// that mode's displacement and of one that starts with its velocity.
StepMatrix mode_matrix(const NetStability& problem, const std::string& method, double z, double y) {
  double out[2][2];
  for (int column = 0; column < 2; ++column) {
    StabilityScene s = problem.scene(problem.x_of(z, y), y, true);
    const std::vector<Vec3> mode = s.net.points;
    const double w = s.frequency;
    if (column == 1) {
      for (Vec3& p : s.net.points) s.net.velocities.push_back(p * static_cast<Real>(w)), p = Vec3::Zero();
    }
    Trial t(s, method, true);
    t.world.step();
    double x = 0, v = 0, norm = 0;
    for (std::size_t i = 0; i < t.points; ++i) {
      const Vec3d m = mode[i].cast<double>();
      x += m.dot(t.position(i));
      v += m.dot(t.velocity(i)) / w;
      norm += m.squaredNorm();
    }
    const bool bad = t.quarantined();
    out[0][column] = bad ? INFINITY : x / norm, out[1][column] = bad ? INFINITY : v / norm;
  }
  return {out[0][0], out[0][1], out[1][0], out[1][1]};
}

// Methods that remember are run: does the mode grow twofold, or by 5 % at the end of 4000 steps?
bool grows(const NetStability& problem, const std::string& method, double z, double y) {
  constexpr int kSteps = 4000, kWindow = 200;  // largest of a window: displacements beat with the step
  Trial t(problem.scene(problem.x_of(z, y), y, true), method, true);
  double first = 0, last = 0;
  for (int k = 0; k < kSteps; ++k) {
    t.world.step();
    double size = 0;
    for (std::size_t i = 0; i < t.points; ++i)
      size = std::max(size, static_cast<double>(length(t.springs().point(t.net, i))));
    if (t.quarantined() || !std::isfinite(size)) return true;
    if (k < kWindow) first = std::max(first, size);
    if (k >= kSteps - kWindow) last = std::max(last, size);
    if (k > kWindow && size > 2 * first) return true;
  }
  return last > 1.05 * first;
}

bool remembers(const std::string& method) {
  Arena arena("stability");
  const auto m = find_variant(integrators(), method, "integrator").make(arena, Params());
  step_matrix(*m, 1, 0);
  return !m->memory.points.empty() || !m->memory.numbers.empty();
}

}  // namespace

std::vector<StabilityMethod> NetStability::methods() const {
  std::vector<StabilityMethod> all;
  Arena unused("stability");
  for (const Variant<Integrator>& row : integrators()) {
    const IntegratorInfo info = row.make(unused, Params())->info();
    all.push_back({row.name, info.order, info.implicit});
  }
  return all;
}

StabilityCell NetStability::cell(const std::string& method, double x, double y,
                                 const StabilityThresholds& limits) const {
  return checked_cell(x, y, [&](StabilityCell& cell) { run(scene(x, y, false), method, limits, cell); });
}

void NetStability::run(const StabilityScene& s, const std::string& method, const StabilityThresholds& limits,
                       StabilityCell& cell) const {
  Trial t(s, method);
  const double h = static_cast<double>(static_cast<Real>(s.h));
  StabilityTrace trace;
  std::vector<Vec3d> exact;
  double most = 0;
  std::uint64_t solves = 0, misses = 0, missed_steps = 0;
  int done = 0;
  for (; done < s.steps; ++done) {
    t.world.step();

    // solves of this step
    const IntegratorStats stats = t.springs().stats(t.net);
    cell.iters_max =
        std::max(std::isnan(cell.iters_max) ? 0 : cell.iters_max, static_cast<double>(stats.linear_solves - solves));
    solves = stats.linear_solves;
    missed_steps += stats.unconverged > misses;
    misses = stats.unconverged;

    // energy, and whether it is over
    const double energy = total_energy(t.world) + s.energy_zero;
    most = std::max(most, energy);
    trace.energy.push_back(energy);
    if (failed(t, s, limits, energy, cell)) break;

    // error and displacement, where the reference is known
    double exact_energy = NAN;
    const bool known = reference(cell.x, cell.y, (done + 1) * h, exact, exact_energy);
    if (!std::isnan(exact_energy)) trace.exact_energy.push_back(exact_energy);
    if (!known) continue;
    double error = 0;
    for (std::size_t i = 0; i < t.points; ++i) {
      const Vec3d at = t.position(i), start = s.net.points[i].cast<double>();
      error = std::max(error, (at - exact[i]).norm());
      trace.displacement = std::max(trace.displacement, (at - start).norm());
      trace.reference_displacement = std::max(trace.reference_displacement, (exact[i] - start).norm());
    }
    if (done + 1 == s.error_step) cell.error = error / s.length;
  }
  cell.energy_ratio = most / s.energy;
  cell.iters_mean = static_cast<double>(solves) / std::max(1, done);
  cell.missed = static_cast<double>(missed_steps) / std::max(1, done);
  if (std::isnan(cell.t_fail)) cell.verdict = verdict_of(trace, s.length, s.energy, limits, cell);
}

StabilityLimit NetStability::limit(const std::string& method, double y) const {
  const Variant<Integrator>& row = find_variant(integrators(), method, "integrator");
  Arena unused("stability");
  const IntegratorInfo info = row.make(unused, Params())->info();
  StabilityLimit out;
  out.y = y;
  const double zeta = single_oscillator() ? y : scene(1, y, true).damping_ratio;
  out.z_predicted = predicted_limit(info, zeta);
  if (single_oscillator()) {
    out.z_observed = observed_limit(row, Params(), zeta);
  } else {
    const bool long_runs = remembers(method);
    const auto unstable = [&](double z) {
      return long_runs ? grows(*this, method, z, y) : mode_matrix(*this, method, z, y).excess() > kRounding * (1 + z);
    };
    out.z_observed = kFirst;
    double below = kFirst;
    while (out.z_observed <= kLast && !unstable(out.z_observed)) below = out.z_observed, out.z_observed *= 1.25;
    double above = out.z_observed;
    if (above > kLast)
      out.z_observed = static_cast<double>(kInfinity);
    else if (above == kFirst)
      out.z_observed = 0;
    else {
      while (above - below > 1e-4 * above) {
        const double middle = (below + above) / 2;
        (unstable(middle) ? above : below) = middle;
      }
      out.z_observed = (below + above) / 2;
    }
  }
  const auto x = [&](double z) { return std::isfinite(z) ? x_of(z, y) : z; };
  out.predicted = x(out.z_predicted), out.observed = x(out.z_observed);
  return out;
}

std::string NetStability::limit_how() const {
  return single_oscillator() ? "from the matrix of one step, its determinant and trace bisected to rounding"
                             : "from the matrix of one step of the net on its fastest mode, the step bisected to 1e-4; "
                               "methods that remember are run for 4000 steps. rk45 takes single steps";
}

}  // namespace feder
