// Script: the C++ face. Every way into Lua goes through State::call, so that nothing unwinds into the host.
#include "feder/lua.h"
#include "lua/console.h"
#include "lua/coverage.h"
#include "lua/library.h"
#include "lua/object_points.h"
#include "lua/params.h"
#include "lua/records.h"
#include "lua/scene.h"
#include "lua/step.h"
#include "lua/study.h"

namespace feder::lua {
namespace {

int step_world(lua_State* L) {
  run_step(L, *state(L).current());
  return 0;
}

[[noreturn]] void raise(State& state, const Failure& failure) {
  if (failure.limit != Limit::none) throw LimitError(failure.text(), failure.limit);
  if (state.wrong_option) throw OptionError(failure.text());
  throw ScriptError(failure.text());
}

}  // namespace

struct Script::Impl {
  explicit Impl(HostOptions options) : state(std::move(options)) {}

  // Runs a C++ function under Lua's protection; errors become ScriptError.
  template <class F>
  void protect(F&& body) {
    lua_State* L = state.L;
    lua_pushcfunction(L, [](lua_State* on) -> int {
      (*static_cast<F*>(lua_touserdata(on, 1)))(on);
      return 0;
    });
    lua_pushlightuserdata(L, &body);
    Failure failure;
    if (!state.call(L, 1, 0, failure)) raise(state, failure);
  }

  void run(std::string_view text, const std::string& name, const std::filesystem::path& file = {}) {
    begin_load();
    protect([&](lua_State* L) {
      if (luaL_loadbufferx(L, text.data(), text.size(), ("@" + name).c_str(), "t") != LUA_OK) lua_error(L);
      if (!file.empty()) cover_chunk(L, file);
      lua_call(L, 0, 1);
      state.is_scene = take_scene(L, name);
    });
    end_load();
  }

  void run_yaml(const std::string& text, const std::string& name) {
    begin_load();
    if (!state.options.load_yaml) throw ScriptError(name + ": this host reads no YAML");
    protect([&](lua_State* L) {
      push_yaml(L, name, text);
      yaml_to_scene(L, name);
      state.is_scene = take_scene(L, name);
    });
    end_load();
  }

  void begin_load() {
    if (loaded) throw ScriptError("a script has been loaded already: make another lua::Script");
    loaded = true;
    state.phase = Phase::loading;
  }

  void end_load() {
    state.phase = Phase::idle;
    check_set_names(state);
  }

  struct InPhase {
    State& state;
    Phase before;
    InPhase(State& s, Phase p) : state(s), before(s.phase) { s.phase = p; }
    ~InPhase() { state.phase = before; }
  };

  // What f(L) gives under Lua's protection.
  template <class F>
  auto run_in(Phase p, F&& f) {
    const InPhase phase(state, p);
    decltype(f(state.L)) out{};
    protect([&](lua_State* L) { out = f(L); });
    return out;
  }

  State state;
  bool loaded = false;
};

Script::Script(HostOptions options) : impl_(std::make_unique<Impl>(std::move(options))) {}
Script::~Script() = default;

void Script::load_file(const std::filesystem::path& file) {
  State& s = impl_->state;
  std::string text;
  try {
    record_file(s, file);
    text = read_text(file);
  } catch (const SceneError& e) {
    throw ScriptError(e.what());
  }
  s.folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  if (file.extension() == ".yaml" || file.extension() == ".yml") return impl_->run_yaml(text, chunk_name(file));
  // a mark of UTF-8 and a #! line belong to other programs
  std::string_view code = text;
  if (code.substr(0, 3) == "\xef\xbb\xbf") code.remove_prefix(3);
  if (code.substr(0, 1) == "#") code.remove_prefix(std::min(code.find('\n'), code.size()));
  impl_->run(code, chunk_name(file), file);
}

void Script::load_string(std::string_view text, const std::string& chunk) { impl_->run(text, chunk_name(chunk)); }

bool Script::is_scene() const { return impl_->state.is_scene; }
std::string Script::title() const { return impl_->state.scene.title; }
double Script::seconds() const { return impl_->state.scene.seconds; }
double Script::picture() const { return impl_->state.scene.picture; }
const SceneCamera& Script::camera() const { return impl_->state.scene.camera; }
const Appearance* Script::appearance() const {
  const WorldRecord* r = impl_->state.current();
  return r ? &r->appearance : nullptr;
}
std::vector<ParamInfo> Script::params() const { return impl_->state.params; }

void Script::build() {
  State& s = impl_->state;
  if (!s.is_scene) throw ScriptError("the script is no scene: it has nothing to build");
  const Impl::InPhase phase(s, Phase::building);
  lua_pushcfunction(s.L, guard<build_scene>);
  Failure failure;
  if (!s.call(s.L, 0, 0, failure)) raise(s, failure);
}

World* Script::world() {
  const WorldRecord* r = impl_->state.current();
  return r ? r->world.get() : nullptr;
}

void Script::step() {
  State& s = impl_->state;
  if (!world()) throw ScriptError("there is no world to step; build() makes a scene's");
  const Impl::InPhase phase(s, Phase::running);
  lua_pushcfunction(s.L, guard<step_world>);
  Failure failure;
  if (!s.call(s.L, 0, 0, failure, true)) s.report(failure);
  // outside Lua, which would take the host's own exceptions for errors of the script
  if (s.on_step && world()) s.on_step(*world());
}

const StudyDeclaration& Script::study() const { return impl_->state.scene.study; }

double Script::study_error(std::span<const double> refined) {
  return impl_->run_in(Phase::checking, [&](lua_State* L) { return scene_error(L, refined); });
}

StudyState Script::study_state(const char* name, double t) {
  return impl_->run_in(Phase::checking, [&](lua_State* L) { return read_study_state(L, name, t); });
}

std::vector<double> Script::study_numbers(const char* name, double t) {
  return impl_->run_in(Phase::checking, [&](lua_State* L) { return read_study_numbers(L, name, t); });
}

CheckResult Script::check() {
  const Impl::InPhase phase(impl_->state, Phase::checking);
  return run_check(impl_->state.L);
}

const CheckResult& Script::checks() const { return impl_->state.checks; }
int Script::random_tests() const { return impl_->state.scene.random; }
std::vector<ObjectSample> Script::sample() {
  if (!world()) return {};
  return impl_->run_in(Phase::checking, [&](lua_State* L) { return sample_objects(L, *impl_->state.current()); });
}
const GoldenWish& Script::golden() const { return impl_->state.scene.golden; }
const std::vector<HandlerError>& Script::handler_errors() const { return impl_->state.errors; }
std::vector<HandlerProfile> Script::handler_profile() const {
  std::vector<HandlerProfile> used = impl_->state.profile;
  std::erase_if(used, [](const HandlerProfile& p) { return p.calls == 0; });
  return used;
}

std::vector<Advice> Script::advice() {
  World* const w = world();
  return w ? advise(impl_->state.options.parts, *w) : std::vector<Advice>();
}

const std::vector<PlotSeries>& Script::plots() const { return impl_->state.plots; }
const std::vector<std::filesystem::path>& Script::files() const { return impl_->state.files; }

std::string Script::run_string(std::string_view text, const std::string& chunk) {
  return impl_->run_in(Phase::running, [&](lua_State* L) { return run_console(L, text, chunk); });
}

void Script::set_instruction_limit(std::uint64_t per_call) { impl_->state.options.instruction_limit = per_call; }

void Script::interrupt() { impl_->state.interrupted = true; }

void Script::on_step(std::function<void(World&)> callback) { impl_->state.on_step = std::move(callback); }

}  // namespace feder::lua
