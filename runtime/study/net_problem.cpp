// Runs of a net in a world, and its references: modes about a rest state, or extrapolation of forces written apart from
// the library's. Weak spot: the bound on the frequency (Gershgorin 1931) lies above the true one.
#include "study/net_problem.h"

#include <algorithm>

#include "study/worlds.h"

namespace feder {
namespace {

class NetRun final : public StudyRun {
 public:
  NetRun(const NetModel& model, double t_end, const RunSpec& spec)
      : model_(model),
        world_(awake_world(model.gravity, t_end / spec.steps, std::max(1, spec.substeps)), net_catalog()),
        springs_(world_.need<Springs>()) {
    NetDesc d;
    Rng twin(1);
    for (std::size_t i = 0; i < model.mass.size(); ++i) {
      d.points.push_back(point(model.x, i));
      if (spec.twin && !model.pinned[i]) d.points.back() = nearby(d.points.back(), twin);
      d.velocities.push_back(point(model.v, i));
      d.masses.push_back(static_cast<Real>(model.mass[i]));
    }
    for (const NetSpring& s : model.springs)
      d.springs.push_back({s.i, s.j, static_cast<Real>(s.stiffness), 0, static_cast<Real>(s.rest_length), kInfinity});
    d.integrator = spec.method;
    if (spec.tolerance > 0) d.integrator_options.set("tolerance", spec.tolerance);
    if (spec.iterations > 0) d.integrator_options.set("iterations", static_cast<double>(spec.iterations));
    net_ = springs_.add_net(d);
    for (std::size_t i = 0; i < model.pinned.size(); ++i)
      if (model.pinned[i]) springs_.pin(net_, i);
    Arena arena("study");
    adaptive_ = make_integrator(arena, {spec.method, 1, 0, 0, 0, {}})->info().adaptive;
  }

  void step() override { world_.step(); }

  void observe(Observation& out) override {
    out.x.clear(), out.v.clear(), out.q.clear();
    for (const std::uint32_t i : model_.observed) {
      const Vec3 x = springs_.point(net_, i), v = springs_.velocity(net_, i);
      out.x.insert(out.x.end(), x.data(), x.data() + 3);
      out.v.insert(out.v.end(), v.data(), v.data() + 3);
    }
  }

  Invariants invariants() override {
    Invariants i;
    i.energy = total_energy(world_);
    const Momentum p = world_.momentum();
    for (int k = 0; k < 3; ++k) i.momentum[k] = p.linear[k], i.angular[k] = p.angular[k];
    i.momentum_scale = i.angular_scale = 0;
    for (std::size_t k = 0; k < model_.mass.size(); ++k) {
      const double speed = static_cast<double>(length(springs_.velocity(net_, k)));
      i.momentum_scale += model_.mass[k] * speed;
      i.angular_scale += model_.mass[k] * speed * static_cast<double>(length(springs_.point(net_, k)));
    }
    i.constraint = 0;
    for (std::size_t k = 0; k < model_.springs.size(); ++k)
      if (model_.springs[k].rest_length > 0)
        i.constraint = std::max(i.constraint, std::fabs(static_cast<double>(springs_.strain(net_, k))));
    return i;
  }

  StudyCounters counters() const override {
    return counters_of(springs_.stats(net_), adaptive_, static_cast<std::int64_t>(world_.step_count()));
  }
  std::size_t bytes() const override { return world_.bytes(); }
  bool gave_up() const override { return springs_.quarantined(net_); }

 private:
  static Vec3 point(const std::vector<double>& a, std::size_t i) {
    return Vec3(static_cast<Real>(a[3 * i]), static_cast<Real>(a[3 * i + 1]), static_cast<Real>(a[3 * i + 2]));
  }

  const NetModel& model_;
  World world_;
  Springs& springs_;
  ObjectId net_;
  bool adaptive_ = false;
};

// Accelerations of the model, written apart from runtime/springs.
void accelerate(const NetModel& m, const Wide* x, Wide* a) {
  for (std::size_t i = 0; i < m.mass.size(); ++i)
    a[3 * i] = a[3 * i + 2] = 0, a[3 * i + 1] = -static_cast<Wide>(m.gravity);
  for (const NetSpring& s : m.springs) {
    Wide d[3], square = 0;
    for (std::size_t k = 0; k < 3; ++k) d[k] = x[3 * s.j + k] - x[3 * s.i + k], square += d[k] * d[k];
    const Wide len = std::sqrt(square);
    if (len == 0) continue;
    const Wide pull = static_cast<Wide>(s.stiffness) * (len - static_cast<Wide>(s.rest_length)) / len;
    for (std::size_t k = 0; k < 3; ++k) {
      a[3 * s.i + k] += pull * d[k] / static_cast<Wide>(m.mass[s.i]);
      a[3 * s.j + k] -= pull * d[k] / static_cast<Wide>(m.mass[s.j]);
    }
  }
  for (std::size_t i = 0; i < m.pinned.size(); ++i)
    if (m.pinned[i]) a[3 * i] = a[3 * i + 1] = a[3 * i + 2] = 0;
}

}  // namespace

std::uint32_t NetModel::add(double px, double py, double pz, double m, bool pin) {
  x.insert(x.end(), {px, py, pz}), v.insert(v.end(), {0, 0, 0});
  mass.push_back(m), pinned.push_back(pin);
  return static_cast<std::uint32_t>(mass.size() - 1);
}

std::unique_ptr<StudyRun> NetProblem::start(const RunSpec& spec) const {
  return std::make_unique<NetRun>(model_, info_.t_end, spec);
}

void NetProblem::measure_model() {
  info_.dof = 0;
  double kinetic = 0, potential = 0, elastic = 0;
  for (std::size_t i = 0; i < model_.mass.size(); ++i) {
    if (!model_.pinned[i]) info_.dof += 3;
    for (std::size_t k = 0; k < 3; ++k) kinetic += 0.5 * model_.mass[i] * model_.v[3 * i + k] * model_.v[3 * i + k];
    potential += model_.mass[i] * model_.gravity * model_.x[3 * i + 1];
  }
  for (const NetSpring& s : model_.springs) {
    double square = 0;
    for (std::size_t k = 0; k < 3; ++k) square += std::pow(model_.x[3 * s.j + k] - model_.x[3 * s.i + k], 2);
    elastic += 0.5 * s.stiffness * std::pow(std::sqrt(square) - s.rest_length, 2);
  }
  info_.energy_start = kinetic + potential + elastic;
  // Gershgorin
  double w2 = 0;
  for (std::size_t i = 0; i < model_.mass.size(); ++i) {
    if (model_.pinned[i]) continue;
    double sum = 0;
    for (const NetSpring& s : model_.springs)
      if (s.i == i || s.j == i) sum += s.stiffness * (model_.pinned[s.i == i ? s.j : s.i] ? 1 : 2);
    w2 = std::max(w2, sum / model_.mass[i]);
  }
  info_.frequency = std::sqrt(w2);
}

void NetProblem::use_extrapolation() {
  const std::size_t n = model_.x.size();
  // lengths are known to a rounding, which the stiffness turns into noise that no step gets below
  const Wide tolerance = 1e-16L + 2e-19L * static_cast<Wide>(info_.frequency);
  std::vector<Wide> start(model_.x.begin(), model_.x.end());
  start.insert(start.end(), model_.v.begin(), model_.v.end());
  extrapolated_ = std::make_unique<OdeReference>(
      [m = &model_, n](Wide, const Wide* y, Wide* d) {
        std::copy(y + n, y + 2 * n, d);
        accelerate(*m, y, d + n);
      },
      std::move(start), info_.t_end, kStudySamples, tolerance);
}

void NetProblem::use_modes(int axis, const std::vector<double>& rest) {
  axis_ = axis;
  rest_ = rest;
  moving_.clear();
  std::vector<std::size_t> row(model_.mass.size());
  for (std::uint32_t i = 0; i < model_.mass.size(); ++i)
    if (!model_.pinned[i]) row[i] = moving_.size(), moving_.push_back(i);
  const std::size_t n = moving_.size();
  std::vector<Wide> k(n * n, 0), mass, u, v;
  for (const NetSpring& s : model_.springs) {
    const auto stiff = static_cast<Wide>(s.stiffness);
    if (!model_.pinned[s.i]) k[row[s.i] * n + row[s.i]] += stiff;
    if (!model_.pinned[s.j]) k[row[s.j] * n + row[s.j]] += stiff;
    if (model_.pinned[s.i] || model_.pinned[s.j]) continue;
    k[row[s.i] * n + row[s.j]] -= stiff;
    k[row[s.j] * n + row[s.i]] -= stiff;
  }
  for (std::size_t m = 0; m < n; ++m) {
    const std::size_t at = 3 * moving_[m] + static_cast<std::size_t>(axis);
    mass.push_back(static_cast<Wide>(model_.mass[moving_[m]]));
    u.push_back(static_cast<Wide>(model_.x[at]) - static_cast<Wide>(rest[m]));
    v.push_back(static_cast<Wide>(model_.v[at]));
  }
  modes_ = std::make_unique<LinearModes>(k, mass, u, v);
}

void NetProblem::reference(double t, Observation& out) const {
  if (modes_) return by_modes(t, out);
  const std::vector<Wide>& y = extrapolated_->at(t);
  out.x.clear(), out.v.clear(), out.q.clear();
  for (const std::uint32_t i : model_.observed)
    for (std::size_t k = 0; k < 3; ++k) {
      out.x.push_back(static_cast<double>(y[3 * i + k]));
      out.v.push_back(static_cast<double>(y[model_.x.size() + 3 * i + k]));
    }
}

void NetProblem::by_modes(double t, Observation& out) const {
  std::vector<double> u, v;
  modes_->at(t, u, v);
  out.x.clear(), out.v.clear(), out.q.clear();
  for (const std::uint32_t i : model_.observed) {
    const auto m = static_cast<std::size_t>(std::find(moving_.begin(), moving_.end(), i) - moving_.begin());
    for (std::size_t k = 0; k < 3; ++k) {
      const bool along = static_cast<int>(k) == axis_;
      out.x.push_back(along ? rest_[m] + u[m] : model_.x[3 * i + k]);
      out.v.push_back(along ? v[m] : 0);
    }
  }
}

}  // namespace feder
