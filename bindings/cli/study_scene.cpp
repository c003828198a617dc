// Scenes as study problems: each run is a script of its own, loaded with the parameters of its rung.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/command.h"
#include "cli/session.h"
#include "cli/study_parts.h"
#include "integrate/integrator.h"
#include "rigid/rigid.h"
#include "rigid/solver.h"
#include "study/scene_problem.h"

namespace feder::cli {
namespace {

// How the name of a method reaches the script.
struct MethodPlace {
  std::string param;      // --set NAME; empty: none
  std::string world_key;  // --world KEY; empty: none
};

class ScriptWorld final : public SceneWorld {
 public:
  ScriptWorld(const std::string& file, lua::HostOptions host, bool has_error)
      : script_(std::move(host)), has_error_(has_error) {
    try {
      script_.load_file(file);
      script_.build();
    } catch (const lua::LimitError& e) {
      throw Failure(limit_status(e.limit()), limit_text(e.what(), e.limit()));
    } catch (const lua::OptionError& e) {
      throw Failure(kUsage, e.what());
    } catch (const lua::ScriptError& e) {
      throw SceneError(e.what());
    }
    need_no_errors();
  }
  World& world() override { return *script_.world(); }
  void step() override {
    script_.step();
    need_no_errors();
  }
  double own_error() override {
    if (!has_error_) return NAN;
    try {
      return script_.study_error();
    } catch (const lua::LimitError& e) {
      throw Failure(limit_status(e.limit()), limit_text(e.what(), e.limit()));
    } catch (const lua::ScriptError& e) {
      throw SceneError(e.what());
    }
  }
  lua::Script& script() { return script_; }

 private:
  void need_no_errors() {
    if (script_.handler_errors().empty()) return;
    const lua::HandlerError& e = script_.handler_errors().front();
    if (e.limit != lua::Limit::none) throw Failure(limit_status(e.limit), error_text(e));
    throw SceneError(e.where + ": " + e.message);
  }

  lua::Script script_;
  bool has_error_;
};

lua::HostOptions silent(lua::HostOptions host) {
  host.print = [](std::string_view) {};
  return host;
}

MethodInfo method_named(const std::string& name) {
  Arena arena("study");
  for (const auto& row : integrators())
    if (name == row.name) {
      const IntegratorInfo i = row.make(arena, Params())->info();
      return {row.name, row.summary, i.order, i.evals_per_step, i.stability_limit, i.implicit, false};
    }
  for (const auto& row : rigid_solvers())
    if (name == row.name) return {row.name, row.summary, 0, 1, NAN, false, false};
  return {name, "", 0, 1, NAN, false, false};
}

const lua::ParamInfo* find_param(const std::vector<lua::ParamInfo>& params, const std::string& name) {
  for (const lua::ParamInfo& p : params)
    if (p.name == name) return &p;
  return nullptr;
}

// The methods a scene offers: the choices of a parameter, or the solvers of its bodies.
MethodPlace find_methods(const std::string& file, lua::Script& script, SceneDescription& scene) {
  const std::vector<lua::ParamInfo> params = script.params();
  std::vector<std::string> names;
  MethodPlace place;
  const std::string& wanted = script.study().method;
  for (const std::string& name :
       wanted.empty() ? std::vector<std::string>{"integrator", "solver"} : std::vector<std::string>{wanted}) {
    const lua::ParamInfo* p = find_param(params, name);
    if (!p || p->choices.empty()) continue;
    place.param = name;
    names = p->choices;
    // the scene's own comes first
    std::stable_partition(names.begin(), names.end(), [&](const std::string& n) { return n == p->value; });
    break;
  }
  if (!wanted.empty() && place.param.empty())
    throw Failure(kUsage, fmt::format("{}: study.method: expected a feder.param with choices, got '{}'", file, wanted));
  World& world = *script.world();
  if (place.param.empty() && world.find<Rigid>()) {
    place.world_key = "rigid.solver";
    const auto& systems = world.desc().systems;
    const auto rigid = systems.find("rigid");
    const std::string own = rigid_solver(rigid == systems.end() ? Params() : rigid->second).name;
    for (const auto& row : rigid_solvers()) names.push_back(row.name);
    std::stable_partition(names.begin(), names.end(), [&](const std::string& n) { return n == own; });
  }
  if (names.empty()) names = {"scene"};
  for (const std::string& n : names) scene.methods.push_back(method_named(n));
  return place;
}

void read_axes(const std::string& file, const lua::Script& script, const MethodPlace& place, SceneDescription& scene) {
  std::vector<std::string> known = {"dt", "substeps"};
  for (const lua::ParamInfo& p : script.params()) known.push_back(p.name);
  for (const auto& [name, values] : script.study().axes) {
    const std::string what = file + ": study.axes." + name;
    if (name == "dt") {
      for (const std::string& v : values)
        scene.steps.push_back(static_cast<int>(std::max(1.0, std::round(scene.t_end / read_number(v, what)))));
    } else if (name == "substeps") {
      for (const std::string& v : values) scene.substeps.push_back(static_cast<int>(read_number(v, what)));
    } else if (name == place.param || (name == "solver" && !place.world_key.empty())) {
      scene.methods.clear();
      for (const std::string& v : values) scene.methods.push_back(method_named(v));
    } else if (std::find(known.begin(), known.end(), name) != known.end()) {
      scene.axes.emplace_back(name, values);
    } else {
      const std::string near = nearest_name(name, known);
      throw Failure(kUsage, fmt::format("{}: expected dt, substeps, solver or a parameter of the scene{}", what,
                                        near.empty() ? "" : "; did you mean '" + near + "'?"));
    }
  }
}

std::vector<ProblemParam> listed(const std::vector<lua::ParamInfo>& params) {
  std::vector<ProblemParam> out;
  for (const lua::ParamInfo& p : params)
    out.push_back({p.name, p.value, p.fallback, p.help, p.has_min ? p.min : NAN, p.has_max ? p.max : NAN, p.choices});
  return out;
}

void apply(const RunSpec& spec, double t_end, const MethodPlace& place, lua::HostOptions& host) {
  for (const auto& [name, value] : spec.settings) host.set[name] = value;
  host.world["dt"] = fmt::format("{:.17g}", t_end / spec.steps);
  if (spec.substeps > 0) host.world["substeps"] = std::to_string(spec.substeps);
  if (!place.param.empty()) host.set[place.param] = spec.method;
  if (!place.world_key.empty()) host.world[place.world_key] = spec.method;
  if (spec.iterations > 0 && !place.world_key.empty()) host.world["rigid.iterations"] = std::to_string(spec.iterations);
}

}  // namespace

std::unique_ptr<StudyProblem> open_scene(const std::string& file, const Options& options) {
  const lua::HostOptions host = silent(host_options(options));
  try {
    ScriptWorld probe(file, host, false);
    lua::Script& script = probe.script();
    const lua::StudyDeclaration& study = script.study();
    SceneDescription scene;
    scene.name = std::filesystem::path(file).stem().string();
    scene.summary = script.title();
    scene.t_end = script.seconds();
    scene.dt = probe.world().desc().dt;
    scene.threads = probe.world().desc().threads;
    scene.params = listed(script.params());
    scene.has_error = study.has_error;
    scene.error_source = "the error the scene measures itself, at t_end";
    if (!(scene.t_end > 0)) throw Failure(kUsage, file + ": a study expects the scene to say seconds");
    if (study.has_reference && !study.has_error) scene.reference = script.study_reference();
    const MethodPlace place = find_methods(file, script, scene);
    read_axes(file, script, place, scene);
    scene.make = [file, host, place, t_end = scene.t_end, own = scene.has_error](const RunSpec& spec) {
      lua::HostOptions with = host;
      apply(spec, t_end, place, with);
      return std::make_unique<ScriptWorld>(file, std::move(with), own);
    };
    return std::make_unique<SceneProblem>(std::move(scene));
  } catch (const SceneError& e) {
    throw Failure(kLoadError, e.what());
  } catch (const lua::LimitError& e) {
    throw Failure(limit_status(e.limit()), limit_text(e.what(), e.limit()));
  } catch (const lua::ScriptError& e) {
    throw Failure(kLoadError, e.what());
  }
}

}  // namespace feder::cli
