#include "report/xml.h"

#include <fmt/format.h>

#include <cmath>

#include "report/json.h"

namespace feder::report {

std::string xml_escape(std::string_view text, bool keep_lines) {
  // the JSON library replaces what is no UTF-8
  const std::string valid =
      Json::parse(Json(std::string(text)).dump(-1, ' ', false, Json::error_handler_t::replace)).get<std::string>();
  std::string out;
  for (const char c : valid) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      case '\n': out += keep_lines ? "\n" : "&#10;"; break;
      case '\t': out += keep_lines ? "\t" : "&#9;"; break;
      default: out += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
    }
  }
  return out;
}

std::string px(double value) {
  if (!std::isfinite(value)) return "0";
  std::string text = fmt::format("{:.2f}", value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string number_text(double value, int digits) {
  if (!std::isfinite(value)) return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
  const std::string text = fmt::format("{:.{}g}", value, digits);
  const std::size_t e = text.find('e');
  if (e == std::string::npos) return text;
  // the exponent without '+' and leading zeros
  std::size_t at = e + 1;
  const bool negative = text[at] == '-';
  while (at < text.size() && (text[at] == '-' || text[at] == '+' || text[at] == '0')) ++at;
  return text.substr(0, e) + (negative ? "e-" : "e") + text.substr(at);
}

}  // namespace feder::report
