// JSON Schema as far as the schemas of feder have it: type, const, enum, numbers' ranges, lists, objects, allOf, anyOf
// and references within. What is not listed here is no keyword.
#pragma once
#include <algorithm>
#include <nlohmann/json.hpp>
#include <regex>
#include <stdexcept>
#include <string>
#include <vector>

namespace feder::test {

class SchemaValidation {
  using json = nlohmann::json;

 public:
  explicit SchemaValidation(const json& root) : root_(root) {}

  void check(const json& value, const json& schema, const std::string& at) {
    if (schema.is_boolean()) return schema.get<bool>() ? void() : refuse(at, "is not allowed");
    for (const auto& [keyword, rule] : schema.items()) apply(keyword, rule, value, schema, at);
  }

  std::vector<std::string> errors;

 private:
  void refuse(const std::string& at, const std::string& what) { errors.push_back(at + ": " + what); }
  void expect(bool holds, const std::string& at, const std::string& what) {
    if (!holds) refuse(at, what);
  }

  static bool has_type(const json& value, const json& type) {
    if (type.is_array()) return std::ranges::any_of(type, [&](const json& t) { return has_type(value, t); });
    if (type == "integer") return value.is_number_integer();
    return value.type_name() == type.get<std::string>();
  }

  void apply(const std::string& keyword, const json& rule, const json& value, const json& schema,
             const std::string& at) {
    const double number = value.is_number() ? value.get<double>() : 0;
    if (keyword == "$ref") return check(value, look_up(rule), at);
    if (keyword == "type") return expect(has_type(value, rule), at, "is no " + rule.dump());
    if (keyword == "const") return expect(value == rule, at, "is not " + rule.dump());
    if (keyword == "enum") return expect(std::ranges::count(rule, value) > 0, at, "is none of " + rule.dump());
    if (keyword == "minimum") return expect(!value.is_number() || number >= rule, at, "is below " + rule.dump());
    if (keyword == "exclusiveMinimum")
      return expect(!value.is_number() || number > rule, at, "is not above " + rule.dump());
    if (keyword == "maximum") return expect(!value.is_number() || number <= rule, at, "is above " + rule.dump());
    if (keyword == "pattern")
      return expect(
          !value.is_string() || std::regex_search(value.get<std::string>(), std::regex(rule.get<std::string>())), at,
          "does not match " + rule.dump());
    if (keyword == "minItems") return expect(!value.is_array() || value.size() >= rule, at, "has too few values");
    if (keyword == "maxItems") return expect(!value.is_array() || value.size() <= rule, at, "has too many values");
    if (keyword == "items") return items(rule, value, schema, at);
    if (keyword == "properties") return properties(value, schema, at);
    if (keyword == "required") {
      for (const json& name : rule)
        expect(!value.is_object() || value.contains(name.get<std::string>()), at, "lacks " + name.dump());
    } else if (keyword == "allOf") {
      for (const json& one : rule) check(value, one, at);
    } else if (keyword == "anyOf") {
      any_of(rule, value, at);
    } else if (keyword == "additionalProperties") {
      if (!schema.contains("properties")) properties(value, schema, at);
    } else {
      static const char* const others[] = {
          "$schema", "title", "description", "default", "definitions", "patternProperties", "additionalItems"};
      if (std::ranges::none_of(others, [&](const char* o) { return keyword == o; }))
        throw std::runtime_error("unknown keyword " + keyword);
    }
  }

  const json& look_up(const json& reference) const {
    return root_.at(json::json_pointer(reference.get<std::string>().substr(1)));
  }

  void any_of(const json& rule, const json& value, const std::string& at) {
    std::vector<std::string> told;
    for (const json& one : rule) {
      SchemaValidation alone(root_);
      alone.check(value, one, at);
      if (alone.errors.empty()) return;
      for (std::string& error : alone.errors) told.push_back(std::move(error));
    }
    // what went deepest says most
    std::ranges::stable_sort(told, std::ranges::greater{},
                             [](const std::string& e) { return std::ranges::count(e, '/'); });
    refuse(told.front().substr(0, told.front().find(": ")), told.front().substr(told.front().find(": ") + 2));
  }

  void items(const json& rule, const json& value, const json& schema, const std::string& at) {
    if (!value.is_array()) return;
    for (std::size_t k = 0; k < value.size(); ++k) {
      const std::string place = at + "/" + std::to_string(k);
      const json more = schema.value("additionalItems", json(true));
      check(value[k], !rule.is_array() ? rule : k < rule.size() ? rule[k] : more, place);
    }
  }

  void properties(const json& value, const json& schema, const std::string& at) {
    if (!value.is_object()) return;
    const json known = schema.value("properties", json::object()),
               patterns = schema.value("patternProperties", json::object());
    for (const auto& [name, field] : value.items()) {
      const std::string place = at + "/" + name;
      bool matched = known.contains(name);
      if (matched) check(field, known[name], place);
      for (const auto& [pattern, one] : patterns.items()) {
        if (!std::regex_search(name, std::regex(pattern))) continue;
        matched = true;
        check(field, one, place);
      }
      if (!matched) check(field, schema.value("additionalProperties", json(true)), place);
    }
  }

  const json& root_;
};

// What is wrong with the value, "/bodies/0/density: ..."; std::runtime_error for a schema that is none. References are
// looked up in `root`.
inline std::vector<std::string> validate(const nlohmann::json& value, const nlohmann::json& schema,
                                         const nlohmann::json& root) {
  SchemaValidation v(root);
  v.check(value, schema, "");
  return std::move(v.errors);
}
inline std::vector<std::string> validate(const nlohmann::json& value, const nlohmann::json& schema) {
  return validate(value, schema, schema);
}

}  // namespace feder::test
