#include "cli/picture.h"

#include <fmt/format.h>

#include "cli/stop.h"
#include "feder/error.h"

namespace feder::cli {

void declare(Arguments& a, PictureOptions& o) {
  a.text("--at", o.at, "moment in simulated seconds (default: what the scene says, else the middle of its time)");
  a.text("--size", o.size, "WxH in pixels (default 1280x720)");
  a.text("--camera", o.camera,
         "yaw,pitch[,distance] in degrees and m, or eye and target x,y,z,tx,ty,tz (default: fitted)");
  a.text("--show", o.show,
         "layers, \"-\" turns one off: shapes meshes points springs sensors joints contacts impulses "
         "velocities axes islands bounds volumes labels marks; volumes=3 those of level 3; speed, density or pressure "
         "colours fluids");
}

PictureWish read_wish(const PictureOptions& o) {
  PictureWish wish;
  const auto reading = [](const char* option, auto&& read) {
    try {
      read();
    } catch (const SceneError& e) {
      throw Failure(kUsage, "{}: {}", option, e.what());
    }
  };
  if (!o.at.empty()) wish.at = read_number(o.at, "--at");
  if (!o.size.empty()) reading("--size", [&] { view::read_size(o.size, wish.width, wish.height); });
  if (!o.camera.empty()) reading("--camera", [&] { wish.camera = view::read_camera(o.camera); });
  if (!o.show.empty()) reading("--show", [&] { view::set_toggles(wish.toggles, o.show); });
  return wish;
}

double thumbnail_time(const lua::Script& script) {
  if (script.picture() >= 0) return script.picture();
  return script.seconds() > 0 ? script.seconds() / 2 : 1;
}

void run_to(Session& session, double seconds) {
  if (!session.world()) throw Failure(kFailed, session.file() + ": this script makes no world");
  if (!session.is_scene()) return;
  const std::uint64_t steps = session.steps_for(seconds);
  while (session.world()->step_count() < steps) {
    session.need_to_go_on();
    session.step();
  }
  session.need_to_go_on();
}

bool run_on_to(Session& session, double seconds) {
  try {
    run_to(session, seconds);
  } catch (const Failure&) {
    if (!stop_flag()) throw;
    return false;
  }
  return true;
}

double read_fps(const std::string& given, double otherwise) {
  const double fps = given.empty() ? otherwise : read_number(given, "--fps");
  if (!(fps > 0) || fps > 1000) throw Failure(kUsage, "--fps: expected a number above 0, at most 1000, got " + given);
  return fps;
}

double animation_length(const std::string& given, const lua::Script& script) {
  if (!given.empty()) return read_number(given, "--seconds");
  return script.seconds() > 0 ? script.seconds() : 4;
}

void NotePrinter::print(const view::Frame& frame) {
  for (const view::Note& n : frame.notes)
    if (said_.insert(n.object).second) print_error(fmt::format("{}: {}", scene_, n.text));
}

view::Image take_picture(view::RendererHost& renderer, Session& session, const PictureWish& wish) {
  const view::Frame& frame = renderer.collect(session.script(), wish.toggles);
  NotePrinter(session.file()).print(frame);
  const view::Camera camera =
      renderer.aim(session.script(), wish.camera, view::subject_of(frame), frame.dimension == 2);
  return renderer.draw(camera, {});
}

}  // namespace feder::cli
