#include "study/scene_problem.h"

#include <algorithm>

#include "rigid/rigid.h"
#include "springs/springs.h"
#include "study/norms.h"
#include "study/ode.h"

namespace feder {
namespace {

void add(std::vector<double>& out, const Vec3& a) {
  for (int k = 0; k < 3; ++k) out.push_back(static_cast<double>(a[k]));
}

double kinetic_of(World& world) { return world.energy().kinetic; }

class SceneRun final : public StudyRun {
 public:
  SceneRun(std::unique_ptr<SceneWorld> scene, int steps, bool has_error)
      : scene_(std::move(scene)), steps_(steps), has_error_(has_error) {}

  void step() override {
    scene_->step();
    if (++done_ == steps_ && has_error_) error_ = scene_->own_error();
  }
  void observe(Observation& out) override { observe_world(scene_->world(), out); }
  Invariants invariants() override {
    Invariants i;
    const Energy e = scene_->world().energy();
    i.energy = e.kinetic + e.potential + e.elastic;
    const Momentum p = scene_->world().momentum();
    for (int k = 0; k < 3; ++k) i.momentum[k] = p.linear[k], i.angular[k] = p.angular[k];
    return i;
  }
  StudyCounters counters() const override {
    StudyCounters c;
    World& w = scene_->world();
    c.steps = static_cast<std::int64_t>(w.step_count());
    const std::int64_t substeps = c.steps * w.desc().substeps;
    if (const Springs* s = w.find<Springs>())
      for (std::size_t n = 0; n < s->net_count(); ++n) {
        const StudyCounters net = counters_of(s->stats(s->net_info(n).object), false, 0);
        c.force_evals += net.force_evals, c.jac_evals += net.jac_evals, c.linear_solves += net.linear_solves;
        c.cg_iters += net.cg_iters, c.rejected += net.rejected, c.unconverged += net.unconverged;
      }
    // bodies: their forces are evaluated once a substep
    if (w.find<Rigid>()) c.sweeps = substeps;
    if (c.force_evals == 0) c.force_evals = substeps;
    return c;
  }
  std::size_t bytes() const override { return scene_->world().bytes(); }
  bool gave_up() const override { return !scene_->world().is_finite(); }
  double own_error() const override { return error_; }
  bool measures_itself() const override { return has_error_; }

 private:
  std::unique_ptr<SceneWorld> scene_;
  int steps_, done_ = 0;
  bool has_error_;
  double error_ = NAN;
};

std::vector<int> around(double t_end, double dt) {
  std::vector<int> steps;
  for (const double factor : {0.5, 1.0, 2.0, 4.0, 8.0}) {
    const double n = std::max(1.0, std::ceil(t_end / dt * factor - 1e-6));
    if (t_end / n <= 1) steps.push_back(static_cast<int>(n));
  }
  return steps;
}

}  // namespace

void observe_world(World& world, Observation& out) {
  out.x.clear(), out.v.clear(), out.q.clear();
  if (const Rigid* rigid = world.find<Rigid>()) {
    const Bodies& b = rigid->bodies();
    for (std::uint32_t i = 0; i < b.size(); ++i) {
      if (b.type[i] != BodyType::dynamic) continue;
      add(out.x, b.position[i]), add(out.v, b.velocity[i]);
      const Quat& q = b.rotation[i];
      out.q.insert(out.q.end(), {double(q.x), double(q.y), double(q.z), double(q.w)});
    }
  }
  if (const Particles* p = world.store().find<Particles>())
    for (std::uint32_t i = 0; i < p->size(); ++i)
      if (p->inv_mass[i] != 0) add(out.x, p->position[i]), add(out.v, p->velocity[i]);
}

SceneProblem::SceneProblem(SceneDescription description) : scene_(std::move(description)) {
  info_.name = scene_.name, info_.summary = scene_.summary;
  info_.family = "scene";
  info_.t_end = scene_.t_end;
  info_.params = scene_.params;
  if (scene_.steps.empty()) scene_.steps = around(scene_.t_end, scene_.dt);
  if (scene_.methods.empty()) throw SceneError("study: expected at least one method");
  for (int n : scene_.steps)
    if (n < 1 || scene_.t_end / n > 1 + 1e-12)
      throw SceneError("study: expected steps of at most 1 s over " + std::to_string(scene_.t_end) + " s, got " +
                       std::to_string(n) + " steps");
  if (scene_.has_error)
    set_reference(ReferenceKind::closed, 0, 0,
                  scene_.error_source.empty() ? "the scene's own error" : scene_.error_source);
  else if (!scene_.reference.empty())
    set_reference(ReferenceKind::closed, 0, 0, "values the scene states for t_end");
  else
    set_reference(ReferenceKind::self, 0, 0, "self-refined");
  // what is known at t_end alone, or measured by the scene, has no error along the run
  info_.own_measure = scene_.has_error || !scene_.reference.empty();
  info_.threads = scene_.threads;
  info_.reference.rounding = static_cast<double>(kEpsilon);
}

std::vector<RunSpec> SceneProblem::ladder(const MethodInfo& method) const {
  std::vector<RunSpec> rungs = {{method.name, 1, 0, 0, 0, {}}};
  const auto multiply = [&](const auto& values, auto set) {
    if (values.empty()) return;
    std::vector<RunSpec> next;
    for (const auto& value : values)
      for (RunSpec r : rungs) set(r, value), next.push_back(std::move(r));
    rungs = std::move(next);
  };
  // the step varies fastest: points of one setting lie beside each other
  multiply(scene_.steps, [](RunSpec& r, int n) { r.steps = n; });
  multiply(scene_.substeps, [](RunSpec& r, int n) { r.substeps = n; });
  for (const auto& [name, values] : scene_.axes)
    multiply(values, [&, &key = name](RunSpec& r, const std::string& value) { r.settings.emplace_back(key, value); });
  return rungs;
}

std::unique_ptr<StudyRun> SceneProblem::start(const RunSpec& spec) const {
  settings_ = spec.settings;
  return std::make_unique<SceneRun>(scene_.make(spec), spec.steps, scene_.has_error);
}

SceneProblem::Refined SceneProblem::run_refined(const std::string& method, int steps, const Settings& settings) const {
  Refined out;
  const auto scene = scene_.make({method, steps, 0, 0, 0, settings});
  const auto sample = [&] {
    out.states.emplace_back();
    observe_world(scene->world(), out.states.back());
    const Energy e = scene->world().energy();
    out.energy.push_back(e.kinetic + e.potential + e.elastic);
    out.kinetic = std::max(out.kinetic, kinetic_of(scene->world()));
  };
  sample();
  std::int64_t done = 0;
  for (int k = 1; k < kStudySamples; ++k) {
    // steps is a multiple of 256
    for (const std::int64_t until = static_cast<std::int64_t>(steps) / (kStudySamples - 1) * k; done < until; ++done)
      scene->step();
    if (!scene->world().is_finite()) {
      out.failure = method + ": the refined run went non-finite";
      break;
    }
    sample();
  }
  return out;
}

const SceneProblem::Refined& SceneProblem::refined() const {
  const auto found = references_.find(settings_);
  if (found != references_.end()) return found->second;
  const int finest = *std::max_element(scene_.steps.begin(), scene_.steps.end());
  int factor = 64;
  while (factor > 2 && static_cast<std::int64_t>(finest) * factor > kReferenceSteps) factor /= 2;
  const auto whole = [](std::int64_t n) { return static_cast<int>((n + 255) / 256 * 256); };
  const int steps = whole(static_cast<std::int64_t>(finest) * factor);
  const bool two = scene_.methods.size() > 1;
  Refined best = run_refined(scene_.methods[0].name, steps, settings_);
  const Refined other = run_refined(scene_.methods[two ? 1 : 0].name, two ? steps : whole(steps / 2), settings_);
  measure(best, other, factor);
  return references_.emplace(settings_, std::move(best)).first->second;
}

// Scales and uncertainty; over several settings the largest of each.
void SceneProblem::measure(const Refined& best, const Refined& other, int factor) const {
  ProblemInfo& info = info_;
  const bool first = references_.empty();
  double x = 0, v = 0;
  const Observation& start = best.states.front();
  const std::vector<double> rest(start.v.size(), 0);
  for (const Observation& o : best.states) {
    if (o.x.size() == start.x.size()) x = std::max(x, rms_distance(o.x, start.x));
    if (o.v.size() == rest.size()) v = std::max(v, rms_distance(o.v, rest));
  }
  info.dof = std::max(1, static_cast<int>(start.x.size() + start.q.size() / 4 * 3));
  // scenes at rest: a millimetre counts
  if (first) info.x_scale = info.v_scale = 1e-3, info.energy_scale = 0;
  info.x_scale = std::max(info.x_scale, x), info.v_scale = std::max(info.v_scale, v);
  info.energy_start = best.energy.front();
  info.energy_scale = std::max(info.energy_scale, std::max(best.kinetic, 1e-12));
  if (!best.failure.empty() || !other.failure.empty()) {
    info.reference.source = best.failure.empty() ? other.failure : best.failure;
    info.reference.uncertainty = NAN;
    return;
  }
  const double apart = rms_distance(best.states.back().x, other.states.back().x) / info.x_scale;
  if (scene_.has_error || !scene_.reference.empty()) return;
  info.reference.uncertainty = first ? apart : std::max(info.reference.uncertainty, apart);
  const bool two = scene_.methods.size() > 1;
  info.reference.digits = std::max(0, static_cast<int>(-std::log10(std::max(info.reference.uncertainty, 1e-16))));
  info.reference.source = "self-refined: " + scene_.methods[0].name + " with 1/" + std::to_string(factor) +
                          " of the finest step, against " +
                          (two ? scene_.methods[1].name + " with the same" : std::string("twice that"));
}

void SceneProblem::reference(double t, Observation& out) const {
  out.x.clear(), out.v.clear(), out.q.clear();
  if (scene_.has_error) return;
  if (!scene_.reference.empty()) {
    if (t >= info_.t_end) out.x = scene_.reference;
    return;
  }
  const Refined& r = refined();
  const auto k = static_cast<std::size_t>(std::lround(t / info_.t_end * (kStudySamples - 1)));
  if (k < r.states.size()) out = r.states[k];
}

double SceneProblem::reference_energy(double t) const {
  if (scene_.has_error || !scene_.reference.empty()) return NAN;
  const Refined& r = refined();
  const double place = t / info_.t_end * (kStudySamples - 1);
  const auto k = static_cast<std::size_t>(place);
  if (k + 1 >= r.energy.size()) return r.energy.back();
  const double s = place - static_cast<double>(k);
  return (1 - s) * r.energy[k] + s * r.energy[k + 1];
}

}  // namespace feder
