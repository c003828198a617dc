// Options of a world: rows, materials, systems, and overrides of the command line.
#include "lua/world_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "feder/system.h"
#include "forces/area.h"
#include "lua/stack.h"

namespace feder::lua {
namespace {

struct Friction {
  Real fixed = 0, dynamic = 0;
};

constexpr Option<Friction> kFriction[] = {field<&Friction::fixed>("static", "", kNotNegative).unset(),
                                          field<&Friction::dynamic>("dynamic", "", kNotNegative).unset()};

template <class T>
void read_friction(Options& o, const OptionRow&, T& made) {
  if (friction_option(o, "friction", made.friction_static, made.friction_dynamic)) made.has_friction = true;
}

template <bool Material::*Has, Real Material::*Value>
void read_number(Options& o, const OptionRow& row, Material& m) {
  m.*Has = o.real(row.name, m.*Value, row.range);
}

void read_color(Options& o, const OptionRow&, Material& m) { m.has_color = o.color("color", m.color); }

constexpr Option<Material> kMaterial[] = {
    {{.name = "friction"}, "number or table", read_friction, nullptr, friction_rows},
    {{.name = "restitution", .range = kUnitRange},
     "number",
     read_number<&Material::has_restitution, &Material::restitution>},
    {{.name = "density", .unit = "kg/m3", .range = kPositive},
     "number",
     read_number<&Material::has_density, &Material::density>},
    {{.name = "rolling_friction", .unit = "m", .range = kNotNegative},
     "number",
     read_number<&Material::has_rolling, &Material::rolling_friction>},
    special("color", "color", read_color),
    later<Material>("title", "string"),
    later<Material>("description", "string"),
};

constexpr Option<NamedMaterialPair> kMaterialPair[] = {
    {{.name = "friction"}, "number or table", read_friction, nullptr, friction_rows},
    field<&NamedMaterialPair::restitution>("restitution", "", kUnitRange).unset(),
};

// Calls read(key, options of the value) for each entry of a table by name, in the order of the names.
template <class F>
void each_named(Options& o, const char* key, F&& read) {
  if (!o.push(key, LUA_TTABLE, "a table of tables by name")) return;
  lua_State* L = o.L();
  std::vector<std::string> names;
  for (lua_pushnil(L); lua_next(L, -2); lua_pop(L, 1)) {
    if (lua_type(L, -2) != LUA_TSTRING || lua_type(L, -1) != LUA_TTABLE) o.wrong(key, "a table of tables by name");
    names.emplace_back(lua_tostring(L, -2));
  }
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) {
    lua_getfield(L, -1, name.c_str());
    Options inner(L, -1, o.path(key) + "." + name);
    read(name, inner);
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
}

void read_materials(Options& o, const OptionRow&, WorldSettings& w) {
  each_named(o, "materials", [&](const std::string& name, Options& m) { m.read(kMaterial, w.materials[name]); });
}

void read_material_pairs(Options& o, const OptionRow&, WorldSettings& w) {
  if (!o.push("material_pairs", LUA_TTABLE, "a list of { \"a\", \"b\", friction =, restitution = }")) return;
  lua_State* L = o.L();
  const auto count = lua_rawlen(L, -1);
  if (count > 4096) o.raise("material_pairs", "expected at most 4096 pairs");
  each_entry(L, -1, [&](lua_Integer i) {
    const std::string what = o.path("material_pairs") + "[" + std::to_string(i) + "]";
    if (lua_type(L, -1) != LUA_TTABLE)
      fail(L, what + ": expected { \"a\", \"b\", friction =, restitution = }, got " + describe(L, -1));
    NamedMaterialPair pair;
    for (int k = 1; k <= 2; ++k) {
      lua_rawgeti(L, -1, k);
      const std::string name = check_text(L, -1, what);
      if (!w.materials.count(name))
        fail(L, what + ": unknown material '" + name + "'; known: " + join(material_names(w)));
      (k == 1 ? pair.a : pair.b) = name;
      lua_pop(L, 1);
    }
    Options p(L, -1, what);
    p.skip_entries(2);
    p.read(kMaterialPair, pair);
    w.material_pairs.push_back(pair);
  });
  lua_pop(L, 1);
}

// Into the options that systems read.
void read_world_text(Options& o, const OptionRow& row, WorldSettings& w) {
  std::string name;
  if (o.text(row.name, name)) w.desc.options.set(row.name, name);
}

void read_air_density(Options& o, const OptionRow& row, WorldSettings& w) {
  double air_density = 0;
  if (o.number(row.name, air_density, row.range)) w.desc.options.set(row.name, air_density);
}

constexpr Option<WorldDesc> kWorldDesc[] = {
    field<&WorldDesc::gravity>("gravity", "m/s2"),
    field<&WorldDesc::dt>("dt", "s", {0, 1, true}),
    field<&WorldDesc::substeps>("substeps", "", {1, 1000}),
    field<&WorldDesc::seed>("seed", "", {0, 4611686018427387904.0}),
    field<&WorldDesc::threads>("threads", "", {1, 64}),
    field<&WorldDesc::dimension>("dimension", "", {2, 3}),
    field<&WorldDesc::sleeping>("sleeping"),
    field<&WorldDesc::rebuild>("rebuild"),
};

constexpr Option<WorldSettings> kWorld[] = {
    special("broad_phase", "string", read_world_text),
    special("narrow_phase", "string", read_world_text),
    {kAirDensity, "number", read_air_density},
    {{.name = "materials"}, "tables by name", read_materials, nullptr, rows_of<kMaterial>},
    {{.name = "material_pairs"}, "list", read_material_pairs, nullptr, rows_of<kMaterialPair>},
};

// "0.25", "1/240".
bool parse_number(const std::string& text, double& out) {
  const auto one = [](std::string_view part, double& value) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc() && end == part.data() + part.size() && std::isfinite(value);
  };
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) return one(text, out);
  double over = 0, under = 0;
  if (!one(std::string_view(text).substr(0, slash), over) || !one(std::string_view(text).substr(slash + 1), under) ||
      under == 0)
    return false;
  out = over / under;
  return std::isfinite(out);
}

// A value from the command line by its form: number, boolean, list of numbers, else text.
Params::Value parse_value(const std::string& text) {
  double x = 0;
  if (parse_number(text, x)) return x;
  if (text == "true" || text == "false") return text == "true";
  if (text.find(',') != std::string::npos) {
    std::vector<double> list;
    std::string part;
    bool numbers = true;
    for (std::size_t i = 0; i <= text.size() && numbers; ++i) {
      if (i < text.size() && text[i] != ',') {
        if (text[i] != ' ') part += text[i];
        continue;
      }
      numbers = parse_number(part, x);
      list.push_back(x);
      part.clear();
    }
    if (numbers) return list;
  }
  return text;
}

void apply_override(Catalog systems, WorldSettings& w, const std::string& key, const std::string& text) {
  const std::string what = "--world " + key + "=" + text;
  const Params::Value value = parse_value(text);
  const auto number = [&] {
    if (const double* x = std::get_if<double>(&value)) return *x;
    throw SceneError(what + ": expected a number");
  };
  const auto whole = [&](double lo, double hi) {
    const double x = number();
    if (x != std::floor(x) || x < lo || x > hi)
      throw SceneError(what + ": expected a whole number from " + print_number(lo) + " to " + print_number(hi));
    return x;
  };
  // "rigid.solver" is an option of a system, the rest are the world's own
  const std::size_t dot = key.find('.');
  if (dot != std::string::npos) {
    const std::string system = key.substr(0, dot);
    if (std::ranges::none_of(systems, [&](const SystemDescriptor* d) { return system == d->name; }))
      throw SceneError(what + ": unknown system '" + system + "'");
    w.desc.systems[system].set(key.substr(dot + 1), value);
  } else if (key == "dt") {
    w.desc.dt = number();
  } else if (key == "air_density") {
    if (number() < 0) throw SceneError(what + ": expected a number, 0 or more");
    w.desc.options.set(key, value);
  } else if (key == "substeps") {
    w.desc.substeps = static_cast<int>(whole(1, 1000));
  } else if (key == "seed") {
    w.desc.seed = static_cast<std::uint64_t>(whole(0, 9007199254740992.0));
  } else if (key == "threads") {
    w.desc.threads = static_cast<int>(whole(1, 64));
  } else if (key == "dimension") {
    w.desc.dimension = static_cast<int>(whole(2, 3));
  } else if (key == "sleeping" || key == "rebuild") {
    const bool* b = std::get_if<bool>(&value);
    if (!b) throw SceneError(what + ": expected true or false");
    (key == "sleeping" ? w.desc.sleeping : w.desc.rebuild) = *b;
  } else if (key == "gravity") {
    const auto* list = std::get_if<std::vector<double>>(&value);
    if (!list || list->size() != 3) throw SceneError(what + ": expected three numbers x,y,z");
    for (int i = 0; i < 3; ++i) w.desc.gravity[i] = static_cast<Real>((*list)[static_cast<std::size_t>(i)]);
  } else if (key == "broad_phase" || key == "narrow_phase") {
    w.desc.options.set(key, value);
  } else {
    throw SceneError(what + ": unknown option '" + key + "'" +
                     did_you_mean(key, {"dt", "substeps", "seed", "threads", "dimension", "sleeping", "rebuild",
                                        "gravity", "air_density", "broad_phase", "narrow_phase", "rigid.solver"}));
  }
}

// Makes the systems that were given options, in a world that is thrown away.
void try_options(Catalog systems, const WorldSettings& w) {
  check(w.desc);
  WorldDesc desc = w.desc;
  desc.threads = 1;
  const bool collide = desc.options.has("broad_phase") || desc.options.has("narrow_phase");
  if (desc.systems.empty() && !collide) return;
  World probe(desc, systems);
  if (collide) probe.need_system(ContactService::kSystem);
  for (const auto& [name, options] : desc.systems) {
    try {
      probe.need_system(name);
    } catch (const SceneError& e) {
      const std::string what = e.what();
      throw SceneError("world." + (what.rfind(name, 0) == 0 ? what : name + ": " + what));
    }
  }
}

}  // namespace

std::vector<std::string> material_names(const WorldSettings& settings) {
  std::vector<std::string> names;
  for (const auto& m : settings.materials) names.push_back(m.first);
  return names;
}

void friction_table(Options& o, Real& fixed, Real& dynamic) {
  Friction friction{fixed, dynamic};
  o.read(kFriction, friction);
  const bool has_static = o.has("static"), has_dynamic = o.has("dynamic");
  if (!has_static && !has_dynamic) o.raise(nullptr, "expected a number or { static =, dynamic = }, got an empty table");
  fixed = has_static ? friction.fixed : friction.dynamic;
  dynamic = has_dynamic ? friction.dynamic : friction.fixed;
}

bool friction_option(Options& o, const char* key, Real& fixed, Real& dynamic) {
  if (!o.push_any(key)) return false;
  if (lua_type(o.L(), -1) == LUA_TTABLE) {
    Options inner(o.L(), -1, o.path(key));
    friction_table(inner, fixed, dynamic);
  } else {
    o.real(key, fixed, kNotNegative);
    dynamic = fixed;
  }
  lua_pop(o.L(), 1);
  return true;
}

std::vector<OptionInfo> friction_rows() { return describe_rows(kFriction); }
void misplace_world_options(Options& scene, Catalog systems, const std::string& is) {
  std::vector<std::string> keys;
  for (const OptionInfo& o : world_rows()) keys.emplace_back(o.row.name);
  scene.belongs(std::move(keys), "world" + is + "{ ... }");
  for (const SystemDescriptor* d : systems)
    if (d->joins.empty()) scene.belongs({d->name}, "world" + is + "{ " + d->name + is + "{ ... } }");
}
std::vector<OptionInfo> world_rows() { return join_rows(describe_rows(kWorldDesc), describe_rows(kWorld)); }

WorldSettings read_world_options(lua_State* L, int index, const std::string& owner, bool overrides) {
  State& s = state(L);
  WorldSettings w;
  Options o(L, index, owner, true);
  o.read_some(kWorldDesc, w.desc);
  o.read_some(kWorld, w);
  for (const SystemDescriptor* d : s.options.systems) {
    if (!d->joins.empty()) continue;
    o.know(d->name);
    if (o.has(d->name)) o.params(d->name, w.desc.systems[d->name]);
  }
  o.finish();
  if (overrides && s.options.has_seed) w.desc.seed = s.options.seed;
  if (overrides && !s.options.world.empty()) {
    // the script's own options hold: what fails now is the fault of an override
    try_options(s.options.systems, w);
    s.wrong_option = true;
    for (const auto& [key, text] : s.options.world) apply_override(s.options.systems, w, key, text);
  }
  try_options(s.options.systems, w);
  s.wrong_option = false;
  return w;
}

}  // namespace feder::lua
