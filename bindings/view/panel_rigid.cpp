// Bodies in the inspector, and the choice of their solver.
#include <cstdio>

#include "feder/query.h"
#include "feder/rigid.h"
#include "rigid/solver.h"
#include "state/bodies.h"
#include "state/colliders.h"
#include "view/fields.h"
#include "view/theme.h"

namespace feder::view {
namespace {

// A command on the rigid system that does nothing when the body is gone.
template <class F>
Command on_body(ObjectId id, F f) {
  return [id, f](lua::Script& s) {
    if (s.world()->objects().alive(id)) f(*s.world()->find<Rigid>(), id);
  };
}

void edit_body_type(PanelLayout& layout, ObjectId id, BodyType now) {
  const char* const names[] = {"static", "kinematic", "dynamic"};
  const BodyType types[] = {BodyType::fixed, BodyType::kinematic, BodyType::dynamic};
  int at = now == BodyType::fixed ? 0 : now == BodyType::kinematic ? 1 : 2;
  label("type");
  if (ImGui::Combo("##type", &at, names, 3))
    layout.live.act(on_body(id, [type = types[at]](Rigid& r, ObjectId b) { r.set_type(b, type); }), "type");
}

void edit_surface(PanelLayout& layout, ObjectId id, const Bodies& b, std::uint32_t i) {
  const Colliders& c = layout.live.world().find<Collide>()->colliders();
  const std::uint32_t k = b.first_collider[i];
  Real x = 0;
  if (k != kNone) {
    if (edit_number("friction", c.friction_static[k], 0, 10, x))
      layout.live.act(on_body(id, [x](Rigid& r, ObjectId o) { r.set_friction(o, x, x); }), "friction");
    if (edit_number("restitution", c.restitution[k], 0, 1, x))
      layout.live.act(on_body(id, [x](Rigid& r, ObjectId o) { r.set_restitution(o, x); }), "restitution");
  }
  if (edit_number("gravity", b.gravity_scale[i], -10, 10, x))
    layout.live.act(on_body(id, [x](Rigid& r, ObjectId o) { r.set_gravity_scale(o, x); }), "gravity scale");
  if (edit_number("damping", b.linear_damping[i], 0, 100, x)) {
    const Real angular = b.angular_damping[i];
    layout.live.act(on_body(id, [x, angular](Rigid& r, ObjectId o) { r.set_damping(o, x, angular); }), "damping");
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
    layout.live.act(on_body(id, [pose](Rigid& r, ObjectId o) { r.set_pose(o, pose); }), "position");
  if (b.type[i] != BodyType::fixed) {
    if (edit_vector("velocity", velocity, 0.05f))
      layout.live.act(on_body(id, [velocity](Rigid& r, ObjectId o) { r.set_velocity(o, velocity); }), "velocity");
    if (edit_vector("spin", angular_velocity, 0.05f))
      layout.live.act(
          on_body(id, [angular_velocity](Rigid& r, ObjectId o) { r.set_angular_velocity(o, angular_velocity); }),
          "spin");
  }
  edit_surface(layout, id, b, i);
  char text[80];
  std::snprintf(text, sizeof text, "%.4g kg, %s", static_cast<double>(b.mass[i]),
                b.type[i] == BodyType::fixed ? "never moves"
                : b.awake[i]                 ? "awake"
                                             : "asleep");
  fact("state", text);
}

void choose_solver(PanelLayout& layout) {
  LiveScene& live = layout.live;
  if (!live.world().find<Rigid>()) return;
  const WorldDesc& d = live.world().desc();
  const auto options = d.systems.find("rigid");
  const std::string solver = rigid_solver(options == d.systems.end() ? Params() : options->second).name;
  option_label("solver");
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
