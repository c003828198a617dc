#include "view/status.h"

#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "report/json.h"

namespace feder::view {
namespace {

using report::Json;

Json vector_json(const Vec3& v) { return Json::array({v[0], v[1], v[2]}); }

// Where the named bodies and the ends of the nets are on the screen, in mouse units.
Json screen_json(PanelLayout& layout, const Target& t, float scale) {
  constexpr std::size_t kNames = 64;
  World& w = layout.live.world();
  Json all = Json::object();
  const auto add = [&](const std::string& name, const Vec3& x) {
    float sx = 0, sy = 0;
    if (name.empty() || all.size() >= kNames || !layout.camera.project(to_float3(x), t.width, t.height, sx, sy)) return;
    all[name] = {{"screen", {sx / scale, sy / scale}}, {"position", vector_json(x)}};
  };
  for (const ObjectView* view : object_views())
    w.objects().for_each(view->kind(), [&](ObjectId id) {
      const auto [name, x] = view->landmark(w, id);
      add(name, x);
    });
  return all;
}

void scene_json(PanelLayout& layout, const Target& t, float scale, Json& json) {
  LiveScene& live = layout.live;
  char hash[20];
  std::snprintf(hash, sizeof hash, "%016" PRIx64, live.world().hash());
  json["time"] = live.shown_time();
  json["step"] = live.shown_step();
  json["hash"] = hash;
  json["paused"] = live.paused();
  json["past"] = live.in_past();
  json["catching_up"] = live.catching_up();
  json["step_ms"] = live.step_seconds() * 1000;
  Json errors = Json::array();
  for (const lua::HandlerError& e : live.script().handler_errors())
    errors.push_back({{"where", e.where}, {"message", e.message}, {"count", e.count}});
  json["handler_errors"] = errors;
  json["params"] = live.user_params();
  json["volumes"] = layout.toggles.volumes ? Json(layout.toggles.volume_level) : Json();
  json["cells"] = layout.toggles.cells ? Json(layout.toggles.cell_level) : Json();
  json["held"] = live.held().has_value();
  json["selected"] = layout.has_selection() ? Json(live.world().objects().describe(layout.selected->object)) : Json();
  json["objects"] = screen_json(layout, t, scale);
}

}  // namespace

void write_status(PanelLayout& layout, const Target& t, float scale, const std::string& file) {
  LiveScene& live = layout.live;
  Json json;
  json["file"] = live.file().string();
  json["title"] = live.title();
  json["error"] = live.error();
  json["notice"] = live.notice();
  json["notes"] = layout.notes;
  json["generation"] = live.generation();
  json["reloads"] = live.reloads();
  json["reload_seconds"] = live.reload_seconds();
  json["pictures"] = layout.pictures;
  json["frame_ms"] = layout.frame_ms;
  json["camera"] = {{"yaw", layout.camera.yaw}, {"pitch", layout.camera.pitch}, {"distance", layout.camera.distance}};
  if (live.has_scene()) scene_json(layout, t, scale, json);
  const std::string part = file + ".part";
  std::ofstream(part, std::ios::binary) << report::to_text(json);
  std::error_code ignored;
  std::filesystem::rename(part, file, ignored);
}

}  // namespace feder::view
