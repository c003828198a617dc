#include "report/json.h"

#include <algorithm>
#include <fstream>
#include <sstream>

namespace feder::report {

namespace {

std::string flat(const Json& value) { return value.dump(-1, ' ', false, Json::error_handler_t::replace); }

// Like dump(2), but a list of plain values stays on one line.
void write(const Json& value, const std::string& indent, std::string& out) {
  const bool nested =
      value.is_object() ||
      (value.is_array() && std::any_of(value.begin(), value.end(), [](const Json& v) { return v.is_structured(); }));
  if (!nested || value.empty()) {
    out += flat(value);
    return;
  }
  const std::string inner = indent + "  ";
  out += value.is_object() ? "{\n" : "[\n";
  bool first = true;
  for (auto it = value.begin(); it != value.end(); ++it) {
    out += (first ? "" : ",\n") + inner;
    if (value.is_object()) out += flat(Json(it.key())) + ": ";
    write(*it, inner, out);
    first = false;
  }
  out += "\n" + indent + (value.is_object() ? "}" : "]");
}

}  // namespace

std::string to_text(const Json& value) {
  std::string out;
  write(value, "", out);
  return out + "\n";
}

std::string read_bytes(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) throw std::runtime_error(file + ": cannot be read");
  return text.str();
}

Json read_json(const std::string& file) {
  const std::string text = read_bytes(file);
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& e) {
    throw std::runtime_error(file + ": no JSON: " + e.what());
  }
}

}  // namespace feder::report
