// Bodies in the inspector, and the choice of their solver.

#include <fmt/format.h>

#include "feder/query.h"
#include "feder/rigid.h"
#include "rigid/solver.h"
#include "state/bodies.h"
#include "state/colliders.h"
#include "view/fields.h"
#include "view/theme.h"

namespace feder::view {
namespace {

// Does f(rigid, body) between two steps, unless the body is gone by then.
template <class F>
void act(PanelLayout& layout, ObjectId id, const char* name, F f) {
  const auto command = [id, f](lua::Script& s) {
    if (s.world()->objects().alive(id)) f(*s.world()->find<Rigid>(), id);
  };
  layout.live.act(command, name);
}

void edit_body_type(PanelLayout& layout, ObjectId id, BodyType now) {
  const char* const names[] = {"static", "kinematic", "dynamic"};
  const BodyType types[] = {BodyType::fixed, BodyType::kinematic, BodyType::dynamic};
  int at = now == BodyType::fixed ? 0 : now == BodyType::kinematic ? 1 : 2;
  label("type");
  if (ImGui::Combo("##type", &at, names, 3))
    act(layout, id, "type", [type = types[at]](Rigid& r, ObjectId b) { r.set_type(b, type); });
}

void edit_surface(PanelLayout& layout, ObjectId id, const Bodies& b, std::uint32_t i) {
  const Colliders& c = layout.live.world().find<Collide>()->colliders();
  const std::uint32_t k = b.first_collider[i];
  Real x = 0;
  if (k != kNone) {
    if (edit_number("friction", c.friction_static[k], 0, 10, x))
      act(layout, id, "friction", [x](Rigid& r, ObjectId o) { r.set_friction(o, x, x); });
    if (edit_number("restitution", c.restitution[k], 0, 1, x))
      act(layout, id, "restitution", [x](Rigid& r, ObjectId o) { r.set_restitution(o, x); });
  }
  if (edit_number("gravity", b.gravity_scale[i], -10, 10, x))
    act(layout, id, "gravity scale", [x](Rigid& r, ObjectId o) { r.set_gravity_scale(o, x); });
  if (edit_number("damping", b.linear_damping[i], 0, 100, x)) {
    const Real angular = b.angular_damping[i];
    act(layout, id, "damping", [x, angular](Rigid& r, ObjectId o) { r.set_damping(o, x, angular); });
  }
}

void inspect_body(PanelLayout& layout, ObjectId id) {
  Rigid& rigid = *layout.live.world().find<Rigid>();
  const Bodies& b = rigid.bodies();
  const std::uint32_t i = rigid.index(id);
  edit_body_type(layout, id, b.type[i]);
  Pose pose = rigid.pose(id);
  Vec3 velocity = b.velocity[i], angular_velocity = b.angular_velocity[i];
  if (edit_vector("position", pose.position, 0.02f))
    act(layout, id, "position", [pose](Rigid& r, ObjectId o) { r.set_pose(o, pose); });
  if (b.type[i] != BodyType::fixed) {
    if (edit_vector("velocity", velocity, 0.05f))
      act(layout, id, "velocity", [velocity](Rigid& r, ObjectId o) { r.set_velocity(o, velocity); });
    if (edit_vector("spin", angular_velocity, 0.05f))
      act(layout, id, "spin",
          [angular_velocity](Rigid& r, ObjectId o) { r.set_angular_velocity(o, angular_velocity); });
  }
  edit_surface(layout, id, b, i);
  const char* state = b.type[i] == BodyType::fixed ? "never moves" : b.awake[i] ? "awake" : "asleep";
  fact("state", fmt::format("{:.4g} kg, {}", b.mass[i], state));
}

void choose_solver(PanelLayout& layout) {
  LiveScene& live = layout.live;
  if (!live.world().find<Rigid>()) return;
  const WorldDesc& d = live.world().desc();
  const auto options = d.systems.find("rigid");
  const std::string solver = rigid_solver(options == d.systems.end() ? Params() : options->second).name;
  label("solver", kOptions);
  if (!ImGui::BeginCombo("##solver", solver.c_str())) return;
  for (const auto& v : rigid_solvers()) {
    if (ImGui::Selectable(v.name, solver == v.name)) live.set_world_option("rigid.solver", v.name);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", v.summary);
  }
  ImGui::EndCombo();
}

}  // namespace

SystemPanel window_rigid() { return {&kBodyKind, inspect_body, choose_solver}; }

}  // namespace feder::view
