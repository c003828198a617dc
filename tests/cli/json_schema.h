// JSON Schema, draft 7, as far as the schema of scenes in YAML has it. What is not listed here is no keyword.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace feder::test {

// What is wrong with the value, "/bodies/0/density: ..."; std::runtime_error for a schema that is none.
std::vector<std::string> validate(const nlohmann::json& value, const nlohmann::json& schema);
// The same with references looked up in `root`.
std::vector<std::string> validate(const nlohmann::json& value, const nlohmann::json& schema,
                                  const nlohmann::json& root);

}  // namespace feder::test
