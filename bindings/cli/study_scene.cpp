// Scenes as study problems: each run is a script of its own, loaded with the parameters of its rung.
#include <algorithm>
#include <cmath>

#include "cli/command.h"
#include "cli/session.h"
#include "cli/study_parts.h"
#include "integrate/integrator.h"
#include "lua/docs.h"
#include "study/scene_problem.h"

namespace feder::cli {
namespace {

// How what a rung says reaches the script: --set NAME, --world KEY; empty: not at all.
struct RungTargets {
  std::string method_param;
  std::string system;  // whose option "solver" it is, where no parameter names it
  std::string iterations_param, tolerance_param;
};

// Calls into the script; its errors become those of studies.
template <class F>
auto call_script(F&& call) {
  try {
    return call();
  } catch (const lua::LimitError& e) {
    throw Failure(limit_status(e.limit()), limit_text(e.what(), e.limit()));
  } catch (const lua::OptionError&) {
    throw;
  } catch (const lua::ScriptError& e) {
    throw SceneError(e.what());
  }
}

void take(lua::StudyState&& from, Observation& to) {
  to.x = std::move(from.x), to.v = std::move(from.v), to.q = std::move(from.q);
}

class ScriptWorld final : public SceneWorld {
 public:
  ScriptWorld(const std::string& file, lua::HostOptions host) : script_(std::move(host)) {
    call_script([&] { script_.load_file(file), script_.build(); });
    need_no_errors();
  }
  World& world() override { return *script_.world(); }
  void step() override {
    script_.step();
    need_no_errors();
  }
  void observe(Observation& out) override {
    if (!study().has_observe) return observe_world(world(), out);
    take(call_script([&] { return script_.study_state("observe"); }), out);
  }
  std::vector<double> measure() override {
    if (!study().has_measure) return SceneWorld::measure();
    return call_script([&] { return script_.study_numbers("measure"); });
  }
  double own_error(std::span<const double> refined) override {
    return call_script([&] { return script_.study_error(refined); });
  }
  double event_error() override { return study().has_event ? number("event", 0) : NAN; }
  double constraint() override { return study().has_constraint ? number("constraint", 0) : NAN; }
  double sweeps() const override { return script_.study().sweeps; }
  void reference(double t, Observation& out) override {
    take(call_script([&] { return script_.study_state("reference", t); }), out);
  }
  double reference_energy(double t) override { return study().has_energy ? number("energy", t) : NAN; }
  lua::Script& script() { return script_; }

 private:
  const lua::StudyDeclaration& study() const { return script_.study(); }
  double number(const char* name, double t) {
    const std::vector<double> all = call_script([&] { return script_.study_numbers(name, t); });
    return all.empty() ? NAN : all.front();
  }
  void need_no_errors() {
    if (script_.handler_errors().empty()) return;
    const lua::HandlerError& e = script_.handler_errors().front();
    if (e.limit != lua::Limit::none) throw Failure(limit_status(e.limit), error_text(e));
    throw SceneError(e.where + ": " + e.message);
  }

  lua::Script script_;
};

MethodInfo method_named(const std::string& name) {
  Arena arena("study");
  for (const auto& row : integrators())
    if (name == row.name) {
      const IntegratorInfo i = row.make(arena, Params())->info();
      return {row.name, row.summary, i.order, i.evals_per_step, i.stability_limit, i.implicit, false};
    }
  return {name, "", 0, 1, NAN, false, false};
}

const lua::ParamInfo* find_param(const std::vector<lua::ParamInfo>& params, const std::string& name) {
  for (const lua::ParamInfo& p : params)
    if (p.name == name) return &p;
  return nullptr;
}

// The solvers of the first of the world's systems that has a choice of them, its own first; none: empty.
std::vector<std::string> solvers_of(const World& world, std::string& system) {
  for (const SystemDescriptor* d : world.catalog()) {
    const auto present = world.report();
    if (!d->joins.empty() || std::ranges::none_of(present, [&](const auto& s) { return s.name == d->name; })) continue;
    for (const OptionInfo& o : lua::system_options(world.catalog(), d->name)) {
      if (std::string_view(o.row.name) != "solver") continue;
      system = d->name;
      const auto given = world.desc().systems.find(system);
      const Params options = given == world.desc().systems.end() ? Params() : given->second;
      const std::string own = options.text({"solver"}, o.fallback);
      std::vector<std::string> names;
      for (std::string_view name : split_choices(o.choices)) names.emplace_back(name);
      std::stable_partition(names.begin(), names.end(), [&](const std::string& n) { return n == own; });
      return names;
    }
  }
  return {};
}

// The methods a scene offers: the choices of a parameter, or the solvers of its bodies.
RungTargets find_methods(const std::string& file, lua::Script& script, SceneDescription& scene) {
  const std::vector<lua::ParamInfo> params = script.params();
  const lua::StudyDeclaration& study = script.study();
  std::vector<std::string> names;
  RungTargets targets;
  for (const std::string& name : study.method.empty() ? std::vector<std::string>{"integrator", "solver"}
                                                      : std::vector<std::string>{study.method}) {
    const lua::ParamInfo* p = find_param(params, name);
    if (!p || p->choices.empty()) continue;
    targets.method_param = name;
    names = p->choices;
    // the scene's own comes first
    std::stable_partition(names.begin(), names.end(), [&](const std::string& n) { return n == p->value; });
    break;
  }
  if (!study.method.empty() && targets.method_param.empty())
    throw Failure(kUsage, "{}: study.method: expected a feder.param with choices, got '{}'", file, study.method);
  World& world = *script.world();
  if (targets.method_param.empty()) names = solvers_of(world, targets.system);
  if (names.empty()) names = {"scene"};
  for (const std::string& n : study.methods)
    if (std::ranges::find(names, n) == names.end())
      throw Failure(kUsage, "{}: study.methods: unknown method '{}'; known: {}", file, n, fmt::join(names, ", "));
  for (const std::string& n : study.methods.empty() ? names : study.methods) scene.methods.push_back(method_named(n));
  if (find_param(params, "iterations")) targets.iterations_param = "iterations";
  if (!study.tolerance.empty() && !find_param(params, study.tolerance))
    throw Failure(kUsage, "{}: study.tolerance: expected the name of a feder.param, got '{}'", file, study.tolerance);
  targets.tolerance_param = study.tolerance;
  return targets;
}

// One set of axes as rungs. Where there are several sets, the axis with several values is what the set refines.
SceneLadder read_ladder(const std::string& what, const lua::StudyAxes& axes, lua::Script& script,
                        const RungTargets& targets, SceneDescription& scene) {
  const std::vector<lua::ParamInfo> params = script.params();
  SceneLadder ladder;
  std::vector<std::string> known = {"dt", "substeps", "iterations", "solver"};
  for (const lua::ParamInfo& p : params) known.push_back(p.name);
  for (const auto& [name, values] : axes) {
    const std::string where = what + "." + name;
    const auto numbers = [&, &all = values](auto& out, auto read, const char* refinement_axis) {
      for (const std::string& v : all) out.push_back(read(read_number(v, where)));
      if (all.size() > 1) ladder.refinement_axis = refinement_axis;
    };
    const auto whole = [](double x) { return static_cast<int>(x); };
    const auto steps = [&](double h) { return whole(std::max(1.0, std::round(scene.info.t_end / h))); };
    if (name == "dt") {
      numbers(ladder.steps, steps, "steps");
    } else if (name == "substeps") {
      numbers(ladder.substeps, whole, "substeps");
    } else if (name == "iterations") {
      numbers(ladder.iterations, whole, "iters");
    } else if (!name.empty() && name == targets.tolerance_param) {
      numbers(ladder.tolerances, std::identity(), "tol");
    } else if (name == targets.method_param ||
               (!targets.system.empty() && (name == "solver" || name == targets.system + ".solver"))) {
      scene.methods.clear();
      for (const std::string& v : values) scene.methods.push_back(method_named(v));
    } else if (find_param(params, name) || name.find('.') != std::string::npos) {
      ladder.settings.emplace_back(name, values);
    } else {
      throw Failure(kUsage, "{}: expected dt, substeps, iterations, solver or a parameter of the scene{}", where,
                    did_you_mean("; ", name, known));
    }
  }
  if (ladder.substeps.empty()) ladder.substeps = {script.world()->desc().substeps};
  return ladder;
}

void read_ladders(const std::string& file, lua::Script& script, const RungTargets& targets, SceneDescription& scene) {
  const lua::StudyDeclaration& study = script.study();
  if (study.ladders.empty() || !study.axes.empty()) {
    scene.ladders.push_back(read_ladder(file + ": study.axes", study.axes, script, targets, scene));
    if (study.ladders.empty()) scene.ladders.back().refinement_axis.clear();
  }
  for (std::size_t k = 0; k < study.ladders.size(); ++k) {
    scene.ladders.push_back(
        read_ladder(fmt::format("{}: study.ladders[{}]", file, k + 1), study.ladders[k].axes, script, targets, scene));
    scene.ladders.back().methods = study.ladders[k].methods;
  }
}

std::vector<ProblemParam> listed(const std::vector<lua::ParamInfo>& params) {
  std::vector<ProblemParam> out;
  for (const lua::ParamInfo& p : params)
    out.push_back({p.name, p.value, p.fallback, p.help, p.has_min ? p.min : NAN, p.has_max ? p.max : NAN, p.choices});
  return out;
}

void apply(const RunSpec& spec, double t_end, const RungTargets& targets, lua::HostOptions& host) {
  for (const auto& [name, value] : spec.settings)
    (name.find('.') == std::string::npos ? host.set : host.world)[name] = value;
  host.world["dt"] = fmt::format("{:.17g}", t_end / spec.steps);
  if (spec.substeps > 0) host.world["substeps"] = std::to_string(spec.substeps);
  if (!targets.method_param.empty()) host.set[targets.method_param] = spec.method;
  if (!targets.system.empty()) host.world[targets.system + ".solver"] = spec.method;
  if (spec.iterations > 0 && !targets.iterations_param.empty())
    host.set[targets.iterations_param] = std::to_string(spec.iterations);
  else if (spec.iterations > 0 && !targets.system.empty())
    host.world[targets.system + ".iterations"] = std::to_string(spec.iterations);
  if (spec.tolerance > 0 && !targets.tolerance_param.empty())
    host.set[targets.tolerance_param] = fmt::format("{:.17g}", spec.tolerance);
}

// What the scene says of its reference, scales and invariants.
void read_reference(ScriptWorld& probe, SceneDescription& scene) {
  const lua::StudyDeclaration& study = probe.script().study();
  using Said = lua::StudyDeclaration::Reference;
  using Reference = SceneDescription::Reference;
  ProblemInfo& info = scene.info;
  scene.has_error = study.has_error;
  scene.reference = Reference::refined;
  if (study.reference == Said::course)
    scene.reference = Reference::course;
  else if (study.has_error && study.reference != Said::refined)
    scene.reference = Reference::none;  // or known to the error alone
  else if (study.reference == Said::stated) {
    lua::StudyState stated = probe.script().study_state("reference", info.t_end);
    scene.reference = Reference::stated, scene.stated = std::move(stated.x);
  }
  if (scene.reference != Reference::refined) {
    Observation start;
    probe.observe(start);
    info.dof = std::max(1, static_cast<int>(start.x.size() + start.q.size() / 4 * 3));
  }
  info.x_scale = study.length, info.v_scale = study.velocity;
  if (study.energy > 0) info.energy_scale = study.energy;
  info.reference.kind = study.kind == "quad"        ? ReferenceKind::quad
                        : study.kind == "published" ? ReferenceKind::published
                                                    : ReferenceKind::closed;
  info.reference.digits = 0;
  info.reference.uncertainty = study.uncertainty;
  info.reference.source = study.source;
  info.reference.resolution = study.resolution;
  scene.rounding = study.rounding;
  info.dense = study.interpolate;
  for (const std::string& word : study.conserves)
    (word == "momentum" ? info.conserves_momentum : info.conserves_angular) = true;
  scene.refined_substeps = study.refined_substeps;
}

}  // namespace

std::unique_ptr<StudyProblem> open_scene(const std::string& file, const Options& options) {
  const lua::HostOptions host = silent_host_options(options);
  try {
    ScriptWorld probe(file, host);
    lua::Script& script = probe.script();
    const lua::StudyDeclaration& study = script.study();
    SceneDescription scene;
    scene.info.name = std::filesystem::path(file).stem().string();
    scene.info.summary = script.title();
    scene.info.t_end = study.seconds > 0 ? study.seconds : script.seconds();
    scene.info.threads = probe.world().desc().threads;
    scene.info.params = listed(script.params());
    scene.dt = probe.world().desc().dt;
    if (!(scene.info.t_end > 0)) throw Failure(kUsage, file + ": a study expects the scene to say seconds");
    read_reference(probe, scene);
    const RungTargets targets = find_methods(file, script, scene);
    read_ladders(file, script, targets, scene);
    scene.make = [file, host, targets, t_end = scene.info.t_end](const RunSpec& spec) {
      lua::HostOptions with = host;
      apply(spec, t_end, targets, with);
      try {
        return std::make_unique<ScriptWorld>(file, std::move(with));
      } catch (const lua::OptionError& e) {
        if (spec.iterations > 0) throw SceneError(e.what());  // of a method that does not take them
        throw Failure(kUsage, e.what());
      }
    };
    return std::make_unique<SceneProblem>(std::move(scene));
  } catch (...) {
    fail_by_script(kLoadError);
  }
}

}  // namespace feder::cli
