// JSON Schema of scenes in YAML (draft 7, which the YAML language server reads): editors complete and check by it. The
// options of makers and worlds follow their rows, shapes the arguments of their kinds. "$name" may stand for every
// number, word or flag. Of options that several variants read differently, either form is taken.
#include <algorithm>

#include "cli/doc_pages.h"
#include "feder/shape.h"

namespace feder::cli {
namespace {

using lua::ReferencePage;
using lua::ReferenceRow;
using report::Json;

Json of_type(const char* type) { return {{"type", type}}; }
Json defined(const char* name) { return {{"$ref", std::string("#/definitions/") + name}}; }
Json list_of(const Json& item, std::size_t least = 0, std::size_t most = 0) {
  Json list = {{"type", "array"}, {"items", item}};
  if (least > 0) list["minItems"] = least;
  if (most > 0) list["maxItems"] = most;
  return list;
}
Json either(std::initializer_list<Json> all) { return {{"anyOf", Json(std::vector<Json>(all))}}; }
Json object(Json properties) {
  return {{"type", "object"}, {"properties", std::move(properties)}, {"additionalProperties", false}};
}
Json by_name(const Json& value) { return {{"type", "object"}, {"additionalProperties", value}}; }

// A number, word or flag: or a parameter.
Json or_parameter(const Json& scalar) { return either({scalar, defined("parameter")}); }
Json number() { return defined("number"); }
Json whole() { return defined("integer"); }

Json ranged(const ReferenceRow& row) {
  Json out = of_type(row.type.c_str());
  const Range& r = row.range;
  if (r.lo <= kAny.lo && r.hi >= kAny.hi) return defined(row.type.c_str());
  if (r.lo > kAny.lo) out[r.open ? "exclusiveMinimum" : "minimum"] = r.lo;
  if (r.hi < kAny.hi) out["maximum"] = r.hi;
  return or_parameter(out);
}

Json words(const ReferenceRow& row) {
  if (row.allowed.empty() || row.allowed.starts_with("a ")) return of_type("string");
  Json names = Json::array();
  for (std::string_view word : split_choices(row.allowed)) names.push_back(word);
  return or_parameter({{"enum", names}});
}

// Types of rows that are the same wherever they stand.
const std::map<std::string, Json>& plain_types() {
  static const Json name = of_type("string"), flag = of_type("boolean"), vector = defined("vector");
  static const std::map<std::string, Json> all = {
      {"boolean", or_parameter(flag)},
      {"boolean or string", either({flag, {{"const", "all"}}, defined("parameter")})},
      {"body", name},
      {"color", defined("color")},
      {"direction", vector},
      {"function, formula or list of formulas", either({name, list_of(name, 3, 3)})},
      {"list", list_of(Json::object())},
      {"list of point numbers", list_of(whole())},
      {"list of vectors or buffer", list_of(vector)},
      {"list of vertex numbers or names", list_of(either({of_type("integer"), name}))},
      {"list of {i, j, k}", list_of(list_of(whole(), 3, 4))},
      {"list of {i, j, k} or buffer", list_of(list_of(whole(), 3, 3))},
      {"list of {i, j, k, l} or buffer", list_of(list_of(whole(), 4, 4))},
      {"number or false", either({number(), {{"const", false}}})},
      {"number, list or buffer", either({number(), list_of(number())})},
      {"number, string or boolean", {{"type", {"number", "string", "boolean"}}}},
      {"rotation", defined("rotation")},
      {"shape", defined("shape")},
      {"table", of_type("object")},
      {"table of numbers", by_name(number())},
      {"tag, list of tags or object", either({name, list_of(name)})},
      {"vector", vector},
      {"{columns, rows}", list_of(whole(), 2, 2)},
      {"{lo, hi}", list_of(number(), 2, 2)},
      {"{min, max}", list_of(vector, 2, 2)},
      {"{width, depth}", list_of(number(), 2, 2)},
  };
  return all;
}

// By the type of a row; null for what YAML has no value for: functions, handles. `inner`: of a table with rows.
Json by_type(const ReferenceRow& row, const Json& inner) {
  const std::string& type = row.type;
  if (type == "number" || type == "integer") return ranged(row);
  if (type == "string") return words(row);
  if (type == "string or list of strings") return either({words(row), list_of(words(row))});
  if (!inner.is_null()) {
    if (type == "table") return inner;
    if (type == "boolean or table") return either({of_type("boolean"), inner});
    if (type == "true or table") return either({{{"const", true}}, inner});
    if (type == "number or table") return either({number(), inner});
    if (type == "table or list of tables") return either({inner, list_of(inner)});
    if (type == "tables by name") return by_name(inner);
    if (type == "list of {i, j, ...}") return list_of(either({list_of(whole(), 2, 2), inner}));
    if (type == "list") {  // of tables with values by position, which have numbers for keys here
      Json tuple = inner;
      tuple["patternProperties"] = {{"^[0-9]+$", Json::object()}};
      return list_of(tuple);
    }
  }
  const auto found = plain_types().find(type);
  return found == plain_types().end() ? Json() : found->second;
}

// "{0, -9.81, 0}" as a script would write it is [0, -9.81, 0]; null for what is no value.
Json default_value(std::string text) {
  std::ranges::replace(text, '{', '['), std::ranges::replace(text, '}', ']');
  const Json value = Json::parse(text, nullptr, false);
  return value.is_discarded() ? Json() : value;
}

Json properties(const std::vector<ReferenceRow>& rows, const std::string& prefix);

Json property(const std::vector<ReferenceRow>& rows, const ReferenceRow& row) {
  const std::string below = row.name + ".";
  const bool table = std::ranges::any_of(rows, [&](const ReferenceRow& r) { return r.name.starts_with(below); });
  Json out = by_type(row, table ? object(properties(rows, below)) : Json());
  if (out.is_null()) return out;
  if (out.contains("$ref")) out = {{"allOf", {out}}};  // whose sisters nobody reads
  out["description"] = row.text + (row.unit.empty() ? "" : " Unit: " + row.unit + ".") +
                       (row.of.empty() ? "" : " Of " + row.of + ".") +
                       (row.allowed.empty() ? "" : " Takes " + row.allowed + ".");
  if (Json value = default_value(row.fallback); !value.is_null()) out["default"] = std::move(value);
  return out;
}

Json properties(const std::vector<ReferenceRow>& rows, const std::string& prefix) {
  Json all = Json::object();
  for (const ReferenceRow& row : rows) {
    if (!row.name.starts_with(prefix) || row.name.find('.', prefix.size()) != std::string::npos) continue;
    Json one = property(rows, row);
    if (one.is_null()) continue;
    Json& place = all[row.name.substr(prefix.size())];
    if (place.is_null()) {
      place = std::move(one);
    } else if (place != one) {  // of another variant
      const std::string text = place["description"].get<std::string>() + " " + one["description"].get<std::string>();
      place = either({place, one});
      place["description"] = text;
    }
  }
  return all;
}

const ReferencePage* find_page(const Pages& pages, const std::string& title) {
  const auto found = std::ranges::find(pages, title, &ReferencePage::title);
  return found == pages.end() ? nullptr : &*found;
}

// Shapes: a word, { box: [1, 1, 1] } or { type: box, size: [1, 1, 1] }.
Json argument_type(const ShapeArgument& a) {
  switch (a.type) {
    case ShapeArgumentType::size: return or_parameter({{"type", "number"}, {"exclusiveMinimum", 0}});
    case ShapeArgumentType::number: return number();
    case ShapeArgumentType::direction: return defined("vector");
    case ShapeArgumentType::points: return list_of(defined("vector"), 3);
    case ShapeArgumentType::points_2d: return list_of(list_of(number(), 2, 3), 3);
    case ShapeArgumentType::triangles: return list_of(list_of(whole(), 3, 4), 1);
    case ShapeArgumentType::parts: return list_of(defined("part"), 1);
    case ShapeArgumentType::surfaces: return list_of(defined("surface"));
  }
  return {};
}
bool needed(const ShapeArgument& a) { return std::isnan(a.fallback); }

// The value behind the name: the arguments by their order, or the one that there is.
Json arguments_in_order(const ShapeKind& kind) {
  const Json first = argument_type(kind.arguments[0]);
  const auto least = static_cast<std::size_t>(std::ranges::count_if(kind.arguments, needed));
  if (kind.arguments[0].type >= ShapeArgumentType::points && least == 1) return first;
  Json items = Json::array();
  for (const ShapeArgument& a : kind.arguments)
    for (int k = 0; k < (a.type == ShapeArgumentType::direction ? 3 : 1); ++k)
      items.push_back(a.type == ShapeArgumentType::direction  ? number()
                      : a.type == ShapeArgumentType::surfaces ? object({{a.name, argument_type(a)}})
                                                              : argument_type(a));
  Json list = {{"type", "array"}, {"items", items}, {"additionalItems", false}, {"minItems", least}};
  const bool one = least <= 1 && first.value("type", "") != "array";
  return one ? either({first, list}) : list;
}
Json arguments_by_name(const ShapeKind& kind) {
  Json all = {{"type", {{"const", kind.name}}}}, required = {"type"};
  for (const ShapeArgument& a : kind.arguments) {
    all[a.name] = argument_type(a);
    if (needed(a) && a.type != ShapeArgumentType::size) required.push_back(a.name);
  }
  all["size"] = list_of(argument_type({"", ShapeArgumentType::size}), 1, kind.arguments.size());
  Json out = object(all);
  out["required"] = required;
  out["description"] = std::string(kind.summary) + ".";
  return out;
}
Json shape_schema(const Pages& pages) {
  Json all = Json::array(), names = Json::array();
  for (const ShapeKind& kind : shape_kinds()) {
    if (kind.arguments.empty()) {  // a table of options
      const ReferencePage* page = find_page(pages, (std::string("feder.") + kind.name).c_str());
      const Json options = page ? properties(page->rows, "") : Json::object();
      Json short_form = object({{kind.name, object(options)}}), typed = options;
      short_form["required"] = {kind.name};
      typed["type"] = {{"const", kind.name}};
      all.push_back(std::move(short_form)), all.push_back(object(typed));
      continue;
    }
    if (std::ranges::none_of(kind.arguments, needed)) names.push_back(kind.name);
    Json short_form = object({{kind.name, arguments_in_order(kind)}});
    short_form["required"] = {kind.name};
    short_form["description"] = std::string(kind.name) + kind.usage + ": " + kind.summary + ".";
    all.push_back(std::move(short_form)), all.push_back(arguments_by_name(kind));
  }
  all.push_back({{"enum", names}});
  return {{"anyOf", all}};
}

Json definitions(const Pages& pages) {
  const auto rows = [&](const char* maker, const char* prefix) {
    const ReferencePage* page = find_page(pages, maker);
    return page ? properties(page->rows, prefix) : Json::object();
  };
  const Json axis = {{"axis", defined("vector")}, {"angle", number()}};
  const Json euler = {{"euler", list_of(number(), 3, 3)}, {"order", of_type("string")}, {"fixed", of_type("boolean")}};
  return {{"parameter", {{"type", "string"}, {"pattern", "^\\$[A-Za-z0-9_]+$"}}},
          {"number", or_parameter(of_type("number"))},
          {"integer", or_parameter(of_type("integer"))},
          {"vector", list_of(number(), 2, 3)},
          {"color", either({of_type("string"), list_of({{"type", "number"}, {"minimum", 0}, {"maximum", 1}}, 3, 3)})},
          {"rotation", either({number(), list_of(number(), 4, 4), object(axis), object(euler)})},
          {"part", object(rows("feder.compound", ""))},
          {"surface", object(rows("feder.mesh", "surfaces."))},
          {"shape", shape_schema(pages)}};
}

Json world_schema(const Pages& pages) {
  Json all = properties(find_page(pages, "feder.world")->rows, "");
  for (const ReferencePage& system : pages) {
    if (system.kind != lua::PageKind::options) continue;
    all[system.name] = object(properties(system.rows, ""));
    all[system.name]["description"] = system.text + ".";
  }
  return object(all);
}

Json entries(const Pages& pages, const ReferencePage& list) {
  const ReferencePage* const maker = find_page(pages, list.maker);
  if (!maker) return list_of(of_type("object"));
  Json all = properties(maker->rows, "");
  all.update(properties(list.rows, ""));
  return list_of(object(all));
}

Json params_schema(const ReferencePage& page) {
  Json options = object(properties(page.rows, ""));
  options["required"] = {"value"};
  return by_name(either({{{"type", {"number", "string", "boolean"}}}, options}));
}

}  // namespace

report::Json yaml_schema(const Pages& pages) {
  Json all = properties(find_page(pages, "feder.scene")->rows, "");
  all.erase("study");  // of functions
  all["world"] = world_schema(pages);
  for (const ReferencePage& page : pages) {
    if (page.kind != lua::PageKind::yaml) continue;
    Json& place = all[page.name] = page.name == "params"  ? params_schema(page)
                                   : page.name == "check" ? of_type("string")
                                                          : entries(pages, page);
    place["description"] = page.text + ".";
  }
  Json schema = {{"$schema", "http://json-schema.org/draft-07/schema#"},
                 {"title", "feder scene"},
                 {"description", "A scene in YAML, of feder " FEDER_VERSION "."}};
  schema.update(object(all));
  schema["definitions"] = definitions(pages);
  return schema;
}

}  // namespace feder::cli
