#include "view/viewer.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "feder/profile.h"
#include "view/collector.h"
#include "view/panel_layout.h"
#include "view/renderer_host.h"
#include "view/status.h"
#include "view/viewer_input.h"
#include "view/window.h"

namespace feder::view {
namespace {

constexpr double kStatusEvery = 0.05;  // s
constexpr double kFastTick = 0.1;      // simulated seconds per picture when nobody watches
constexpr float kFarthest = 12;        // times the first distance: how far the camera steps back by itself
constexpr double kSlowPicture = 40;    // ms: above, the picture is made with less care

double clock_seconds() { return static_cast<double>(clock_nanoseconds()) * 1e-9; }

// print() of scenes goes to the console.
LiveOptions with_print(LiveOptions options, PanelLayout& layout) {
  options.host.print = [&layout](std::string_view text) { layout.console.add(ConsoleLine::print, std::string(text)); };
  return options;
}

// Fits the camera to the part of the window that the panels leave.
void fit_between(Camera& camera, const Bounds& subject, const PanelSizes& sizes) {
  const float width = std::max(100.0f, sizes.width - 2 * std::max(sizes.left, sizes.right));
  const float height = std::max(100.0f, sizes.height - 2 * std::max(sizes.top, sizes.bottom + sizes.console));
  camera.fit(subject, width / height);
  // the camera's height is the window's: stand back by what the bars take
  camera.distance *= sizes.height / height;
}

class Viewer {
 public:
  explicit Viewer(const ViewerOptions& options)
      : options_(options), window_(options.width, options.height, "feder"), live_(with_print(options.live, layout_)),
        renderer_(window_.loader()) {
    set_toggles(layout_.toggles, options.toggles);
    window_.keep_pace(options.seconds < 0);
    layout_.show_ui = !options.hide_panels;
    layout_.show_console = options.console, layout_.show_help = options.help;
    layout_.console.complete = options.complete, layout_.console.focus = options.console;
    live_.set_paused(options.paused);
    layout_.scenes = scenes_beside(options.file);
    live_.open(options.file);
  }

  ViewerEnd run() {
    last_ = clock_seconds();
    while (one_picture()) {
    }
    ViewerEnd end;
    end.has_scene = live_.has_scene();
    end.error = live_.error();
    if (end.has_scene)
      end.seconds = live_.world().time(), end.steps = live_.world_step(), end.hash = live_.world().hash();
    return end;
  }

 private:
  bool is_last() const {
    if (options_.frames >= 0 && pictures_ + 1 >= options_.frames) return true;
    return options_.seconds >= 0 && (live_.stopped() || !live_.has_scene());
  }

  // False: the end.
  bool one_picture() {
    if (window_.closed()) return false;
    // input, then the scene as far as the clock says
    window_.begin_frame();
    const double begun = clock_seconds();
    open_asked();
    const Target target = window_.target();
    const float scale = window_.pixels_per_unit();
    const PanelSizes sizes =
        panel_sizes(layout_, static_cast<float>(target.width) / scale, static_cast<float>(target.height) / scale);
    input_.take(layout_, window_);
    run_scene();
    collect();
    // the camera, the picture, the panels over it
    if (layout_.fit) aim(sizes);
    if (layout_.auto_frame) step_back(sizes);
    follow();
    renderer_.draw(frame_, layout_.camera, care(), target);
    panels(sizes);
    // what is asked of this picture: files, the status
    const bool last = is_last();
    const bool wanted =
        !options_.picture.empty() && (options_.picture_at >= 0 ? pictures_ == options_.picture_at : last);
    if (wanted || layout_.save_picture) window_.want_picture();
    layout_.cpu_ms += 0.1 * ((clock_seconds() - begun) * 1000 - layout_.cpu_ms);
    window_.end_frame();
    if (wanted) write_png(window_.picture(), options_.picture);
    if (layout_.save_picture)
      write_png(window_.picture(), "feder-" + live_.title() + "-" + std::to_string(live_.shown_step()) + ".png");
    layout_.save_picture = false;
    if (!options_.status.empty() && (last || layout_.now - status_at_ > kStatusEvery)) {
      status_at_ = layout_.now;
      write_status(layout_, target, scale, options_.status);
    }
    layout_.pictures = ++pictures_;
    return !last;
  }

  void run_scene() {
    const double now = clock_seconds();
    const double wall = now - last_;
    last_ = now;
    layout_.now = now;
    layout_.frame_ms += 0.05 * (wall * 1000 - layout_.frame_ms);
    if (options_.seconds >= 0 && live_.has_scene() && !seconds_set_) {
      live_.stop_at(static_cast<std::uint64_t>(std::llround(options_.seconds / live_.world().desc().dt)));
      seconds_set_ = true;
    }
    live_.tick(options_.seconds >= 0 ? kFastTick : wall, now);
    layout_.sampler.sample(live_, layout_.show_ui && layout_.show_right);
    if (live_.has_scene() && titled_ != live_.generation()) {
      titled_ = live_.generation();
      window_.set_title(live_.title() + " - feder");
      const ObjectId wanted = options_.select.empty() ? ObjectId{} : live_.world().objects().find(options_.select);
      if (wanted && !layout_.selected) layout_.select(Pick{wanted, kNone, Vec3::Zero(), 0, true});
    }
  }

  void collect() {
    // while the past is lived again there is nothing new to see
    if (!live_.has_scene() || live_.rewriting()) return;
    collector_.collect(live_.world(), live_.script().appearance(), layout_.toggles, frame_);
    layout_.notes.assign(frame_.notes.size(), {});
    for (std::size_t i = 0; i < frame_.notes.size(); ++i) layout_.notes[i] = frame_.notes[i].text;
    layout_.deeper_volumes = frame_.deeper_volumes, layout_.deeper_cells = frame_.deeper_cells;
    highlight();
  }

  // The selected object shines.
  void highlight() {
    if (!layout_.has_selection()) return;
    const Color light = rgb(0xffe08a);
    for (Instance& i : frame_.instances)
      if (i.object == layout_.selected->object.slot) i.color = mixed(i.color, light, 0.45f);
    if (layout_.selected->point == kNone) return;
    const Vec3 x = view_of(live_.world(), layout_.selected->object)
                       ->position(live_.world(), layout_.selected->object, layout_.selected->point, Vec3::Zero());
    const Real size = static_cast<Real>(layout_.camera.distance * 0.012f);
    for (int k = 0; k < 3; ++k) {
      Vec3 arm = Vec3::Zero();
      arm[k] = size;
      add_line(frame_.overlay_lines, x - arm, x + arm, light, 2);
    }
  }

  void aim(const PanelSizes& sizes) {
    if (!live_.has_scene()) return;
    const bool fresh = aimed_ != live_.file();
    const lua::SceneCamera& scene = live_.script().camera();
    if (fresh) {
      layout_.camera = Camera{};
      apply_angles(scene, frame_.dimension == 2, layout_.camera);
    }
    aimed_ = live_.file();
    subject_ = subject_of(frame_);
    fit_between(layout_.camera, subject_, sizes);
    fitted_distance_ = layout_.camera.distance;
    if (fresh) apply_target(scene, layout_.camera);
    layout_.fit = layout_.follow = false;
    layout_.auto_frame = !fresh || (!scene.has_target && !scene.has_distance);
  }

  // What has been seen so far stays in the picture, within reason: who flies away is not followed.
  void step_back(const PanelSizes& sizes) {
    if (!live_.has_scene() || layout_.follow || live_.paused()) return;
    subject_.include(subject_of(frame_));
    Camera wanted = layout_.camera;
    fit_between(wanted, subject_, sizes);
    if (wanted.distance > kFarthest * fitted_distance_ || wanted.distance < layout_.camera.distance * 1.01f) return;
    const float share = options_.seconds >= 0 ? 1.0f : 1 - std::exp(-0.004f * static_cast<float>(layout_.frame_ms));
    layout_.camera.distance += share * (wanted.distance - layout_.camera.distance);
    layout_.camera.target = layout_.camera.target + share * (wanted.target - layout_.camera.target);
  }

  // A processor that draws in place of a graphics card draws less, so that input is not slowed down.
  DrawOptions care() {
    if (options_.detail != Detail::as_fast_as_needed)
      detail_ = options_.detail;
    else if (pictures_ % 10 == 9 && layout_.cpu_ms > kSlowPicture && options_.picture.empty())
      detail_ = detail_ == Detail::full ? Detail::plain : Detail::least;
    DrawOptions o;
    if (detail_ != Detail::full) o.samples = 1, o.shadow_size = 1024;
    if (detail_ == Detail::least) o.shadow_size = 0;
    return o;
  }

  void follow() {
    if (!layout_.follow || !layout_.has_selection()) {
      followed_.reset();
      return;
    }
    World& w = live_.world();
    const ObjectId id = layout_.selected->object;
    const ObjectView* view = view_of(w, id);
    const Vec3 x = view ? view->position(w, id, layout_.selected->point, Vec3::Zero()) : Vec3(Vec3::Zero());
    if (followed_ && is_finite(x)) layout_.camera.target = layout_.camera.target + to_float3(x - *followed_);
    followed_ = x;
  }

  void panels(const PanelSizes& sizes) {
    if (layout_.show_ui) {
      draw_top_bar(layout_, sizes);
      draw_scene_panel(layout_, sizes);
      draw_watch_panel(layout_, sizes);
      draw_console(layout_, sizes);
      draw_transport(layout_, sizes);
    }
    draw_messages(layout_, sizes);
    draw_notes(layout_, sizes);
    draw_grip(layout_, window_.pixels_per_unit(), window_.target());
    draw_picker(layout_, sizes);
    draw_help(layout_, sizes);
  }

  void open_asked() {
    if (layout_.open_file.empty()) return;
    const std::string file = layout_.open_file;
    layout_.open_file.clear();
    layout_.select({});
    if (live_.open(file)) layout_.fit = true;
  }

  const ViewerOptions& options_;
  Window window_;
  LiveScene live_;
  PanelLayout layout_{live_};
  ViewerInput input_;
  Collector collector_;
  Renderer renderer_;
  Frame frame_;
  double status_at_ = 0, last_ = 0;
  int pictures_ = 0;
  Detail detail_ = Detail::full;
  bool seconds_set_ = false;
  Bounds subject_;               // what has been seen of the scene since the camera was aimed
  float fitted_distance_ = 1;    // m
  std::filesystem::path aimed_;  // scene that the camera has been turned to
  std::optional<Vec3> followed_;
  std::uint64_t titled_ = 0;  // generation that the window's title tells
};

}  // namespace

ViewerEnd run_viewer(const ViewerOptions& options) {
  Viewer viewer(options);
  return viewer.run();
}

}  // namespace feder::view
