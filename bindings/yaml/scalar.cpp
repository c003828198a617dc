// Plain scalars by the core schema of YAML 1.2 (10.3.2), without locale: "yes" and "0777" are text, as people expect.
#include <charconv>
#include <limits>

#include "yaml/document.h"

namespace feder::yaml {
namespace {

bool is_null(const std::string& s) { return s.empty() || s == "~" || s == "null" || s == "Null" || s == "NULL"; }

bool read_flag(const std::string& s, Node& node) {
  const bool yes = s == "true" || s == "True" || s == "TRUE";
  if (!yes && s != "false" && s != "False" && s != "FALSE") return false;
  node.kind = NodeKind::boolean;
  node.flag = yes;
  return true;
}

bool read_integer(const std::string& s, Node& node) {
  const char* first = s.data();
  const char* const last = first + s.size();
  int base = 10;
  if (s.size() > 2 && s[0] == '0' && (s[1] == 'x' || s[1] == 'o')) {
    base = s[1] == 'x' ? 16 : 8;
    first += 2;
    if (*first == '-') return false;
  } else if (s.size() > 1 && s[0] == '+' && s[1] != '-') {
    ++first;
  }
  const auto [end, error] = std::from_chars(first, last, node.integer, base);
  if (error != std::errc{} || end != last) return false;
  node.kind = NodeKind::integer;
  return true;
}

bool read_number(const std::string& s, Node& node) {
  const std::size_t sign = !s.empty() && (s[0] == '-' || s[0] == '+') ? 1 : 0;
  const std::string body = s.substr(sign);
  const double infinity = std::numeric_limits<double>::infinity();
  if (body == ".inf" || body == ".Inf" || body == ".INF") {
    node.number = s[0] == '-' ? -infinity : infinity;
  } else if (s == ".nan" || s == ".NaN" || s == ".NAN") {
    node.number = std::numeric_limits<double>::quiet_NaN();
  } else {
    // from_chars also takes "inf" and "nan", which are text here
    const bool digits = !body.empty() && ((body[0] >= '0' && body[0] <= '9') || (body[0] == '.' && body.size() > 1));
    if (!digits) return false;
    const auto [end, error] = std::from_chars(body.data(), body.data() + body.size(), node.number);
    if (end != body.data() + body.size() || error == std::errc::invalid_argument) return false;
    if (error == std::errc::result_out_of_range) return false;
    if (s[0] == '-') node.number = -node.number;
  }
  node.kind = NodeKind::number;
  return true;
}

}  // namespace

bool resolve_scalar(const std::string& tag, const std::string& text, Node& node) {
  static const std::string core = "tag:yaml.org,2002:";
  node.text = text;
  if (tag == "?" || tag.empty()) {
    if (is_null(text)) {
      node.kind = NodeKind::null;
    } else if (!read_flag(text, node) && !read_integer(text, node) && !read_number(text, node)) {
      node.kind = NodeKind::text;
    }
    return true;
  }
  if (tag == "!" || tag == core + "str") {
    node.kind = NodeKind::text;
    return true;
  }
  if (tag == core + "null") return is_null(text);
  if (tag == core + "bool") return read_flag(text, node);
  if (tag == core + "int") return read_integer(text, node);
  return tag == core + "float" && read_number(text, node);
}

}  // namespace feder::yaml
