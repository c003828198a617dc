// What the commands that draw share: a scene run up to a moment, and pictures of it.
#pragma once
#include <functional>
#include <set>

#include "cli/session.h"
#include "view/renderer_host.h"

namespace feder::cli {

// Options of a picture as given; empty when not given.
struct PictureOptions {
  std::string at, size, camera, show;
};
void declare(Arguments& arguments, PictureOptions& options);

struct PictureWish {
  double at = -1;  // s; < 0: the scene's own moment
  int width = 1280, height = 720;
  view::CameraWish camera;
  view::Toggles toggles;
};
// Failure (usage) for what cannot be read.
PictureWish read_wish(const PictureOptions& options);

// Thumbnail time, s: what the scene says, else the middle of its time.
double thumbnail_time(const lua::Script& script);

// A plain script has run when it is loaded; a scene is stepped to `seconds`. Failure when there is no world.
void run_to(Session& session, double seconds);
// The same; false when the command has to end before (cli/stop.h).
bool run_on_to(Session& session, double seconds);

// Of an animation: samples per second as given, else `otherwise`; its length, s, as given, else the scene's own,
// else 4.
double read_fps(const std::string& given, double otherwise);
double animation_length(const std::string& given, const lua::Script& script);

// What pictures do not show as asked for, on stderr: once for each object.
class NotePrinter {
 public:
  explicit NotePrinter(std::string scene) : scene_(std::move(scene)) {}
  void print(const view::Frame& frame);

 private:
  std::string scene_;
  std::set<ObjectId> said_;
};

// The picture now, with the camera that fits it; notes are printed.
view::Image take_picture(view::RendererHost& renderer, Session& session, const PictureWish& wish);

// All of `scenes` in one picture, with title and command below each; a scene that fails shows its error. Calls
// `done(file, error)` after each.
view::Image contact_sheet(const std::vector<std::string>& scenes, const Options& options, const PictureWish& wish,
                          const std::function<void(const std::string&, const std::string&)>& done);

}  // namespace feder::cli
