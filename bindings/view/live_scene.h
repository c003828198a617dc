// A scene as the viewer has it: it runs, stands, goes back, is reloaded, and never falls over.
//
// Going back. The last seconds are kept as snapshots of the world (History). Looking at the past shows snapshots and
// touches nothing; playing from there shows the recording until the present is reached. Only who does something in the
// past changes it: the scene is then made anew and lived again from its start up to that step, with everything done by
// hand before it (SceneRun), and goes on from there. That is exact for Lua's state too, and costs the time of the steps
// lived again; their hash is compared with the recording's.
//
// Reloading. A new script is loaded and built beside the running one and takes its place only when that went well.
// `restart` builds the world anew and runs it to the time that it had; `keep` carries objects over by name.
#pragma once
#include <deque>
#include <optional>

#include "view/file_watch.h"
#include "view/history.h"
#include "view/picking.h"
#include "view/scene_run.h"

namespace feder::view {

enum class ReloadMode { catch_up, from_start, keep };

struct LiveOptions {
  lua::HostOptions host;
  double keep_seconds = 20;  // of history
  std::size_t history_bytes = std::size_t(512) << 20;
  ReloadMode reload = ReloadMode::catch_up;
  bool poll_files = false;  // look at times and sizes although inotify is there
  double budget = 0.025;    // s of wall time per tick for steps
  int max_stride = 8;       // steps from a recorded moment to the next, where recording would slow the scene down
};

class LiveScene {
 public:
  explicit LiveScene(LiveOptions options);

  // Replaces the scene by another file. False: error() says why, and the old scene stays.
  bool open(const std::filesystem::path& file);
  bool has_scene() const { return run_ != nullptr; }
  const std::filesystem::path& file() const { return recipe_.file; }
  std::string title() const;
  lua::Script& script() { return run_->script(); }
  World& world() { return run_->world(); }

  // Lets `wall` seconds pass: steps, plays the recording, or catches up. `now` is a steady clock, for the file watch.
  void tick(double wall, double now);
  void set_paused(bool paused) { paused_ = paused; }
  bool paused() const { return paused_; }
  void set_speed(double factor);  // 0.05 .. 8
  double speed() const { return speed_; }
  void stop_at(std::uint64_t step) { stop_at_ = step; }  // pauses there, exactly
  bool stopped() const { return has_scene() && world_step() >= stop_at_; }

  void step_forward();  // pauses; in the past it shows the next moment
  void step_back();
  void scrub(std::uint64_t step);  // shows the moment at or before that step
  void to_present();
  bool in_past() const { return cursor_.has_value(); }
  bool catching_up() const { return catch_up_to_ > 0; }
  bool rewriting() const { return rewriting_; }  // catching up to a moment in the past: nothing new to see yet
  double catch_up_share() const;                 // 0 .. 1
  void stop_catching_up();
  std::uint64_t shown_step() const;
  std::uint64_t world_step() const;  // of the present
  double shown_time() const;         // s, on the clock
  double clock_of(double time) const { return time + clock_offset_; }
  const History& history() const { return history_; }

  // Something done by hand, now; in the past, the future is given up first. Errors are shown, never thrown.
  void act(Command command, const std::string& label);
  // The same for Lua text; the answer goes to `answer` when it comes.
  void run_text(const std::string& text, std::function<void(const std::string&, bool)> answer);
  void hold(const Grip& grip);
  void move_hold(const Vec3& target) {
    if (grip_) grip_->target = target;
  }
  void let_go(bool pin);
  const std::optional<Grip>& held() const { return grip_; }

  // Values of the user; each change makes the scene anew. The value stays when that fails.
  void set_param(const std::string& name, const std::string& value);
  void set_world_option(const std::string& key, const std::string& value);
  const std::map<std::string, std::string>& user_params() const { return recipe_.host.set; }
  void restart();  // from time 0
  void reload();   // as when the file was saved
  void set_reload_mode(ReloadMode mode) { mode_ = mode; }
  ReloadMode reload_mode() const { return mode_; }

  // "file:line: message" of the last load; "" when it went well.
  const std::string& error() const { return error_; }
  // What went wrong in the viewer itself ("the run lived again differs"); "" when nothing.
  const std::string& notice() const { return notice_; }
  void clear_notice() { notice_.clear(); }
  std::uint64_t generation() const { return generation_; }  // grows with each world
  int reloads() const { return reloads_; }
  double reload_seconds() const { return reload_seconds_; }  // from the file's last write to the new world
  double step_seconds() const { return step_seconds_; }      // wall time per step, smoothed
  double slowness() const { return slowness_; }              // 1: real time at this speed; below: slower

 private:
  bool make_anew(Recipe recipe, ReloadMode mode, bool forgiving);
  void adopt(std::unique_ptr<SceneRun> run, Recipe recipe);
  bool drop_refused_param(Recipe& recipe, const std::string& message);
  void one_step();
  void record();
  void record_marks();
  void play_recording(double seconds);
  void run_live(double seconds);
  void catch_up();
  bool show(const Moment& moment);
  void give_up_future();
  void do_queued();
  void perform(const Command& command, const std::string& label);

  LiveOptions options_;
  Recipe recipe_;
  std::unique_ptr<SceneRun> run_;
  FileWatch watch_;
  History history_;
  ReloadMode mode_;
  bool paused_ = false, rewriting_ = false;
  double speed_ = 1, due_ = 0;  // due_: simulated seconds not yet run
  std::uint64_t stop_at_ = ~std::uint64_t(0), catch_up_to_ = 0;
  std::optional<std::uint64_t> cursor_;  // step that is shown, when it is past
  std::string present_;                  // snapshot of the present while the past is shown
  std::uint64_t present_step_ = 0;
  std::uint64_t expected_hash_ = 0;  // of the moment that is lived again
  double clock_offset_ = 0;
  std::optional<Grip> grip_;
  std::deque<std::pair<Command, std::string>> queued_;
  std::string error_, notice_;
  std::uint64_t generation_ = 0, marked_errors_ = 0;
  int reloads_ = 0;
  double reload_seconds_ = 0, step_seconds_ = 0, snapshot_seconds_ = 0, slowness_ = 1;
};

}  // namespace feder::view
