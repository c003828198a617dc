// What the panels of the viewer show and change. Plain data; each panel is a function of its own file.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "view/camera.h"
#include "view/live_scene.h"
#include "view/renderer.h"
#include "view/sampler.h"
#include "view/scene_list.h"
#include "view/toggles.h"

namespace feder::view {

struct ConsoleLine {
  enum Kind { input, output, print, error } kind;
  std::string text;
};

struct Console {
  std::vector<ConsoleLine> lines;
  std::vector<std::string> past;  // inputs, for the arrow keys
  int past_at = -1;
  std::string input;
  bool scroll = false, focus = false;
  void add(ConsoleLine::Kind kind, const std::string& text);
};

// A slider that is being moved: the scene is made anew when the mouse rests, or ten times a second.
struct PendingParam {
  std::string name, value;
  double since = 0;  // s
};

struct Desk {
  explicit Desk(LiveScene& scene) : live(scene) {}

  LiveScene& live;
  Camera camera;
  Toggles toggles;
  Sampler sampler;
  Console console;
  DrawStats draw_stats;
  std::vector<SceneEntry> scenes;

  std::optional<Pick> selected;
  std::string selected_name;      // finds it again after a reload
  std::uint64_t selected_in = 0;  // generation of the scene
  bool follow = false;
  int shots = 0;
  float shot_speed = 20;  // m/s

  bool show_ui = true, show_left = true, show_right = true, show_console = false, show_help = false,
       show_picker = false;
  std::string search;
  std::optional<PendingParam> pending;
  bool fit = true;         // frame everything in the next picture
  bool auto_frame = true;  // and step back as things spread out, until the user takes the camera
  bool save_picture = false, quit = false;
  std::string open_file;  // asked for by the picker
  double now = 0;         // s
  int pictures = 0;
  double frame_ms = 0, cpu_ms = 0;  // of a picture: wall time, and what the processor took without waiting

  // The selected object when it is there, found again by name in a new world.
  bool has_selection();
  void select(const std::optional<Pick>& pick);
};

// Where the panels stand, in mouse units.
struct Layout {
  float width = 0, height = 0;
  float top = 38, bottom = 66, left = 0, right = 0, console = 0;  // sizes of the panels; 0: hidden
};
Layout make_layout(const Desk& desk, float width, float height);

void draw_top_bar(Desk& desk, const Layout& layout);
void draw_transport(Desk& desk, const Layout& layout);
void draw_scene_panel(Desk& desk, const Layout& layout);  // left: parameters, world, what is drawn
void draw_watch_panel(Desk& desk, const Layout& layout);  // right: inspector, times, curves
void draw_console(Desk& desk, const Layout& layout);
void draw_messages(Desk& desk, const Layout& layout);                     // errors over the view
void draw_grip(Desk& desk, float pixels_per_unit, const Target& target);  // the grip's spring, the selection's name
void draw_picker(Desk& desk, const Layout& layout);
void draw_help(Desk& desk, const Layout& layout);
void draw_inspector(Desk& desk);

// A curve with its range and a value under the mouse; `cursor`: the time that is shown.
void draw_curve(const std::string& name, const std::string& unit, const std::vector<CurvePoint>& points, double cursor,
                unsigned color);

}  // namespace feder::view
