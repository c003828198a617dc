// feder export: a scene for other programs: a run as animated glTF 2.0, a moment as OBJ or PLY.
#include "view/export.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "cli/picture.h"
#include "feder/error.h"
#include "report/json.h"

namespace feder::cli {
namespace {

class Export final : public Command {
 public:
  void declare(Arguments& a) override {
    a.text("SCENE", scene_, "a .lua or .yaml file");
    a.require("SCENE");
    a.text("-o,--out", out_, "file.gltf or file.glb (a run), file.obj or file.ply (a moment)");
    a.require("--out");
    a.text("--at", at_, "moment of .obj and .ply, start of a run (default: the scene's picture; 0 for a run)");
    a.text("--seconds", seconds_, "length of a run (default: what the scene says, else 4)");
    a.text("--fps", fps_, "samples per simulated second (default 30)");
    a.text("--show", show_, "layers, as in feder render");
  }

  int run(const Options& options) override {
    PictureOptions given;
    given.at = at_, given.show = show_;
    const PictureWish wish = read_wish(given);
    const std::string kind = std::filesystem::path(out_).extension().string();
    if (kind != ".gltf" && kind != ".glb" && kind != ".obj" && kind != ".ply")
      throw Failure(kUsage, "feder export: expected -o file.gltf, .glb, .obj or .ply, got {}", out_);
    Session session(silent_host_options(options), print_error, scene_);
    if (!session.world()) throw Failure(kFailed, scene_ + ": this script makes no world");
    const bool animated = kind == ".gltf" || kind == ".glb";
    try {
      const std::size_t samples = animated ? write_run(session, wish) : write_moment(session, wish, kind);
      if (options.json)
        print_json({{"out", out_}, {"samples", samples}, {"title", session.title()}});
      else if (!options.quiet)
        fmt::print("{}{}\n", out_, samples > 1 ? fmt::format(", {} samples", samples) : "");
    } catch (const SceneError& e) {
      throw Failure(kFailed, e.what());
    }
    return kPass;
  }

 private:
  std::size_t write_moment(Session& session, const PictureWish& wish, const std::string& kind) const {
    run_to(session, wish.at >= 0 ? wish.at : thumbnail_time(session.script()));
    view::Collector collector;
    view::Frame frame;
    collector.collect(*session.world(), session.script().appearance(), wish.toggles, frame);
    if (kind == ".obj")
      view::write_obj(frame, session.world()->objects(), out_);
    else
      view::write_ply(frame, out_);
    return 1;
  }

  std::size_t write_run(Session& session, const PictureWish& wish) const {
    const double fps = read_fps(fps_, 30), from = std::max(wish.at, 0.0);
    const double length = session.is_scene() ? animation_length(seconds_, session.script()) : 0;
    const auto count = static_cast<std::size_t>(std::min(100000.0, std::floor(length * fps + 0.5) + 1));
    view::Collector collector;
    view::Frame frame;
    view::GltfWriter writer;
    for (std::size_t i = 0; i < count; ++i) {
      run_to(session, from + static_cast<double>(i) / fps);
      collector.collect(*session.world(), session.script().appearance(), wish.toggles, frame);
      writer.add(frame, session.world()->objects());
    }
    if (writer.left_out() > 0)
      fmt::print(stderr, "{}: {} points are left out (glTF takes up to {}; .ply of a moment has them all)\n", out_,
                 writer.left_out(), view::kMaxAnimatedPoints);
    writer.write(out_);
    return count;
  }

  std::string scene_, out_, at_, seconds_, fps_, show_;
};

}  // namespace

Row cli_export() {
  return command_row<Export>("export", "writes a scene for other programs: animated glTF 2.0, OBJ or PLY of a moment");
}

}  // namespace feder::cli
