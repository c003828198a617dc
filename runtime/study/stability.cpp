// Cells are runs of real worlds with one net. Each step looks for non-finite and runaway states, so that a failure has a
// time and a point; energies and errors are judged at the end. Limits: see find_limit.
#include "study/stability.h"

#include <algorithm>

#include "integrate/limits.h"
#include "study/stability_problem.h"
#include "world/world.h"

namespace feder {
namespace {

// Adaptive and Krylov methods may spend so much within one step of a cell, then they count as slow.
constexpr double kEffort = 32;
constexpr int kGrowthSteps = 4000, kGrowthWindow = 200;

const SystemDescriptor* const kSprings[] = {&Springs::descriptor()};

// One net in a world of its own.
struct Trial {
  Trial(const StabilityScene& scene, const std::string& method) : world(describe(scene), kSprings) {
    NetDesc d = scene.net;
    d.integrator = method;
    Arena unused("stability");
    const IntegratorInfo info = find_variant(integrators(), method, "integrator").make(unused, Params())->info();
    implicit = info.implicit;
    if (info.effort_option) d.integrator_options.set(info.effort_option, kEffort);
    net = springs().add_net(d);
    for (const std::size_t p : scene.pins) springs().pin(net, p);
    points = scene.net.points.size();
  }
  static WorldDesc describe(const StabilityScene& scene) {
    WorldDesc d;
    d.gravity = scene.gravity, d.dt = scene.h, d.substeps = 1;
    return d;
  }
  Springs& springs() { return world.need<Springs>(); }
  double energy() {
    const Energy e = world.energy();
    return e.kinetic + e.potential + e.elastic;
  }
  double max_strain() {
    double worst = 0;
    for (std::size_t k = 0; k < springs().spring_count(net); ++k)
      worst = std::max(worst, std::fabs(static_cast<double>(springs().strain(net, k))));
    return worst;
  }

  World world;
  ObjectId net;
  std::size_t points = 0;
  bool implicit = false;
};

struct Judgement {
  std::vector<double> energy, exact_energy;  // by step, above rest
  double moved = 0, reference_moved = 0;
  std::vector<Vec3d> start, exact;
};

// Fills verdict, time and entity when a point is non-finite or gone. `largest` gets the fastest point.
bool failed(Trial& t, const StabilityScene& s, const StabilityThresholds& limits, double energy, StabilityCell& cell) {
  std::size_t worst = 0;
  double far = -1, fast = 0;
  bool finite = !t.springs().quarantined(t.net);
  for (std::size_t i = 0; i < t.points && finite; ++i) {
    const Vec3d x = t.springs().point(t.net, i).cast<double>(), v = t.springs().velocity(t.net, i).cast<double>();
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
  cell.entity = t.world.objects().describe(t.net) + ", point " + std::to_string(worst + 1);
  for (const Event& e : t.world.events().list())
    if (e.kind == EventKind::warning && t.world.events().warning_code(e) == "non_finite")
      cell.entity = t.world.events().warning_message(e);
  return true;
}

double largest(const std::vector<double>& e, std::size_t first, std::size_t last) {
  return *std::max_element(e.begin() + static_cast<std::ptrdiff_t>(first), e.begin() + static_cast<std::ptrdiff_t>(last));
}

Verdict judge(const Judgement& j, const StabilityScene& s, const StabilityThresholds& limits, const StabilityCell& c) {
  const std::size_t n = j.energy.size();
  if (n >= 8) {
    const double second = largest(j.energy, n / 4, n / 2), last = largest(j.energy, 3 * n / 4, n);
    if (last > limits.growth * second && last > limits.growth_start * j.energy.front()) return Verdict::growing;
  }
  if (j.reference_moved > limits.moves * s.length && j.moved < limits.stuck * j.reference_moved) return Verdict::stuck;
  // quarters, because the energy of symplectic methods swings
  for (std::size_t q = 0; q < 4 && n >= 8 && j.exact_energy.size() == n; ++q) {
    const std::size_t first = q * n / 4, last = (q + 1) * n / 4;
    if (largest(j.exact_energy, first, last) - largest(j.energy, first, last) > limits.damped * s.energy)
      return Verdict::damped;
  }
  if (c.error > limits.inaccurate || c.constraint > limits.constraint) return Verdict::inaccurate;
  return c.missed > limits.slow ? Verdict::slow : Verdict::stable;
}

StabilityCell run_cell(const StabilityProblem& problem, const std::string& method, double x, double y,
                       const StabilityThresholds& limits) {
  StabilityCell cell;
  cell.x = x, cell.y = y;
  const StabilityScene s = problem.scene(x, y, false);
  try {
    Trial t(s, method);
    const double h = static_cast<double>(static_cast<Real>(s.h));
    Judgement j;
    for (const Vec3& p : s.net.points) j.start.push_back(p.cast<double>());
    double most = 0;
    std::uint64_t solves = 0, misses = 0, missed_steps = 0;
    int done = 0;
    for (; done < s.steps; ++done) {
      t.world.step();
      const IntegratorStats stats = t.springs().stats(t.net);
      cell.iters_max = std::max(std::isnan(cell.iters_max) ? 0 : cell.iters_max,
                                static_cast<double>(stats.linear_solves - solves));
      solves = stats.linear_solves;
      missed_steps += stats.unconverged > misses;
      misses = stats.unconverged;
      const double e = t.energy() + s.energy_zero;
      most = std::max(most, e);
      j.energy.push_back(e);
      if (failed(t, s, limits, e, cell)) break;
      double now_energy = NAN;
      const bool known = problem.reference(x, y, (done + 1) * h, j.exact, now_energy);
      if (!std::isnan(now_energy)) j.exact_energy.push_back(now_energy);
      if (!known) continue;
      double error = 0, moved = 0, should = 0;
      for (std::size_t i = 0; i < t.points; ++i) {
        const Vec3d at = t.springs().point(t.net, i).cast<double>();
        error = std::max(error, (at - j.exact[i]).norm());
        moved = std::max(moved, (at - j.start[i]).norm());
        should = std::max(should, (j.exact[i] - j.start[i]).norm());
      }
      j.moved = std::max(j.moved, moved), j.reference_moved = std::max(j.reference_moved, should);
      if (done + 1 == s.judged_step) cell.error = error / s.length;
    }
    cell.energy_ratio = most / s.energy;
    cell.iters_mean = static_cast<double>(solves) / std::max(1, done);
    cell.missed = static_cast<double>(missed_steps) / std::max(1, done);
    if (std::isnan(cell.t_fail)) cell.verdict = judge(j, s, limits, cell);
  } catch (const SceneError& e) {
    cell.verdict = Verdict::refused;
    cell.entity = e.what();
  }
  return cell;
}

// Does the fastest mode grow? Largest displacements of windows are compared, because they beat with the step.
bool grows(const StabilityProblem& problem, const std::string& method, double x, double y) {
  const StabilityScene s = problem.scene(x, y, true);
  Trial t(s, method);
  double first = 0, last = 0;
  for (int k = 0; k < kGrowthSteps; ++k) {
    t.world.step();
    double size = 0;
    for (std::size_t i = 0; i < t.points; ++i)
      size = std::max(size, static_cast<double>(length(t.springs().point(t.net, i) - s.rest[i])));
    if (t.springs().quarantined(t.net) || !std::isfinite(size)) return true;
    if (k < kGrowthWindow) first = std::max(first, size);
    if (k >= kGrowthSteps - kGrowthWindow) last = std::max(last, size);
    if (k > kGrowthWindow && size > 2 * first) return true;
  }
  return last > 1.05 * first;
}

// Oscillator: the matrix of one step (integrate/limits.h), sharp in float too. Otherwise the top mode is run in a world
// and the step bisected to 1e-4: growing means twice the displacement, or 5 % more at the end of 4000 steps.
StabilityLimit find_limit(const StabilityProblem& problem, const std::string& method, double y) {
  const Variant<Integrator>& row = find_variant(integrators(), method, "integrator");
  Arena unused("stability");
  const IntegratorInfo info = row.make(unused, Params())->info();
  const StabilityScene s = problem.scene(1, y, true);
  StabilityLimit out;
  out.y = y;
  const double zeta = problem.single_oscillator() ? y : s.damping_ratio;
  out.z_predicted = predicted_limit(info, zeta);
  if (problem.single_oscillator()) {
    out.z_observed = observed_limit(row, Params(), zeta);
  } else {
    double below = 0.1, above = 1e4;
    if (grows(problem, method, problem.x_of(below, y), y)) {
      out.z_observed = 0;
    } else if (!grows(problem, method, problem.x_of(above, y), y)) {
      out.z_observed = static_cast<double>(kInfinity);
    } else {
      // first the decade, from below, then bisection
      for (above = below; !grows(problem, method, problem.x_of(above, y), y); above *= 1.25) below = above;
      while (above - below > 1e-4 * above) {
        const double middle = (below + above) / 2;
        (grows(problem, method, problem.x_of(middle, y), y) ? above : below) = middle;
      }
      out.z_observed = (below + above) / 2;
    }
  }
  const auto x = [&](double z) { return std::isfinite(z) ? problem.x_of(z, y) : z; };
  out.predicted = x(out.z_predicted), out.observed = x(out.z_observed);
  return out;
}

StabilityMap run_map(const StabilityProblem& problem, const std::string& method, const StabilityPlan& plan) {
  const StabilityProblemInfo info = problem.info();
  StabilityMap m;
  m.problem = info.name, m.method = method, m.x = info.x, m.y = info.y;
  if (!plan.x_values.empty()) m.x.values = plan.x_values;
  if (!plan.y_values.empty()) m.y.values = plan.y_values;
  Arena unused("stability");
  const IntegratorInfo about = find_variant(integrators(), method, "integrator").make(unused, Params())->info();
  m.order = about.order, m.implicit = about.implicit;
  if (plan.cells) {
    std::size_t stable = 0;
    for (const double y : m.y.values)
      for (const double x : m.x.values) {
        m.cells.push_back(run_cell(problem, method, x, y, plan.thresholds));
        stable += m.cells.back().verdict == Verdict::stable;
      }
    m.stable_share = static_cast<double>(stable) / static_cast<double>(std::max<std::size_t>(1, m.cells.size()));
  }
  if (plan.bisect && info.bisects) {
    for (const double y : m.y.values) m.limits.push_back(find_limit(problem, method, y));
    m.limit_how = problem.single_oscillator()
                      ? "from the matrix of one step, its determinant and trace bisected to rounding"
                      : "runs of 4000 steps on the fastest mode, the step bisected to 1e-4";
  }
  return m;
}

}  // namespace

const char* name_of(Verdict v) {
  static const char* const names[] = {"nan", "diverged", "growing", "stuck", "damped", "inaccurate", "slow", "refused", "stable"};
  return names[static_cast<std::size_t>(v)];
}

StabilityResult run_stability(const StabilityPlan& plan) {
#ifdef FEDER_HAS_CLOTH
  if (is_cloth_stability(plan.problem)) return run_cloth_stability(plan);
#endif
  const auto problem = find_variant(stability_problems(), plan.problem, "stability problem").make();
  std::vector<std::string> methods = plan.methods;
  if (methods.empty())
    for (const Variant<Integrator>& row : integrators()) methods.push_back(row.name);
  StabilityResult result;
  result.thresholds = plan.thresholds;
  result.real = kRealName;
  for (const std::string& m : methods) {
    find_variant(integrators(), m, "integrator");
    result.maps.push_back(run_map(*problem, m, plan));
  }
  return result;
}

}  // namespace feder
