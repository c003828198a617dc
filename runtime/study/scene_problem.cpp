// Runs of worlds as a study sees them, and their references: stated, the scene's own course, or refined runs between
// which is interpolated linearly. Weak spot: a refined reference is as good as its two runs differ, which hides what
// both get wrong.
#include "study/scene_problem.h"

#include <algorithm>

#include "feder/net.h"
#include "feder/rigid.h"
#include "state/bodies.h"
#include "state/particles.h"
#include "study/integrator_problem.h"
#include "study/norms.h"
#include "study/worlds.h"

namespace feder {
namespace {

void add(std::vector<double>& out, const Vec3& a) {
  for (int k = 0; k < 3; ++k) out.push_back(static_cast<double>(a[k]));
}

class SceneRun final : public StudyRun {
 public:
  SceneRun(std::unique_ptr<SceneWorld> scene, int steps, std::function<double(SceneWorld&)> own_error)
      : scene_(std::move(scene)), steps_(steps), own_error_(std::move(own_error)) {}

  void step() override {
    scene_->step();
    warned_.read(scene_->world());
    if (++done_ == steps_ && own_error_) error_ = own_error_(*scene_);
  }
  void observe(Observation& out) override { scene_->observe(out); }
  Invariants invariants() override {
    Invariants i;
    i.energy = total_energy(scene_->world());
    const Momentum p = scene_->world().momentum();
    for (int k = 0; k < 3; ++k) i.momentum[k] = p.linear[k], i.angular[k] = p.angular[k];
    i.momentum_scale = std::hypot(i.momentum[0], i.momentum[1], i.momentum[2]);
    i.angular_scale = std::hypot(i.angular[0], i.angular[1], i.angular[2]);
    i.constraint = scene_->constraint();
    return i;
  }
  StudyCounters counters() const override {
    StudyCounters c;
    World& w = scene_->world();
    c.steps = static_cast<std::int64_t>(w.step_count());
    if (const Springs* s = w.find<Springs>())
      for (std::size_t n = 0; n < s->net_count(); ++n) {
        const StudyCounters net = counters_of(s->stats(s->net_info(n).object), false, 0);
        c.force_evals += net.force_evals, c.jac_evals += net.jac_evals, c.linear_solves += net.linear_solves;
        c.cg_iters += net.cg_iters, c.rejected += net.rejected, c.unconverged += net.unconverged;
      }
    if (c.force_evals > 0) return c;
    // of solvers: what runs most often, which is in the innermost loop
    std::uint64_t most = 0;
    for (const PlanNode& node : w.plan().nodes())
      if (!node.is_loop) most = std::max(most, node.counter.calls);
    c.force_evals = c.sweeps = std::llround(static_cast<double>(most) * scene_->sweeps());
    return c;
  }
  std::size_t bytes() const override { return scene_->world().bytes(); }
  bool gave_up() const override { return !scene_->world().is_finite(); }
  std::string warning() const override { return warned_.last; }
  double event_error() const override { return scene_->event_error(); }
  double own_error() const override { return error_; }
  bool measures_itself() const override { return static_cast<bool>(own_error_); }

 private:
  std::unique_ptr<SceneWorld> scene_;
  int steps_, done_ = 0;
  std::function<double(SceneWorld&)> own_error_;
  double error_ = NAN;
  WarningRecord warned_;
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
  info_ = scene_.info;
  info_.family = "scene";
  if (scene_.methods.empty()) throw SceneError("study: expected at least one method");
  if (scene_.ladders.empty()) scene_.ladders.emplace_back();
  for (SceneLadder& l : scene_.ladders) {
    if (l.steps.empty())
      l.steps = l.refinement_axis.empty() ? around(info_.t_end, scene_.dt) : std::vector<int>{own_spec().steps};
    for (int n : l.steps)
      if (n < 1 || info_.t_end / n > 1 + 1e-12)
        throw SceneError("study: expected steps of at most 1 s over " + std::to_string(info_.t_end) + " s, got " +
                         std::to_string(n) + " steps");
  }
  // what is known at t_end alone, or measured by the scene, has no error along the run
  info_.own_measure = scene_.has_error || scene_.reference == Reference::stated;
  if (scene_.reference != Reference::refined)  // in metres, where the scene does not say
    for (double* scale : {&info_.x_scale, &info_.v_scale})
      if (!(*scale > 0)) *scale = 1;
  describe_reference();
}

void SceneProblem::describe_reference() {
  ReferenceInfo& r = info_.reference;
  const ReferenceInfo said = scene_.info.reference;
  const bool refines = scene_.reference == Reference::refined;
  std::string source = said.source;
  if (source.empty())
    source = refines                                 ? "self-refined"
             : scene_.reference == Reference::stated ? "values the scene states for t_end"
             : scene_.reference == Reference::course ? "the scene's own course"
                                                     : "the error the scene measures itself, at t_end";
  const int digits = std::clamp(static_cast<int>(-std::log10(std::max(said.uncertainty, 1e-15))), 0, 15);
  if (scene_.reference == Reference::course)
    set_reference(said.kind, digits, said.uncertainty, source);
  else
    r = {refines ? ReferenceKind::self : said.kind, refines ? 0 : digits, said.uncertainty, double(kEpsilon), source};
  r.rounding *= scene_.rounding;
  r.resolution = said.resolution;
}

RunSpec SceneProblem::own_spec() const {
  const int steps = static_cast<int>(std::max(1.0, std::ceil(info_.t_end / scene_.dt - 1e-6)));
  return {scene_.methods[0].name, steps, 0, 0, 0, settings_};
}

std::vector<RunSpec> SceneProblem::ladder(const MethodInfo& method) const {
  std::vector<RunSpec> all;
  for (const SceneLadder& l : scene_.ladders) {
    if (!l.methods.empty() && std::find(l.methods.begin(), l.methods.end(), method.name) == l.methods.end()) continue;
    std::vector<RunSpec> rungs = {{method.name, 1, 0, 0, 0, {}, l.refinement_axis}};
    const auto multiply = [&](const auto& values, auto set) {
      if (values.empty()) return;
      std::vector<RunSpec> next;
      for (const auto& value : values)
        for (RunSpec r : rungs) set(r, value), next.push_back(std::move(r));
      rungs = std::move(next);
    };
    // the step varies fastest: points of one setting lie beside each other
    multiply(l.steps, [](RunSpec& r, int n) { r.steps = n; });
    multiply(l.substeps, [](RunSpec& r, int n) { r.substeps = n; });
    multiply(l.iterations, [](RunSpec& r, int n) { r.iterations = n; });
    multiply(l.tolerances, [](RunSpec& r, double x) { r.tolerance = x; });
    for (const auto& [name, values] : l.settings)
      multiply(values, [&, &key = name](RunSpec& r, const std::string& value) { r.settings.emplace_back(key, value); });
    all.insert(all.end(), rungs.begin(), rungs.end());
  }
  return all;
}

std::unique_ptr<StudyRun> SceneProblem::start(const RunSpec& spec) const {
  settings_ = spec.settings;
  std::function<double(SceneWorld&)> own_error;
  if (scene_.has_error)
    own_error = [this](SceneWorld& w) {
      return w.own_error(scene_.reference == Reference::refined ? refined().measure : std::vector<double>());
    };
  return std::make_unique<SceneRun>(scene_.make(spec), spec.steps, std::move(own_error));
}

SceneWorld& SceneProblem::referee() const {
  if (!referee_ || referee_settings_ != settings_) {
    referee_ = scene_.make(own_spec());
    referee_settings_ = settings_;
  }
  return *referee_;
}

SceneProblem::Refined SceneProblem::run_refined(const RunSpec& spec) const {
  Refined out;
  const auto scene = scene_.make(spec);
  const auto sample = [&] {
    out.states.emplace_back();
    scene->observe(out.states.back());
    const Energy e = scene->world().energy();
    out.energy.push_back(e.kinetic + e.potential + e.elastic);
    out.kinetic = std::max(out.kinetic, e.kinetic);
  };
  sample();
  const int stride = spec.steps % (kStudySamples - 1) == 0 ? spec.steps / (kStudySamples - 1) : 1;
  for (int k = 1; k <= spec.steps; ++k) {
    scene->step();
    if (k % stride != 0) continue;
    if (!scene->world().is_finite()) {
      out.failure = spec.method + ": the refined run went non-finite";
      return out;
    }
    sample();
  }
  out.measure = scene->measure();
  return out;
}

const SceneProblem::Refined& SceneProblem::refined() const {
  const auto found = references_.find(settings_);
  if (found != references_.end()) return found->second;
  const bool two = scene_.methods.size() > 1;
  RunSpec best = own_spec(), other = best;
  std::string how;
  if (scene_.refined_substeps > 0) {
    best.substeps = scene_.refined_substeps;
    if (!two) other.substeps = std::max(1, best.substeps / 2);
    how = std::to_string(best.substeps) + " substeps";
  } else {
    int finest = 1, factor = 64;
    for (const SceneLadder& l : scene_.ladders)
      for (const int n : l.steps) finest = std::max(finest, n);
    while (factor > 2 && static_cast<std::int64_t>(finest) * factor > kReferenceSteps) factor /= 2;
    const auto whole = [](std::int64_t n) { return static_cast<int>((n + 255) / 256 * 256); };
    best.steps = whole(static_cast<std::int64_t>(finest) * factor);
    other.steps = two ? best.steps : whole(best.steps / 2);
    how = "1/" + std::to_string(factor) + " of the finest step";
  }
  other.method = scene_.methods[two ? 1 : 0].name;
  Refined run = run_refined(best);
  measure(run, run_refined(other));
  if (std::isfinite(info_.reference.uncertainty)) {
    const std::string& said = scene_.info.reference.source;
    info_.reference.source = (said.empty() ? "" : said + "; ") + "self-refined: " + best.method + " with " + how +
                             ", against " +
                             (!two                          ? "twice that"
                              : scene_.refined_substeps > 0 ? other.method + " as the scene has it"
                                                            : other.method + " with the same");
  }
  return references_.emplace(settings_, std::move(run)).first->second;
}

// Scales and uncertainty; over several settings the largest of each.
void SceneProblem::measure(const Refined& best, const Refined& other) const {
  ProblemInfo& info = info_;
  const bool first = references_.empty();
  double x = 0, v = 0;
  const Observation& start = best.states.front();
  const std::vector<double> rest(start.v.size(), 0);
  for (const Observation& o : best.states) {
    if (o.x.size() == start.x.size()) x = std::max(x, rms_distance(o.x, start.x));
    if (o.v.size() == rest.size() && !rest.empty()) v = std::max(v, rms_distance(o.v, rest));
  }
  // scenes at rest: a millimetre counts
  if (first && !(scene_.info.x_scale > 0)) info.x_scale = 1e-3;
  if (first && !(scene_.info.v_scale > 0)) info.v_scale = 1e-3;
  if (!(scene_.info.x_scale > 0)) info.x_scale = std::max(info.x_scale, x);
  if (!(scene_.info.v_scale > 0)) info.v_scale = std::max(info.v_scale, v);
  if (first)
    info.energy_scale = 0, info.dof = std::max(info.dof, static_cast<int>(start.x.size() + start.q.size() / 4 * 3));
  info.energy_start = best.energy.front();
  info.energy_scale = std::max(info.energy_scale, std::max(best.kinetic, 1e-12));
  ReferenceInfo& r = info.reference;
  if (!best.failure.empty() || !other.failure.empty()) {
    r.source = best.failure.empty() ? other.failure : best.failure;
    r.uncertainty = NAN;
    return;
  }
  // of the error's own measure, where that is not the positions at the end
  double apart = rms_distance(best.states.back().x, other.states.back().x) / info.x_scale;
  if (scene_.has_error && best.measure.size() == other.measure.size())
    apart = rms_distance(best.measure, other.measure) / info.x_scale;
  r.uncertainty = first ? apart : std::max(r.uncertainty, apart);
  r.digits = std::max(0, static_cast<int>(-std::log10(std::max(r.uncertainty, 1e-16))));
}

void SceneProblem::reference(double t, Observation& out) const {
  out.x.clear(), out.v.clear(), out.q.clear();
  switch (scene_.reference) {
    case Reference::none: return;
    case Reference::course: return referee().reference(t, out);
    case Reference::stated:
      if (t >= info_.t_end) out.x = scene_.stated;
      return;
    case Reference::refined: break;
  }
  // linear between the states that were kept
  const Refined& r = refined();
  const double sample = t / info_.t_end * static_cast<double>(r.states.size() - 1);
  const auto k = std::min(static_cast<std::size_t>(sample + 1e-9), r.states.size() - 1);
  out = r.states[k];
  const double s = sample - static_cast<double>(k);
  if (s < 1e-9 || k + 1 >= r.states.size()) return;
  const Observation& next = r.states[k + 1];
  for (std::size_t i = 0; i < out.x.size() && i < next.x.size(); ++i) out.x[i] += s * (next.x[i] - out.x[i]);
  for (std::size_t i = 0; i < out.v.size() && i < next.v.size(); ++i) out.v[i] += s * (next.v[i] - out.v[i]);
}

double SceneProblem::reference_energy(double t) const {
  if (scene_.reference != Reference::refined) return referee().reference_energy(t);
  if (scene_.has_error) return NAN;
  const Refined& r = refined();
  const double sample = t / info_.t_end * static_cast<double>(r.energy.size() - 1);
  const auto k = static_cast<std::size_t>(sample);
  if (k + 1 >= r.energy.size()) return r.energy.back();
  const double s = sample - static_cast<double>(k);
  return (1 - s) * r.energy[k] + s * r.energy[k + 1];
}

}  // namespace feder
