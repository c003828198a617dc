#include "view/live_scene.h"

#include <algorithm>
#include <cmath>

#include "feder/error.h"
#include "feder/profile.h"

namespace feder::view {
namespace {

double wall_seconds() { return static_cast<double>(clock_nanoseconds()) * 1e-9; }
void smooth(double& value, double sample, double share) { value += (value > 0 ? share : 1) * (sample - value); }

bool is_marked(EventKind kind) {
  return kind.has(EventKind::kText | EventKind::kForce) || kind == EventKind::sleep ||
         kind == EventKind::sensor_enter || kind == EventKind::hit;
}

}  // namespace

LiveScene::LiveScene(LiveOptions options)
    : options_(std::move(options)), watch_(options_.poll_files),
      history_(options_.keep_seconds, options_.history_bytes), mode_(options_.reload) {
  // what is lived again has been said before
  if (options_.host.print)
    options_.host.print = [this, print = options_.host.print](std::string_view text) {
      if (!rewriting_) print(text);
    };
}

bool LiveScene::open(const std::filesystem::path& file) {
  Recipe recipe;
  recipe.file = file;
  recipe.host = options_.host;
  return make_anew(std::move(recipe), ReloadMode::from_start, run_ != nullptr);
}

std::string LiveScene::title() const {
  const std::string title = run_ ? run_->script().title() : "";
  return title.empty() ? recipe_.file.stem().string() : title;
}

// A value that the new file does not take any more: the name is in "--set NAME=".
bool LiveScene::drop_refused_param(Recipe& recipe, const std::string& message) {
  const std::size_t at = message.find("--set ");
  if (at == std::string::npos) return false;
  const std::size_t equals = message.find('=', at);
  const std::string name = message.substr(at + 6, equals == std::string::npos ? equals : equals - at - 6);
  if (recipe.host.set.erase(name) == 0) return false;
  notice_ = message;
  return true;
}

bool LiveScene::make_anew(Recipe recipe, ReloadMode mode, bool forgiving) {
  recipe.kept = nullptr;
  const double clock = run_ ? shown_time() : 0;
  const double world_time = run_ ? world().time() : 0;
  if (mode == ReloadMode::keep && run_)
    recipe.kept = std::make_shared<KeptState>(KeptState{run_->start(), named_states(world()), clock});
  LoadFailure failure;
  std::unique_ptr<SceneRun> run = SceneRun::make(recipe, failure);
  while (!run && forgiving && drop_refused_param(recipe, failure.message)) run = SceneRun::make(recipe, failure);
  if (!run) {
    error_ = failure.message;
    if (run_)
      for (const auto& file : run_->script().files()) failure.files.push_back(file);
    else
      recipe_ = std::move(recipe);  // mending the file opens it
    watch_.set(failure.files);
    return false;
  }
  const bool catch_up = mode == ReloadMode::catch_up && world_time > 0;
  adopt(std::move(run), std::move(recipe));
  clock_offset_ = recipe_.kept ? recipe_.kept->time : 0;
  if (catch_up) catch_up_to_ = static_cast<std::uint64_t>(std::llround(clock / world().desc().dt));
  return true;
}

void LiveScene::adopt(std::unique_ptr<SceneRun> run, Recipe recipe) {
  run_ = std::move(run);
  recipe_ = std::move(recipe);
  error_.clear();
  present_.clear();
  cursor_.reset();
  grip_.reset();
  queued_.clear();
  history_.clear();
  watch_.set(run_->script().files());
  rewriting_ = false;
  catch_up_to_ = 0, due_ = 0, marked_errors_ = 0;
  snapshot_seconds_ = 0, slowness_ = 1;
  ++generation_;
  history_.add({0, 0, world().snapshot()});
}

void LiveScene::tick(double wall, double now) {
  if (watch_.changed(now)) {
    const double began = wall_seconds();
    reload();
    reload_seconds_ = watch_.age() + (wall_seconds() - began);
  }
  if (!run_) return;
  if (catching_up())
    catch_up();
  else if (paused_)
    slowness_ = 1;
  else if (in_past())
    play_recording(wall * speed_);
  else
    run_live(wall * speed_);
}

void LiveScene::set_speed(double factor) { speed_ = std::clamp(factor, 0.05, 8.0); }

void LiveScene::run_live(double seconds) {
  const double dt = world().desc().dt;
  due_ = std::min(due_ + seconds, std::max(0.25, dt));
  const double wanted = due_, began = wall_seconds();
  // the last bit of a step may be rounded away
  while (due_ > dt * 0.999 && !stopped() && !paused_) {
    one_step();
    due_ -= dt;
    if (wall_seconds() - began > options_.budget) break;
  }
  if (due_ > dt) due_ = dt;  // what could not be run is not owed
  if (wanted >= dt) smooth(slowness_, std::min(1.0, (wanted - due_ + dt) / (wanted + 1e-9)), 0.05);
}

void LiveScene::one_step() {
  const double began = wall_seconds();
  try {
    if (grip_ && alive(world(), *grip_))
      run_->act(view_of(world(), grip_->object)->pull(world(), *grip_));
    else
      grip_.reset();
    run_->step();
  } catch (const std::exception& e) {
    notice_ = e.what();
    paused_ = true;
  }
  smooth(step_seconds_, wall_seconds() - began, 0.1);
  record_marks();
  record();
}

void LiveScene::record() {
  // a snapshot may cost a quarter of a step
  const int stride = static_cast<int>(snapshot_seconds_ / (0.25 * step_seconds_ + 1e-4));
  if (world_step() % static_cast<std::uint64_t>(std::clamp(stride, 1, options_.max_stride)) != 0) return;
  const double began = wall_seconds();
  history_.add({world_step(), world().time(), world().snapshot()});
  smooth(snapshot_seconds_, wall_seconds() - began, 0.1);
}

void LiveScene::record_marks() {
  World& w = world();
  for (const Event& e : w.events().list()) {
    if (!is_marked(e.kind)) continue;
    const std::string label = e.kind == EventKind::warning ? w.events().warning_message(e) : w.objects().describe(e.a);
    history_.mark(w.step_count(), w.time(), e.kind.text(), label);
  }
  const auto& errors = run_->script().handler_errors();
  for (; marked_errors_ < errors.size(); ++marked_errors_) {
    const lua::HandlerError& e = errors[marked_errors_];
    history_.mark(w.step_count(), w.time(), "error", e.where + ": " + e.message);
    // an endless loop would take half a second of each step
    if (e.message.find("instruction limit") != std::string::npos) paused_ = true;
  }
}

void LiveScene::play_recording(double seconds) {
  due_ += seconds;
  const double dt = world().desc().dt;
  while (due_ > dt * 0.999 && in_past()) {
    const Moment* next = history_.after(*cursor_);
    if (!next || next->step >= present_step_) return to_present();
    if (due_ < static_cast<double>(next->step - *cursor_) * dt * 0.999) return;
    due_ -= static_cast<double>(next->step - *cursor_) * dt;
    if (!show(*next)) return;
  }
}

void LiveScene::catch_up() {
  const double began = wall_seconds();
  while (world_step() < catch_up_to_ && !stopped() && wall_seconds() - began < options_.budget) one_step();
  if (world_step() < catch_up_to_ && !stopped()) return;
  catch_up_to_ = 0;
  if (!rewriting_) return;
  rewriting_ = false;
  if (world().hash() != expected_hash_)
    notice_ = "lived again, the scene came out differently: its files have changed, or it depends on something else";
  do_queued();
}

double LiveScene::catch_up_share() const {
  return catching_up() ? static_cast<double>(world_step()) / static_cast<double>(catch_up_to_) : 1;
}

void LiveScene::stop_catching_up() {
  if (rewriting_) return;  // there would be nothing to go on from
  catch_up_to_ = 0;
}

std::uint64_t LiveScene::world_step() const {
  if (!run_) return 0;
  return in_past() ? present_step_ : run_->world().step_count();
}
std::uint64_t LiveScene::shown_step() const { return in_past() ? *cursor_ : world_step(); }
double LiveScene::shown_time() const { return run_ ? clock_of(run_->world().time()) : 0; }

void LiveScene::step_forward() {
  if (!run_ || catching_up()) return;
  paused_ = true;
  if (!in_past()) return one_step();
  const Moment* next = history_.after(*cursor_);
  if (!next || next->step >= present_step_)
    to_present();
  else
    show(*next);
}

void LiveScene::step_back() {
  if (!run_ || catching_up()) return;
  paused_ = true;
  if (const Moment* m = history_.before(shown_step())) show(*m);
}

void LiveScene::scrub(std::uint64_t step) {
  if (!run_ || catching_up()) return;
  if (step >= world_step()) return to_present();
  show(history_.at(step));
}

bool LiveScene::show(const Moment& moment) {
  if (moment.step == shown_step()) return true;
  if (!in_past()) {
    if (grip_) let_go(false);
    present_ = world().snapshot();
    present_step_ = world().step_count();
  }
  try {
    const std::uint64_t step = moment.step;
    world().restore(moment.image);
    cursor_ = step;
    return true;
  } catch (const std::exception& e) {
    // a system came later than that moment
    notice_ = std::string("this moment cannot be shown: ") + e.what();
    return false;
  }
}

void LiveScene::to_present() {
  if (!in_past()) return;
  world().restore(present_);
  cursor_.reset();
  present_.clear();
  due_ = 0;
}

// The scene is made anew and lived again up to the moment that is shown.
void LiveScene::give_up_future() {
  const std::uint64_t step = *cursor_;
  const std::uint64_t hash = world().hash();
  LoadFailure failure;
  std::unique_ptr<SceneRun> run = SceneRun::make(recipe_, failure);
  if (!run) {
    // the file cannot be run just now: the world goes on from its snapshot, Lua's variables from where they are
    notice_ = "going on from a snapshot of the world alone: " + failure.message;
    cursor_.reset();
    present_.clear();
    history_.cut_after(step);
    return;
  }
  run->relive(run_->deeds_before(step));
  const double offset = clock_offset_;
  adopt(std::move(run), recipe_);
  clock_offset_ = offset;
  if (step == 0) return;
  rewriting_ = true;
  expected_hash_ = hash;
  catch_up_to_ = step;
}

void LiveScene::act(Command command, const std::string& label) {
  if (!run_ || !command) return;
  if (in_past()) give_up_future();
  if (catching_up())
    queued_.emplace_back(std::move(command), label);
  else
    perform(command, label);
}

void LiveScene::perform(const Command& command, const std::string& label) {
  history_.mark(world_step(), world().time(), "hand", label);
  try {
    run_->act(command);
  } catch (const std::exception& e) {
    notice_ = label + ": " + e.what();
  }
}

void LiveScene::do_queued() {
  while (!queued_.empty() && !catching_up()) {
    const auto [command, label] = std::move(queued_.front());
    queued_.pop_front();
    perform(command, label);
  }
}

void LiveScene::run_text(const std::string& text, std::function<void(const std::string&, bool)> answer) {
  // told once: a life lived again does not answer again
  auto once = std::make_shared<std::function<void(const std::string&, bool)>>(std::move(answer));
  act(
      [text, once](lua::Script& script) {
        std::string said;
        bool good = true;
        try {
          said = script.run_string(text);
        } catch (const lua::ScriptError& e) {
          said = e.what(), good = false;
        }
        if (*once) (*once)(said, good);
        *once = nullptr;
      },
      text);
}

void LiveScene::hold(const Grip& grip) {
  if (!run_ || catching_up()) return;
  if (in_past()) {
    // held once the past has become the present
    give_up_future();
    return;
  }
  perform(view_of(world(), grip.object)->take(grip), "grip");
  grip_ = grip;
}

void LiveScene::let_go(bool pin) {
  if (!grip_) return;
  const Grip grip = *grip_;
  grip_.reset();
  if (run_ && !in_past() && alive(world(), grip))
    perform(view_of(world(), grip.object)->release(world(), grip, pin), pin ? "pin" : "let go");
}

void LiveScene::set_param(const std::string& name, const std::string& value) {
  if (!run_) return;
  recipe_.host.set[name] = value;
  make_anew(recipe_, mode_ == ReloadMode::keep ? mode_ : ReloadMode::from_start, false);
}

void LiveScene::set_world_option(const std::string& key, const std::string& value) {
  if (!run_) return;
  recipe_.host.world[key] = value;
  make_anew(recipe_, mode_ == ReloadMode::keep ? mode_ : ReloadMode::from_start, false);
}

void LiveScene::restart() { make_anew(recipe_, ReloadMode::from_start, false); }

void LiveScene::reload() {
  if (make_anew(recipe_, mode_, true)) ++reloads_;
}

}  // namespace feder::view
