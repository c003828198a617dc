// feder export: a scene for other programs: a run as animated glTF 2.0, a moment as OBJ, PLY or VTK, a series of VTK.
#include "view/export.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "cli/picture.h"
#include "cli/stop.h"
#include "feder/error.h"
#include "report/json.h"
#include "report/vtk.h"

namespace feder::cli {
namespace {

namespace fs = std::filesystem;

constexpr double kMostMoments = 100000;

class Export final : public Command {
 public:
  void declare(Arguments& a) override {
    a.text("SCENE", scene_, "a .lua or .yaml file");
    a.require("SCENE");
    a.text("-o,--out", out_,
           "file.gltf or file.glb (a run), file.obj, file.ply or file.vtp (a moment; .vtp: particles and points)");
    a.require("--out");
    a.text("--at", at_, "moment of .obj, .ply and .vtp, start of a run (default: the scene's picture; 0 for a run)");
    a.text("--every", every_, "of .vtp: a series, a file each so many seconds, and an index for ParaView, file.pvd");
    a.text("--seconds", seconds_, "length of a run or series (default: what the scene says, else 4)");
    a.text("--fps", fps_, "samples per simulated second of a run (default 30)");
    a.text("--show", show_, "layers, as in feder render");
  }

  int run(const Options& options) override {
    PictureOptions given;
    given.at = at_, given.show = show_;
    const PictureWish wish = read_wish(given);
    const std::string kind = fs::path(out_).extension().string();
    if (kind != ".gltf" && kind != ".glb" && kind != ".obj" && kind != ".ply" && kind != ".vtp")
      throw Failure(kUsage, "feder export: expected -o file.gltf, .glb, .obj, .ply or .vtp, got {}", out_);
    if (!every_.empty() && kind != ".vtp") throw Failure(kUsage, "feder export: --every makes a series of .vtp");
    const StopSignals signals;
    Session session(silent_host_options(options), print_error, scene_);
    if (!session.world()) throw Failure(kFailed, scene_ + ": this script makes no world");
    const bool animated = kind == ".gltf" || kind == ".glb";
    try {
      const Done done = animated         ? write_run(session, wish)
                        : every_.empty() ? write_moment(session, wish, kind)
                                         : write_series(session, wish);
      return finish(session, done, options);
    } catch (const std::runtime_error& e) {
      if (dynamic_cast<const Failure*>(&e)) throw;
      throw Failure(kFailed, e.what());
    }
  }

 private:
  struct Done {
    std::size_t samples = 0, wanted = 0;
  };

  int finish(Session& session, const Done& done, const Options& options) const {
    if (options.json)
      print_json({{"out", out_}, {"samples", done.samples}, {"title", session.title()}});
    else if (!options.quiet)
      fmt::print("{}{}\n", out_, done.wanted > 1 ? fmt::format(", {} samples", done.samples) : "");
    if (!stop_flag()) return kPass;
    print_error(fmt::format("{}: {}, {} of {} samples are there", scene_, stop_text(), done.samples, done.wanted));
    return stop_status();
  }

  Done write_moment(Session& session, const PictureWish& wish, const std::string& kind) const {
    run_to(session, wish.at >= 0 ? wish.at : thumbnail_time(session.script()));
    if (kind == ".vtp") {
      write_points(session, out_);
      return {1, 1};
    }
    view::Collector collector;
    view::Frame frame;
    collector.collect(*session.world(), session.script().appearance(), wish.toggles, frame);
    if (kind == ".obj")
      view::write_obj(frame, session.world()->objects(), out_);
    else
      view::write_ply(frame, out_);
    return {1, 1};
  }

  void write_points(Session& session, const fs::path& file) const {
    if (report::write_vtp(*session.world(), file) == 0)
      throw Failure(kFailed, "{}: no particles or points at {:g} s (.gltf, .obj and .ply have bodies)", scene_,
                    session.world()->time());
  }

  // Of a scene. Failure (usage) when the moments are too many.
  std::size_t moments(Session& session, double per_second) const {
    const double length = session.is_scene() ? animation_length(seconds_, session.script()) : 0;
    const double count = std::floor(length * per_second + 0.5) + 1;
    if (!(count <= kMostMoments))
      throw Failure(kUsage, "feder export: expected at most {:g} moments, got {:g}", kMostMoments, count);
    return static_cast<std::size_t>(count);
  }

  // file00000.vtp ... and file.pvd, which lists those that are there.
  Done write_series(Session& session, const PictureWish& wish) const {
    const double every = read_number(every_, "--every"), from = std::max(wish.at, 0.0);
    if (!(every > 0)) throw Failure(kUsage, "--every: expected more than 0 seconds");
    Done done{0, moments(session, 1 / every)};
    const fs::path stem = fs::path(out_).replace_extension();
    std::vector<report::SeriesEntry> entries;
    for (; done.samples < done.wanted; ++done.samples) {
      if (!run_on_to(session, from + static_cast<double>(done.samples) * every)) break;
      const fs::path file = fmt::format("{}{:05d}.vtp", stem.string(), done.samples);
      write_points(session, file);
      entries.push_back({file.filename().string(), session.world()->time()});
    }
    report::write_pvd(entries, fs::path(out_).replace_extension(".pvd"));
    return done;
  }

  Done write_run(Session& session, const PictureWish& wish) const {
    const double fps = read_fps(fps_, 30), from = std::max(wish.at, 0.0);
    Done done{0, moments(session, fps)};
    view::Collector collector;
    view::Frame frame;
    view::GltfWriter writer;
    for (; done.samples < done.wanted; ++done.samples) {
      if (!run_on_to(session, from + static_cast<double>(done.samples) / fps)) break;
      collector.collect(*session.world(), session.script().appearance(), wish.toggles, frame);
      writer.add(frame, session.world()->objects());
    }
    if (writer.left_out() > 0)
      fmt::print(stderr, "{}: {} points are left out (glTF takes up to {}; .ply and .vtp have them all)\n", out_,
                 writer.left_out(), view::kMaxAnimatedPoints);
    if (done.samples > 0) writer.write(out_);
    return done;
  }

  std::string scene_, out_, at_, every_, seconds_, fps_, show_;
};

}  // namespace

Row cli_export() {
  return command_row<Export>("export",
                             "writes a scene for other programs: animated glTF 2.0, OBJ, PLY and VTK of moments");
}

}  // namespace feder::cli
