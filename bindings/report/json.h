// JSON text with keys in the order they were written. Non-finite numbers become null.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace feder::report {

using Json = nlohmann::ordered_json;

// Indented by two spaces, lists of plain values on one line, closed by a newline; bytes that are no UTF-8 are replaced.
std::string to_text(const Json& value);
// The bytes of a file. std::runtime_error "file: cannot be read".
std::string read_bytes(const std::string& file);
// The file as JSON. std::runtime_error "file: what is wrong".
Json read_json(const std::string& file);

}  // namespace feder::report
