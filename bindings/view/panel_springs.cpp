// Nets and their points in the inspector.

#include <fmt/format.h>

#include "feder/net.h"
#include "view/fields.h"

namespace feder::view {
namespace {

void inspect_net(PanelLayout& layout, ObjectId id) {
  Springs& springs = *layout.live.world().find<Springs>();
  fact("net", fmt::format("{} points, {} springs", springs.point_count(id), springs.spring_count(id)));
  if (layout.selected->point == kNone) return;
  const std::uint32_t i = layout.selected->point;
  fact("point", fmt::format("{} of {}, {:.4g} kg{}", i + 1, springs.point_count(id), springs.point_mass(id, i),
                            springs.pinned(id, i) ? ", pinned" : ""));
  Vec3 x = springs.point(id, i), v = springs.velocity(id, i);
  if (edit_vector("position", x, 0.01f))
    layout.live.act([id, i, x](lua::Script& s) { s.world()->find<Springs>()->set_point(id, i, x); }, "position");
  if (edit_vector("velocity", v, 0.05f))
    layout.live.act([id, i, v](lua::Script& s) { s.world()->find<Springs>()->set_velocity(id, i, v); }, "velocity");
}

}  // namespace

SystemPanel window_springs() { return {&kNetKind, inspect_net}; }

}  // namespace feder::view
