// Fields of the inspector, and the part of the panels that each system brings: panel_<system>.cpp.
#pragma once
#include "view/panel_layout.h"

namespace feder::view {

// The name of a field, then the field as wide as there is room; `at`: where it begins.
void label(const char* name, float at = 92);
void fact(const char* name, const std::string& value);
// Three numbers; true when they were changed.
bool edit_vector(const char* name, Vec3& v, float speed);
bool edit_number(const char* name, Real now, float low, float high, Real& out);

struct SystemPanel {
  const ObjectKind* kind;
  void (*inspect)(PanelLayout&, ObjectId);  // fields of one object
  void (*options)(PanelLayout&) = nullptr;  // of the world, when it has the system
};
std::span<const SystemPanel> system_panels();
inline constexpr float kOptions = 86;  // where the fields of the world's options begin

}  // namespace feder::view
