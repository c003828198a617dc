// feder view: the interactive viewer.
#include <cstdio>
#include <optional>

#include "cli/command.h"
#include "cli/doc_pages.h"
#include "cli/recording.h"
#include "cli/session.h"
#include "cli/summary.h"
#include "lua/completion.h"
#include "view/viewer.h"
#include "view/window.h"

namespace feder::cli {
namespace {

class View final : public Command {
 public:
  void declare(Arguments& a) override {
    a.text("SCENE", scene_, "a .lua or .yaml file");
    a.require("SCENE");
    a.text("--size", size_, "of the window, for example 1920x1080 (default 1280x800)");
    a.flag("--paused", o_.paused, "stand still at the start");
    a.text("--on-save", on_save_,
           "catch_up: run the new scene to the same time (default); start_over; keep: objects with "
           "the same name stay where they are");
    a.text("--detail", detail_,
           "auto: as much as this machine draws fluently (default); full; plain: no smooth edges; "
           "least: no shadows");
    a.text("--draw", o_.toggles,
           "what is drawn: contacts,joints,-springs ...; speed, density or pressure colours fluids");
    a.text("--select", o_.select, "name of the object to look at");
    a.flag("--no-panels", o_.hide_panels, "the scene alone (tab brings the panels)");
    a.flag("--console", o_.console, "with the console open");
    a.text("--seconds", seconds_, "run so many simulated seconds without waiting for the clock, and end");
    a.whole("--frames", o_.frames, 1, 1000000000, "end after so many pictures");
    a.flag("--hash", hash_, "print the state's hash at the end");
    a.text("--screenshot", o_.picture, "write a PNG of the window at the end");
    a.whole("--at-frame", o_.picture_at, 0, 1000000000, "or of that picture, counted from 0");
    a.text("--record", record_, "write all that is done to the worlds, by scripts and by hand: see feder replay");
    a.text("--status", o_.status, "keep a JSON file up to date: error, time, hash, objects on the screen");
  }

  int run(const Options& options) override {
    o_.file = scene_;
    o_.live.host = host_options(options);
    o_.live.reload = reload_mode();
    o_.complete = [pages = all_pages(options.build)](std::string_view line) { return lua::complete(pages, line); };
    o_.detail = detail();
    if (!seconds_.empty()) o_.seconds = read_number(seconds_, "--seconds");
    read_size();
    read_text(scene_);  // a file that is not there is no scene to wait for
    if (!record_.empty()) record(options);
    view::ViewerEnd end;
    try {
      end = view::run_viewer(o_);
    } catch (const view::WindowError& e) {
      throw Failure(kFailed, e.what());
    } catch (const view::GlError& e) {
      throw Failure(kFailed, "feder view: {}", e.what());
    }
    if (!end.has_scene) throw Failure(kLoadError, end.error);
    if (file_) file_->close({scene_}, "finished");
    if (options.json)
      fmt::print("{}",
                 report::to_text({{"seconds", end.seconds}, {"steps", end.steps}, {"hash", hash_text(end.hash)}}));
    else if (hash_)
      fmt::print("{}\n", hash_text(end.hash));
    return kPass;
  }

 private:
  // Each reload makes a world: its first note is the script, where that is another than before.
  void record(const Options& options) {
    file_.emplace(record_, scene_, options, 1);
    o_.live.host.made = [this](World& world) {
      file_->recorder().add(world);
      const std::string text = read_text(scene_);
      if (text != noted_) file_->recorder().note(world, "script", text);
      noted_ = text;
    };
  }

  view::ReloadMode reload_mode() const {
    if (on_save_ == "catch_up") return view::ReloadMode::catch_up;
    if (on_save_ == "start_over") return view::ReloadMode::from_start;
    if (on_save_ == "keep") return view::ReloadMode::keep;
    throw Failure(kUsage, "--on-save: expected catch_up, start_over or keep, got '{}'", on_save_);
  }

  view::Detail detail() const {
    if (detail_ == "auto") return view::Detail::as_fast_as_needed;
    if (detail_ == "full") return view::Detail::full;
    if (detail_ == "plain") return view::Detail::plain;
    if (detail_ == "least") return view::Detail::least;
    throw Failure(kUsage, "--detail: expected auto, full, plain or least, got '{}'", detail_);
  }

  void read_size() {
    if (size_.empty()) return;
    char rest = 0;
    if (std::sscanf(size_.c_str(), "%dx%d%c", &o_.width, &o_.height, &rest) != 2 || o_.width < 320 || o_.height < 240 ||
        o_.width > 16384 || o_.height > 16384)
      throw Failure(kUsage, "--size: expected WIDTHxHEIGHT of at least 320x240, got '{}'", size_);
  }

  std::string scene_, size_, seconds_, on_save_ = "catch_up", detail_ = "auto", record_, noted_;
  std::optional<RecordFile> file_;
  bool hash_ = false;
  view::ViewerOptions o_;
};

}  // namespace

Row cli_view() { return command_row<View>("view", "shows a scene in a window, and reloads it when it is saved"); }

}  // namespace feder::cli
