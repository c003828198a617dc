// What the panels of the viewer show and change. Plain data; each panel is a function of its own file.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lua/completion.h"
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
  std::function<lua::Completion(std::string_view)> complete;  // of what stands before the cursor; may be empty
  void add(ConsoleLine::Kind kind, const std::string& text);
};

// A slider that is being moved: the scene is made anew when the mouse rests, or ten times a second.
struct PendingParam {
  std::string name, value;
  double since = 0;  // s
};

struct PanelLayout {
  explicit PanelLayout(LiveScene& scene) : live(scene) {}

  LiveScene& live;
  Camera camera;
  Toggles toggles;
  Sampler sampler;
  Console console;
  std::vector<SceneEntry> scenes;

  std::optional<Pick> selected;
  std::string selected_name;      // finds it again after a reload
  std::uint64_t selected_in = 0;  // generation of the scene
  bool follow = false;
  bool deeper_volumes = false, deeper_cells = false;  // below the level that is drawn
  int shots = 0;
  float shot_speed = 20;  // m/s

  bool show_ui = true, show_left = true, show_right = true, show_console = false, show_help = false,
       show_picker = false;
  std::string search;
  std::optional<PendingParam> pending;
  bool fit = true;         // frame everything in the next picture
  bool auto_frame = true;  // and step back as things spread out, until the user takes the camera
  bool save_picture = false;
  std::string open_file;           // asked for by the picker
  double now = 0;                  // s
  std::vector<std::string> notes;  // what is not drawn as asked for
  int pictures = 0;
  double frame_ms = 0, cpu_ms = 0;  // of a picture: wall time, and what the processor took without waiting

  // The selected object when it is there, found again by name in a new world.
  bool has_selection();
  void select(const std::optional<Pick>& pick);
};

// The volumes or cells of the next level, then none, then the first level.
void next_volumes(PanelLayout& layout);
void next_cells(PanelLayout& layout);

// Where the panels stand, in mouse units.
struct PanelSizes {
  float width = 0, height = 0;
  float top = 38, bottom = 66, left = 0, right = 0, console = 0;  // sizes of the panels; 0: hidden
};
PanelSizes panel_sizes(const PanelLayout& layout, float width, float height);

void draw_top_bar(PanelLayout& layout, const PanelSizes& sizes);
void draw_transport(PanelLayout& layout, const PanelSizes& sizes);
void draw_scene_panel(PanelLayout& layout, const PanelSizes& sizes);  // left: parameters, world, what is drawn
void draw_watch_panel(PanelLayout& layout, const PanelSizes& sizes);  // right: inspector, times, curves
void draw_console(PanelLayout& layout, const PanelSizes& sizes);
void draw_messages(PanelLayout& layout, const PanelSizes& sizes);     // errors over the view
void draw_notes(const PanelLayout& layout, const PanelSizes& sizes);  // above the bar below; the level of volumes too
void draw_grip(PanelLayout& layout, float pixels_per_unit,
               const Target& target);  // the grip's spring, the selection's name
void draw_picker(PanelLayout& layout, const PanelSizes& sizes);
void draw_help(PanelLayout& layout, const PanelSizes& sizes);
void draw_inspector(PanelLayout& layout);

}  // namespace feder::view
