// feder render: pictures of a scene without a window: one PNG, a GIF, a folder of PNG frames, or one sheet of many
// scenes.
#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <optional>

#include "cli/picture.h"
#include "cli/scene_files.h"
#include "cli/stop.h"
#include "feder/error.h"
#include "report/json.h"

namespace feder::cli {
namespace {

namespace fs = std::filesystem;

class Render final : public Command {
 public:
  void declare(Arguments& a) override {
    a.list("SCENE", scenes_, "a .lua or .yaml file; several files or a folder make a contact sheet");
    a.require("SCENE");
    a.text("-o,--out", out_, "picture.png, animation.gif, or a folder for PNG frames (\"frames/\")");
    a.require("--out");
    cli::declare(a, picture_);
    a.text("--seconds", seconds_, "length of an animation (default: what the scene says, else 4)");
    a.text("--fps", fps_, "frames per simulated second of an animation (default 30, GIF 20)");
  }

  int run(const Options& options) override {
    const PictureWish wish = read_wish(picture_);
    host_options(options);  // complain about the options before anything runs
    const std::vector<std::string> files =
        find_files(scenes_, [](const std::string& f) { return looks_like_scene(f, "feder.scene"); });
    if (files.empty()) throw Failure(kNothingRan, "feder render: no scenes in " + scenes_[0]);
    const StopSignals signals;
    try {
      if (files.size() > 1 || fs::is_directory(scenes_[0])) return sheet(files, wish, options);
      if (out_.ends_with(".png")) return still(files[0], wish, options);
      return animation(files[0], wish, options);
    } catch (const view::GlError& e) {
      throw Failure(kFailed, "feder render: {}", e.what());
    } catch (const SceneError& e) {
      throw Failure(kFailed, e.what());
    }
  }

 private:
  // `wanted`: pictures that were to be there.
  int report_end(const Options& options, const std::string& how, const Session* session, int frames, int wanted) const {
    if (options.json) {
      report::Json json = {{"out", out_}, {"frames", frames}, {"gl", how}};
      if (session) json["title"] = session->title();
      print_json(json);
    } else if (!options.quiet) {
      fmt::print("{}{} ({})\n", out_, wanted > 1 ? fmt::format(", {} frames", frames) : "", how);
    }
    if (!stop_flag()) return kPass;
    print_error(fmt::format("feder render: {}, {} of {} pictures are there", stop_text(), frames, wanted));
    return stop_status();
  }

  int still(const std::string& file, const PictureWish& wish, const Options& options) const {
    view::RendererHost renderer(wish.width, wish.height);
    Session session(silent_host_options(options), print_error, file);
    run_to(session, wish.at >= 0 ? wish.at : thumbnail_time(session.script()));
    view::write_png(take_picture(renderer, session, wish), out_);
    return report_end(options, renderer.how(), &session, 1, 1);
  }

  int sheet(const std::vector<std::string>& files, PictureWish wish, const Options& options) const {
    if (!out_.ends_with(".png"))
      throw Failure(kUsage, "feder render: a sheet of several scenes is a .png, got " + out_);
    if (picture_.size.empty()) wish.width = 480, wish.height = 320;
    int failed = 0, drawn = 0;
    const view::Image image =
        contact_sheet(files, options, wish, [&](const std::string& file, const std::string& error) {
          failed += !error.empty(), ++drawn;
          if (!error.empty()) fmt::print(stderr, "{}: {}\n", file, error);
          if (!options.quiet && !options.json && isatty(STDOUT_FILENO)) fmt::print("{}\n", file);
        });
    view::write_png(image, out_);
    const int status =
        report_end(options, fmt::format("{} scenes", drawn), nullptr, drawn, static_cast<int>(files.size()));
    return status == kPass && failed ? kFailed : status;
  }

  // The subject of a whole animation, from a run of its own: the camera must not move while things do.
  static view::Bounds subject(view::RendererHost& renderer, const std::string& file, const PictureWish& wish,
                              double from, double to, const Options& options) {
    Session probe(silent_host_options(options), print_error, file);
    view::Bounds all;
    constexpr int kSamples = 12;
    for (int i = 0; i <= kSamples; ++i) {
      run_to(probe, from + (to - from) * i / kSamples);
      all.include(view::subject_of(renderer.collect(probe.script(), wish.toggles)));
    }
    return all;
  }

  void make_folder() const {
    std::error_code error;
    fs::create_directories(out_, error);
    if (error) throw Failure(kFailed, "{}: cannot be made: {}", out_, error.message());
  }

  int animation(const std::string& file, const PictureWish& given, const Options& options) const {
    const bool gif = out_.ends_with(".gif");
    if (!gif && !out_.ends_with("/") && fs::path(out_).has_extension())
      throw Failure(kUsage, "feder render: expected -o file.png, file.gif or a folder, got {}", out_);
    PictureWish wish = given;
    if (gif && picture_.size.empty()) wish.width = 640, wish.height = 360;
    const double fps = read_fps(fps_, gif ? 20 : 30);
    view::RendererHost renderer(wish.width, wish.height);
    Session session(silent_host_options(options), print_error, file);
    if (!session.is_scene())
      throw Failure(kUsage, file + ": this plain script has run already; an animation needs a scene");
    const double from = std::max(wish.at, 0.0), length = animation_length(seconds_, session.script());
    const auto count = static_cast<int>(std::min(100000.0, std::max(1.0, std::floor(length * fps + 0.5))));
    const view::Bounds seen = subject(renderer, file, wish, from, from + length, options);
    const view::Camera camera =
        renderer.aim(session.script(), wish.camera, seen, session.world()->desc().dimension == 2);
    std::optional<view::GifWriter> writer;
    if (gif) writer.emplace(out_, wish.width, wish.height, fps);
    if (!gif) make_folder();
    int drawn = 0;
    NotePrinter notes(file);
    for (; drawn < count && run_on_to(session, from + drawn / fps); ++drawn) {
      notes.print(renderer.collect(session.script(), wish.toggles));
      const view::Image image = renderer.draw(camera, {});
      if (gif)
        writer->add(image);
      else
        view::write_png(image, fs::path(out_) / fmt::format("frame{:05d}.png", drawn));
    }
    if (gif && drawn > 0) writer->close();
    return report_end(options, renderer.how(), &session, drawn, count);
  }

  std::vector<std::string> scenes_;
  std::string out_, seconds_, fps_;
  PictureOptions picture_;
};

}  // namespace

Row cli_render() {
  return command_row<Render>(
      "render", "draws a scene: a PNG, a GIF, a folder of frames, or a sheet of many scenes; needs no display");
}

}  // namespace feder::cli
