// The interactive viewer: a window on a LiveScene. Everything it knows about the world comes through the frame
// description; everything it does to it is a Command.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "lua/completion.h"
#include "view/live_scene.h"

namespace feder::view {

// How much care a picture is drawn with: smooth edges and shadows; no smooth edges; no shadows either; or what the
// machine manages fluently.
enum class Detail : std::uint8_t { full, plain, least, as_fast_as_needed };

struct ViewerOptions {
  std::filesystem::path file;
  LiveOptions live;
  int width = 1280, height = 800;  // of the window
  bool paused = false, hide_panels = false, console = false, help = false;
  Detail detail = Detail::as_fast_as_needed;
  std::string toggles;  // layers to draw, as set_toggles takes them
  std::string select;   // name of the object to select
  double seconds = -1;  // >= 0: runs so many simulated seconds without waiting for the clock, and ends
  int frames = -1;      // >= 0: ends after so many pictures
  std::string picture;  // PNG of the window: of the last picture, or of number `picture_at`
  int picture_at = -1;
  std::function<lua::Completion(std::string_view)> complete;  // what Tab offers in the console; empty: nothing
  std::string status;  // JSON file that tells what is going on, a few times a second
};

struct ViewerEnd {
  bool has_scene = false;
  double seconds = 0;  // simulated
  std::uint64_t steps = 0, hash = 0;
  std::string error;  // of the last load
};

// WindowError when there is no display; SceneError for bad options.
ViewerEnd run_viewer(const ViewerOptions& options);

}  // namespace feder::view
