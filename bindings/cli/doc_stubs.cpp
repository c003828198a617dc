// Stubs for the Lua language server (LuaCATS annotations, https://luals.github.io/wiki/annotations): a class for every
// owner and every table of options, an overload of `on` for every kind of event. Types of arguments and results follow
// from their names in signatures, those of options from their rows.
#include <algorithm>
#include <map>

#include "cli/doc_pages.h"

namespace feder::cli {
namespace {

// Names in signatures, of arguments and of results.
const std::map<std::string, std::string>& types_of_names() {
  static const std::map<std::string, std::string> types = [] {
    std::map<std::string, std::string> all;
    const auto add = [&](const char* type, std::initializer_list<const char*> names) {
      for (const char* name : names) all[name] = type;
    };
    add("integer", {"i", "j", "k", "n", "count", "vertices_count", "integer", "points_count", "springs", "edges"});
    add("boolean", {"on", "boolean", "tension_only"});
    add("string", {"kind", "name", "option", "snapshot", "file", "string", "what", "code", "hash"});
    add("function", {"fn"});
    add("any", {"default", "value"});
    add("fun(): feder.Event", {"iterator"});
    add("table", {"filter", "table"});
    add("feder.Object", {"a", "b"});
    add("number", {"x",           "y",       "z",         "w",        "dx",         "dy",
                   "dz",          "nx",      "ny",        "nz",       "px",         "py",
                   "pz",          "qx",      "qy",        "qz",       "qw",         "d",
                   "e",           "s",       "max",       "angular",  "linear",     "dynamic",
                   "static",      "radius",  "width",     "height",   "depth",      "degrees",
                   "radians",     "seconds", "lo",        "hi",       "speed",      "max_force",
                   "number",      "kinetic", "potential", "elastic",  "mean",       "largest",
                   "ixx",         "iyy",     "izz",       "ixy",      "ixz",        "iyz",
                   "stiffness",   "damping", "power",     "distance", "separation", "impulse",
                   "rest_length", "within",  "tolerance", "limit",    "bound",      "break_strain",
                   "during",      "wanted",  "from"});
    return all;
  }();
  return types;
}

// "number[][]" of lists of points where a script gives them.
const std::map<std::string, std::string>& types_of_rows() {
  static const std::map<std::string, std::string> types = {
      {"boolean or string", "boolean|string"},
      {"boolean or table", "boolean|table"},
      {"color", "string|number[]"},
      {"direction", "number[]"},
      {"function(world)", "fun(world: feder.World): ..."},
      {"function(world, reference)", "fun(world: feder.World, reference: any): number"},
      {"function(world, scene)", "fun(world: feder.World, scene: table)"},
      {"function(world, scene, expect)", "fun(world: feder.World, scene: table, expect: feder.Expect)"},
      {"function, formula or list of formulas", "function|string|string[]"},
      {"list", "any[]"},
      {"list of point numbers", "integer[]"},
      {"list of vectors or buffer", "number[][]|feder.Buffer"},
      {"list of vertex numbers or names", "(integer|string)[]"},
      {"list of tables", "table[]"},
      {"list of {i, j, ...}", "table[]"},
      {"list of {i, j, k}", "integer[][]"},
      {"list of {i, j, k} or buffer", "integer[][]|feder.Buffer"},
      {"number or false", "number|false"},
      {"number or function(t, world)", "number|fun(t: number, world: feder.World): number"},
      {"number or table", "number|table"},
      {"number, list or buffer", "number|number[]|feder.Buffer"},
      {"numbers, \"self\" or function(t, world)", "number|number[]|\"self\"|function"},
      {"object", "feder.Object"},
      {"rotation", "number|table"},
      {"string or list of strings", "string|string[]"},
      {"table of numbers", "table<string, number>"},
      {"tables by name", "table<string, table>"},
      {"true or table", "true|table"},
      {"tag, list of tags or object", "string|string[]|feder.Object"},
      {"vector", "number[]"},
      {"{columns, rows}", "integer[]"},
      {"{lo, hi}", "number[]"},
      {"{min, max}", "number[][]"},
      {"{width, depth}", "number[]"},
  };
  return types;
}

bool plain_type(const std::string& type) {
  return type == "number" || type == "integer" || type == "boolean" || type == "string" || type == "table" ||
         type == "any" || type == "function";
}

// "feder.Body" of "body", "feder.ContactBeginEvent" of "contact_begin" with "Event" behind.
std::string class_name(const std::string& word, const char* behind = "") {
  std::string out = "feder.";
  bool capital = true;
  for (const char c : word) {
    if (c != '_') out += capital && c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    capital = c == '_';
  }
  return out + behind;
}

// At commas or bars that stand in no braces or quotes, without blanks around.
std::vector<std::string> split_top(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  int depth = 0;
  bool quoted = false;
  for (const char c : text) {
    quoted = quoted != (c == '"');
    depth += c == '{' ? 1 : c == '}' ? -1 : 0;
    if (c == at && depth == 0 && !quoted)
      parts.emplace_back();
    else if (c != ' ' || !parts.back().empty())
      parts.back() += c;
  }
  for (std::string& part : parts) part.resize(part.find_last_not_of(' ') + 1);
  std::erase(parts, "");
  return parts;
}

bool is_object(const std::string& owner) {
  static const char* const others[] = {"feder",      "world", "object", "shape",   "buffer",
                                       "connection", "task",  "event",  "options", "command"};
  return std::ranges::find(others, owner) == std::end(others);
}

struct Stubs {
  const Pages& pages;
  std::string out;

  bool is_class(const std::string& word) const {
    return std::ranges::any_of(pages,
                               [&](const auto& p) { return p.owner == word && p.kind != lua::PageKind::command; });
  }

  // Of an argument or a result.
  std::string type_of(const std::string& name) const {
    if (name.find('|') != std::string::npos) {
      std::string all;
      for (std::size_t at = 0; at < name.size();) {
        const std::size_t end = std::min(name.find('|', at), name.size());
        std::string part = name.substr(at, end - at);
        std::erase(part, ' ');
        all += (all.empty() ? "" : "|") + type_of(part);
        at = end + 1;
      }
      return all;
    }
    if (const auto found = types_of_names().find(name); found != types_of_names().end()) return found->second;
    if (name == "scene" || name.starts_with("{{")) return name == "scene" ? "table" : "table[]";
    if (name.starts_with("{[name]")) return "table<string, number>";
    if (name.starts_with("{")) return type_of(name.substr(1, name.find(',') - 1)) + "[]";
    if (name == "points" || name == "vertices" || name == "triangles") return "number[][]";
    if (is_class(name)) return class_name(name);
    return "unknown";
  }

  std::string type_of(const lua::ReferenceRow& r, const lua::ReferencePage& p) const {
    // a table of options of its own
    std::string inner;
    for (const lua::ReferenceRow& within : p.rows)
      if (within.name.starts_with(r.name + ".") && within.name.find('.', r.name.size() + 1) == std::string::npos)
        inner += (inner.empty() ? "" : ", ") + within.name.substr(r.name.size() + 1) + "?: " + type_of(within, p);
    // names that it may be
    std::string names;
    if (r.type == "string" && !r.allowed.empty() && !r.allowed.starts_with("a "))
      for (const std::string_view word : split_choices(r.allowed))
        names += (names.empty() ? "\"" : "|\"") + std::string(word) + '"';
    if (p.title == "feder.scene" && r.name == "world") return "feder.WorldOptions";
    std::string type = !names.empty()       ? names
                       : plain_type(r.type) ? r.type
                       : is_class(r.type)   ? class_name(r.type)
                                            : "unknown";
    if (const auto known = types_of_rows().find(r.type); known != types_of_rows().end()) type = known->second;
    if (inner.empty() || type.starts_with("table<")) return type;
    const std::string table = "{ " + inner + " }";
    return type == "table"            ? table
           : type.ends_with("|table") ? type.substr(0, type.size() - 5) + table
                                      : type + "|" + table;
  }

  void options_class(const lua::ReferencePage& p) {
    out += "\n---@class " + class_name(p.name, "Options") + "\n";
    std::map<std::string, std::string> types;
    for (const lua::ReferenceRow& r : p.rows) {
      if (r.name.find('.') != std::string::npos) continue;
      std::string& type = types[r.name];
      const std::string own = type_of(r, p);
      type = type.empty() || type == own ? own : type + "|" + own;
    }
    for (const lua::ReferenceRow& r : p.rows) {
      const auto type = types.find(r.name);
      if (type == types.end()) continue;
      out += fmt::format("---@field {}? {} {}{}{}\n", r.name, type->second, r.unit.empty() ? "" : "(" + r.unit + ") ",
                         r.text, r.fallback.empty() ? "" : " Default " + r.fallback + ".");
      types.erase(type);
    }
    if (p.title != "feder.world") return;
    for (const lua::ReferencePage& system : pages)
      if (system.kind == lua::PageKind::options)
        out += "---@field " + system.name + "? " + class_name(system.name, "Options") + " " + system.text + "\n";
  }

  void event_class(const lua::ReferencePage& p) {
    out += "\n---@class " + class_name(p.name, "Event") + " : feder.Event\n";
    for (const lua::ReferenceRow& r : p.rows)
      if (r.name.starts_with("e.")) out += "---@field " + r.name.substr(2) + " " + type_of(r, p) + " " + r.text + "\n";
  }

  // Of one part of a signature: "x", "fn | buffer", "within = 10", "{min, max}", "\"<\" | \"<=\"".
  std::pair<std::string, std::string> name_and_type(const std::string& part) const {
    std::string name, types;
    for (const std::string& one : split_top(part, '|')) {
      const std::string word = one.substr(0, one.find(" ="));
      const std::string inner = one[0] == '{' ? one.substr(1, one.find('}') - 1) : "";
      if (name.empty()) name = one[0] == '"' ? "word" : inner.empty() ? word : split_top(inner, ',').front();
      std::string type = one[0] == '"' ? one : type_of(word);
      if (inner == "min, max") type = "number[][]", name = name == "min" ? "corners" : name;
      if (inner == "x, y, z") type = "number[]";
      if (inner == "from, to" && name == "from") name = "window";
      if (inner == "least, most") type = "integer[]";
      if (inner == "objects") type = "feder.Object[]";
      types += (types.empty() ? "" : "|") + type;
    }
    return {name, types};
  }

  void function(const lua::ReferencePage& p) {
    const std::string& s = p.signature;
    const std::size_t open = s.find_first_of("({"), arrow = s.find(" -> ");
    const bool table = open != std::string::npos && s[open] == '{';
    std::string arguments;
    const auto add = [&](const std::string& name, bool optional, const std::string& type) {
      out += "---@param " + name + (optional ? "? " : " ") + type + "\n";
      arguments += (arguments.empty() ? "" : ", ") + name;
    };
    out += "\n---" + p.text + "\n";
    // arguments: optional ones in brackets; one table of options
    const std::string list =
        table || open == std::string::npos ? "" : s.substr(open + 1, s.rfind(')', arrow) - open - 1);
    bool optional = false, options = table;
    for (std::string part : split_top(list, ',')) {
      optional = optional || part.find('[') != std::string::npos;
      std::erase_if(part, [](char c) { return c == '[' || c == ']'; });
      if (part[0] == '{' && part.find('=') != std::string::npos) {
        options = true;
        continue;
      }
      const auto [name, type] = name_and_type(part);
      add(name, optional, type);
    }
    if (options) add("options", optional, p.rows.empty() ? "table" : class_name(p.name, "Options"));
    results(arrow == std::string::npos ? "" : s.substr(arrow + 4), p.owner);
    if (p.name == "on") handlers(p.owner);
    const bool dot = s.starts_with(p.owner + ".");
    out += "function " + p.owner + (dot ? "." : ":") + p.name + "(" + arguments + ") end\n";
  }

  void results(const std::string& list, const std::string& owner) {
    for (std::size_t at = 0; at < list.size();) {
      const bool whole = list[at] == '{';
      const std::size_t end = whole ? list.size() : std::min(list.find(", ", at), list.size());
      const std::string name = list.substr(at, end - at);
      out += "---@return " + (name == "self" ? class_name(owner) : type_of(name)) +
             (whole || name == "self" || is_class(name) || plain_type(name) ? "" : " " + name) + "\n";
      at = end + 2;
    }
  }

  // The event that a handler gets, by the kind.
  void handlers(const std::string& owner) {
    for (const lua::ReferencePage& p : pages)
      if (p.kind == lua::PageKind::event)
        for (const char* filter : {"", "filter: table, "})
          out += fmt::format("---@overload fun(self: {}, kind: \"{}\", {}fn: fun(e: {})): feder.Connection\n",
                             class_name(owner), p.name, filter, class_name(p.name, "Event"));
  }
};

}  // namespace

std::string pages_luacats(const Pages& pages) {
  Stubs stubs{pages, "---@meta feder\n-- Written by `feder doc --luacats` of feder " FEDER_VERSION ".\n"};
  for (const lua::ReferencePage& p : pages) {
    if (p.kind == lua::PageKind::event) stubs.event_class(p);
    if (p.kind == lua::PageKind::options ||
        ((p.kind == lua::PageKind::function || p.kind == lua::PageKind::method) && !p.rows.empty()))
      stubs.options_class(p);
  }
  for (const Owner& owner : owners(pages)) {
    if (owner.name == "options" || owner.name == "command") continue;
    stubs.out += "\n---@class " + (owner.name == "feder" ? "feder" : class_name(owner.name)) +
                 (is_object(owner.name) ? " : feder.Object" : "") + "\n";
    if (owner.name == "buffer") stubs.out += "---@field [integer] number\n---@operator len: integer\n";
    if (owner.name == "expect") stubs.out += "---@overload fun(condition: any, message?: string): boolean\n";
    stubs.out += "local " + owner.name + " = {}\n";
    for (const lua::ReferencePage& p : pages)
      if (p.owner == owner.name && p.kind != lua::PageKind::event) stubs.function(p);
  }
  return stubs.out + "\n---@type number\nfeder.pi = 3.141592653589793\n\nreturn feder\n";
}

}  // namespace feder::cli
