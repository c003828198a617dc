#include "view/toggles.h"

#include <algorithm>
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
      {"labels", "names", &Toggles::labels},
      {"marks", "events of the step", &Toggles::marks},
      {"plots", "energy and penetration", &Toggles::plots},
  };
  return list;
}

std::span<const char* const> point_scalars() {
  static const char* const list[] = {"speed", "density", "pressure", "none"};
  return list;
}

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
    const auto found = std::ranges::find(names, word);
    const auto number = static_cast<std::size_t>(found - names.begin());
    if (found == names.end()) {
      std::string known;
      for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
      const std::string near = nearest_name(std::string(word), names);
      throw SceneError("unknown layer '" + std::string(word) + "'; known: " + known +
                       (near.empty() ? "" : "; did you mean '" + near + "'?"));
    }
    if (on && word == "liquid") toggles.liquid_limit = std::numeric_limits<std::size_t>::max();
    if (number < toggle_list().size())
      toggles.*toggle_list()[number].field = on;
    else
      toggles.point_scalar = on ? point_scalars()[number - toggle_list().size()] : "none", toggles.liquid = !on;
  }
}

}  // namespace feder::view
