// The selected object: what it is, how it moves, and fields that can be edited. Every edit is a deed of the hand.
#include <cstdio>

#include "collide/collide.h"
#include "rigid/rigid.h"
#include "springs/springs.h"
#include "view/desk.h"
#include "view/theme.h"

namespace feder::view {
namespace {

constexpr float kLabel = 92;

void label(const char* name) {
  ImGui::AlignTextToFramePadding();
  ImGui::TextDisabled("%s", name);
  ImGui::SameLine(kLabel);
  ImGui::SetNextItemWidth(-1);
}

void fact(const char* name, const std::string& value) {
  ImGui::TextDisabled("%s", name);
  ImGui::SameLine(kLabel);
  ImGui::TextUnformatted(value.c_str());
}

// Three numbers; true when they were changed.
bool edit_vector(const char* name, Vec3& v, float speed) {
  float f[3] = {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
  label(name);
  ImGui::PushID(name);
  const bool changed = ImGui::DragFloat3("##v", f, speed, 0, 0, "%.2f");
  ImGui::PopID();
  if (changed)
    for (int k = 0; k < 3; ++k) v[k] = static_cast<Real>(f[k]);
  return changed;
}

bool edit_number(const char* name, Real now, float low, float high, Real& out) {
  float f = static_cast<float>(now);
  label(name);
  ImGui::PushID(name);
  const bool changed = ImGui::DragFloat("##n", &f, 0.01f, low, high, "%.3g", ImGuiSliderFlags_AlwaysClamp);
  ImGui::PopID();
  out = static_cast<Real>(f);
  return changed;
}

// A command on the rigid system that does nothing when the body is gone.
template <class F>
Command on_body(ObjectId id, F f) {
  return [id, f](lua::Script& s) {
    if (s.world()->objects().alive(id)) f(*s.world()->find<Rigid>(), id);
  };
}

void edit_body_type(Desk& desk, ObjectId id, BodyType now) {
  const char* const names[] = {"static", "kinematic", "dynamic"};
  const BodyType types[] = {BodyType::fixed, BodyType::kinematic, BodyType::dynamic};
  int at = now == BodyType::fixed ? 0 : now == BodyType::kinematic ? 1 : 2;
  label("type");
  if (ImGui::Combo("##type", &at, names, 3))
    desk.live.act(on_body(id, [type = types[at]](Rigid& r, ObjectId b) { r.set_type(b, type); }), "type");
}

void edit_surface(Desk& desk, ObjectId id, const Bodies& b, std::uint32_t i) {
  const Colliders& c = desk.live.world().find<Collide>()->colliders();
  const std::uint32_t k = b.first_collider[i];
  Real x = 0;
  if (k != kNone) {
    if (edit_number("friction", c.friction_static[k], 0, 10, x))
      desk.live.act(on_body(id, [x](Rigid& r, ObjectId o) { r.set_friction(o, x, x); }), "friction");
    if (edit_number("restitution", c.restitution[k], 0, 1, x))
      desk.live.act(on_body(id, [x](Rigid& r, ObjectId o) { r.set_restitution(o, x); }), "restitution");
  }
  if (edit_number("gravity", b.gravity_scale[i], -10, 10, x))
    desk.live.act(on_body(id, [x](Rigid& r, ObjectId o) { r.set_gravity_scale(o, x); }), "gravity scale");
  if (edit_number("damping", b.linear_damping[i], 0, 100, x)) {
    const Real turn = b.angular_damping[i];
    desk.live.act(on_body(id, [x, turn](Rigid& r, ObjectId o) { r.set_damping(o, x, turn); }), "damping");
  }
}

void inspect_body(Desk& desk, ObjectId id) {
  Rigid& rigid = *desk.live.world().find<Rigid>();
  const Bodies& b = rigid.bodies();
  const std::uint32_t i = rigid.index(id);
  edit_body_type(desk, id, b.type[i]);
  Pose pose = rigid.pose(id);
  Vec3 velocity = b.velocity[i], spin = b.angular_velocity[i];
  if (edit_vector("position", pose.position, 0.02f))
    desk.live.act(on_body(id, [pose](Rigid& r, ObjectId o) { r.set_pose(o, pose); }), "position");
  if (b.type[i] != BodyType::fixed) {
    if (edit_vector("velocity", velocity, 0.05f))
      desk.live.act(on_body(id, [velocity](Rigid& r, ObjectId o) { r.set_velocity(o, velocity); }), "velocity");
    if (edit_vector("spin", spin, 0.05f))
      desk.live.act(on_body(id, [spin](Rigid& r, ObjectId o) { r.set_angular_velocity(o, spin); }), "spin");
  }
  edit_surface(desk, id, b, i);
  char text[80];
  std::snprintf(text, sizeof text, "%.4g kg, %s", static_cast<double>(b.mass[i]),
                b.type[i] == BodyType::fixed ? "never moves"
                : b.awake[i]                 ? "awake"
                                             : "asleep");
  fact("state", text);
}

void inspect_net(Desk& desk, ObjectId id) {
  Springs& springs = *desk.live.world().find<Springs>();
  char text[80];
  std::snprintf(text, sizeof text, "%zu points, %zu springs", springs.point_count(id), springs.spring_count(id));
  fact("net", text);
  if (desk.selected->point == kNone) return;
  const std::uint32_t i = desk.selected->point;
  std::snprintf(text, sizeof text, "%u of %zu, %.4g kg%s", i + 1, springs.point_count(id),
                static_cast<double>(springs.point_mass(id, i)), springs.pinned(id, i) ? ", pinned" : "");
  fact("point", text);
  Vec3 x = springs.point(id, i), v = springs.velocity(id, i);
  if (edit_vector("position", x, 0.01f))
    desk.live.act([id, i, x](lua::Script& s) { s.world()->find<Springs>()->set_point(id, i, x); }, "position");
  if (edit_vector("velocity", v, 0.05f))
    desk.live.act([id, i, v](lua::Script& s) { s.world()->find<Springs>()->set_velocity(id, i, v); }, "velocity");
}

}  // namespace

void draw_inspector(Desk& desk) {
  if (!desk.has_selection()) {
    ImGui::TextWrapped("Click a thing to look at it; drag it to pull it.");
    return;
  }
  const Objects& objects = desk.live.world().objects();
  const ObjectId id = desk.selected->object;
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(ink::kAccent), "%s", objects.describe(id).c_str());
  if (objects.kind(id) == kBodyKind) inspect_body(desk, id);
  if (objects.kind(id) == kNetKind) inspect_net(desk, id);
  ImGui::Checkbox("camera follows", &desk.follow);
  ImGui::SameLine();
  const bool pinned = is_pinned(desk.live.world(), *desk.selected);
  if (ImGui::Button(pinned ? "free" : "pin"))
    desk.live.act(pin_command(desk.live.world(), *desk.selected), pinned ? "free" : "pin");
}

}  // namespace feder::view
