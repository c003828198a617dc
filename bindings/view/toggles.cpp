#include "view/toggles.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <vector>

#include "feder/error.h"
#include "feder/params.h"

namespace feder::view {

std::span<const ToggleInfo> toggle_list() {
  static const ToggleInfo list[] = {
      {"shapes", "rigid bodies", &Toggles::shapes},
      {"meshes", "faces of nets, cloth and fluid surfaces", &Toggles::meshes},
      {"points", "net points and fluid particles", &Toggles::points},
      {"liquid", "fluids as liquids, when asked for whatever their size; without, or coloured by a quantity, particles",
       &Toggles::liquid},
      {"springs", "springs, coloured by strain", &Toggles::springs},
      {"sensors", "sensors, translucent", &Toggles::sensors},
      {"joints", "joints: anchors and axes", &Toggles::joints},
      {"contacts", "contact points and normals", &Toggles::contacts},
      {"impulses", "normal impulses of contacts", &Toggles::impulses},
      {"velocities", "velocities", &Toggles::velocities},
      {"axes", "centres of mass and body axes", &Toggles::axes},
      {"islands", "islands of bodies that touch or are joined", &Toggles::islands},
      {"bounds", "bounding boxes", &Toggles::bounds},
      {"volumes", "bounding volumes of the indices of meshes, by level; other shapes: boxes", &Toggles::volumes},
      {"cells", "nodes or cells of the broad phase, by level; of cullide what its views leave", &Toggles::cells},
      {"labels", "names", &Toggles::labels},
      {"marks", "events of the step", &Toggles::marks},
      {"plots", "energy and penetration", &Toggles::plots},
      {"temporal", "cloth smoothed over frames where it trembles, by at most its thickness", &Toggles::temporal},
  };
  return list;
}

std::span<const char* const> point_scalars() {
  static const char* const list[] = {"speed", "density", "pressure", "none"};
  return list;
}

namespace {

void set_level(Toggles& toggles, std::string_view layer, std::string_view text) {
  int level = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), level);
  if ((layer != "volumes" && layer != "cells") || error != std::errc() || end != text.data() + text.size() ||
      level < 0 || level > kMaxVolumeLevel)
    throw SceneError("layer '" + std::string(layer) +
                     "': expected a value of volumes or cells only, a level from 0 to " +
                     std::to_string(kMaxVolumeLevel) + ", got '" + std::string(text) + "'");
  (layer == "cells" ? toggles.cell_level : toggles.volume_level) = level;
}

}  // namespace

void set_toggles(Toggles& toggles, std::string_view list) {
  std::vector<std::string> names;
  for (const ToggleInfo& t : toggle_list()) names.emplace_back(t.name);
  names.insert(names.end(), point_scalars().begin(), point_scalars().end());
  while (!list.empty()) {
    const std::size_t comma = list.find(',');
    std::string_view word = list.substr(0, comma);
    list = comma == std::string_view::npos ? std::string_view() : list.substr(comma + 1);
    const bool on = !word.starts_with('-');
    if (!on) word.remove_prefix(1);
    const std::size_t equals = word.find('=');
    const bool valued = on && equals != std::string_view::npos;
    const std::string_view value = valued ? word.substr(equals + 1) : std::string_view();
    if (valued) word = word.substr(0, equals);
    const auto found = std::ranges::find(names, word);
    const auto number = static_cast<std::size_t>(found - names.begin());
    if (found == names.end()) {
      std::string known;
      for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
      const std::string near = nearest_name(std::string(word), names);
      throw SceneError("unknown layer '" + std::string(word) + "'; known: " + known +
                       (near.empty() ? "" : "; did you mean '" + near + "'?"));
    }
    if (valued) set_level(toggles, word, value);
    if (on && word == "liquid") toggles.liquid_limit = std::numeric_limits<std::size_t>::max();
    if (number < toggle_list().size())
      toggles.*toggle_list()[number].field = on;
    else
      toggles.point_scalar = on ? point_scalars()[number - toggle_list().size()] : "none", toggles.liquid = !on;
  }
}

}  // namespace feder::view
