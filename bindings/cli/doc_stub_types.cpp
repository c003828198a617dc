#include "cli/doc_stub_types.h"

#include <algorithm>
#include <initializer_list>

namespace feder::cli {
namespace {

using Types = std::map<std::string, std::string>;

const std::string* find(const Types& types, const std::string& key) {
  const auto found = types.find(key);
  return found == types.end() ? nullptr : &found->second;
}

Types make_types_of_names() {
  Types all;
  const auto add = [&](const char* type, std::initializer_list<const char*> names) {
    for (const char* name : names) all[name] = type;
  };
  add("integer", {"i", "j", "k", "l", "n", "count", "vertices_count", "integer", "points_count", "springs", "edges"});
  add("boolean", {"on", "boolean", "tension_only"});
  add("string", {"name", "option", "snapshot", "file", "string", "what", "code", "hash"});
  add("feder.EventKind", {"kind"});
  add("function", {"fn"});
  add("any", {"default", "value"});
  add("fun(): feder.Event", {"iterator"});
  add("table", {"filter", "table"});
  add("feder.AnyObject", {"a", "b", "object"});
  add("feder.Shape", {"shape", "other_shape"});
  add("number[][]", {"points", "vertices", "triangles"});
  add("number", {"x",       "y",         "z",       "w",        "dx",           "dy",         "dz",      "nx",
                 "ny",      "nz",        "px",      "py",       "pz",           "qx",         "qy",      "qz",
                 "qw",      "d",         "e",       "s",        "max",          "angular",    "linear",  "dynamic",
                 "static",  "radius",    "width",   "height",   "depth",        "degrees",    "radians", "seconds",
                 "lo",      "hi",        "speed",   "pressure", "max_force",    "number",     "kinetic", "potential",
                 "elastic", "mean",      "largest", "ixx",      "iyy",          "izz",        "ixy",     "ixz",
                 "iyz",     "stiffness", "damping", "power",    "distance",     "separation", "impulse", "rest_length",
                 "within",  "tolerance", "limit",   "bound",    "break_strain", "during",     "wanted",  "from"});
  return all;
}

}  // namespace

const std::string* stub_type_of_name(const std::string& name) {
  static const Types all = make_types_of_names();
  return find(all, name);
}

const std::string* stub_type_of_row(const std::string& type) {
  static const std::string force =
      "(fun(x: number, y: number, z: number, vx: number, vy: number, vz: number, "
      "mass: number, t: number): number, number, number)";
  static const Types all = {
      {"boolean or string", "boolean|string"},
      {"boolean or table", "boolean|table"},
      {"color", "string|number[]"},
      {"direction", "number[]"},
      {"function(world)", "fun(world: feder.World): ..."},
      {"function(world, reference)", "fun(world: feder.World, reference: any, scene?: any): number"},
      {"function(world, scene)", "fun(world: feder.World, scene: table)"},
      {"function(world, scene, expect)", "fun(world: feder.World, scene: table, expect: feder.Expect)"},
      {"function, formula or list of formulas", force + "|string|string[]"},
      {"list", "any[]"},
      {"list of point numbers", "integer[]"},
      {"list of vectors or buffer", "number[][]|feder.Buffer"},
      {"list of vertex numbers or names", "(integer|string)[]"},
      {"list of tables", "table[]"},
      {"list of {friction =, ...}", "table[]"},
      {"list of {i, j, ...}", "table[]"},
      {"{vertices, triangles} or mesh", "table|feder.Shape"},
      {"function(x, y, z) -> distance", "fun(x: number, y: number, z: number): number"},
      {"buffer of distances, x fastest", "feder.Buffer|number[]"},
      {"vector or number", "number[]|number"},
      {"list of {i, j, k}", "integer[][]"},
      {"list of {i, j, k} or buffer", "integer[][]|feder.Buffer"},
      {"list of {i, j, k, l} or buffer", "integer[][]|feder.Buffer"},
      {"number or false", "number|false"},
      {"number or function(t, world)", "number|fun(t: number, world: feder.World): number"},
      {"number or table", "number|table"},
      {"number, list or buffer", "number|number[]|feder.Buffer"},
      {"numbers, \"self\" or function(t, world)", "number|number[]|\"self\"|function"},
      {"object", "feder.AnyObject"},
      {"rotation", "number|table"},
      {"string or list of strings", "string|string[]"},
      {"table of numbers", "table<string, number>"},
      {"tables by name", "table<string, table>"},
      {"tables or lists by name", "table<string, table|any[]>"},
      {"true or table", "true|table"},
      {"tag, list of tags or object", "string|string[]|feder.AnyObject"},
      {"vector", "number[]"},
      {"{columns, rows}", "integer[]"},
      {"{lo, hi}", "number[]"},
      {"{min, max}", "number[][]"},
      {"{width, depth}", "number[]"},
  };
  return find(all, type);
}

const std::string* stub_type_of_argument(const std::string& title, const std::string& argument) {
  static const Types all = {
      {"body:set_sensor(on)", "boolean|\"all\""},
      {"body:set_type(name)", "\"dynamic\"|\"static\"|\"kinematic\""},
      {"cloth:attach(body)", "feder.AnyObject"},
      {"cloth:attach(i)", "integer|string"},
      {"feder.hull(points)", "number[][]|feder.Buffer"},
      {"feder.mesh(triangles)", "integer[][]"},
      {"feder.mesh(vertices)", "number[][]|feder.Buffer"},
      {"feder.plot(value)", "number"},
      {"feder.wait_until(fn)", "fun(): any"},
      {"fluid:set_velocities(fn)", "fun(x: number, y: number, z: number, i: integer): number, number, number"},
      {"net:attach(body)", "feder.AnyObject"},
      {"rope:attach(body)", "feder.AnyObject"},
      {"soft:attach(body)", "feder.AnyObject"},
      {"world:after(fn)", "fun()"},
      {"world:every(fn)", "fun()"},
      {"world:task(fn)", "fun()"},
  };
  return find(all, title + "(" + argument + ")");
}

const std::string* stub_table_form(const std::string& title) {
  static const Types all = {
      {"body:set_friction", "friction: { static?: number, dynamic?: number }"},
      {"body:set_rotation",
       "rotation: number[]|{ axis?: number[], angle?: number, euler?: number[], order?: string, "
       "fixed?: boolean }"},
      {"feder.box", "size: number[]"},
      {"joint:set_limits", "limits: number[]"},
      {"joint:set_motor", "motor: { speed?: number, max_force?: number, max_torque?: number }"},
  };
  return find(all, title);
}

bool is_plain_type(const std::string& type) {
  return type == "number" || type == "integer" || type == "boolean" || type == "string" || type == "table" ||
         type == "any" || type == "function";
}

std::string stub_class(const std::string& word, const char* behind) {
  std::string out = "feder.";
  bool capital = true;
  for (const char c : word) {
    const bool joint = c == '_' || c == '.';
    if (!joint) out += capital && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    capital = joint;
  }
  return out + behind;
}

std::string join_types(const std::string& a, const std::string& b) {
  std::string out = a;
  const std::vector<std::string> known = split_top(a, '|');
  for (const std::string& one : split_top(b, '|'))
    if (std::ranges::find(known, one) == known.end()) out += (out.empty() ? "" : "|") + one;
  return out;
}

std::vector<std::string> split_top(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  int depth = 0;
  bool quoted = false;
  for (const char c : text) {
    quoted = quoted != (c == '"');
    depth += c == '{' || c == '(' ? 1 : c == '}' || c == ')' ? -1 : 0;
    if (c == at && depth == 0 && !quoted)
      parts.emplace_back();
    else if (c != ' ' || !parts.back().empty())
      parts.back() += c;
  }
  for (std::string& part : parts) part.resize(part.find_last_not_of(' ') + 1);
  std::erase(parts, "");
  return parts;
}

}  // namespace feder::cli
