// Ranges, choices and values as text.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "feder/params.h"

namespace feder {

std::string Range::text() const {
  const bool below = hi<kHuge, above = lo> - kHuge;
  if (above && below && open) return "a number above " + print_number(lo) + " and at most " + print_number(hi);
  if (above && below) return "a number from " + print_number(lo) + " to " + print_number(hi);
  if (above) return open ? "a number above " + print_number(lo) : "a number of at least " + print_number(lo);
  if (below) return "a number of at most " + print_number(hi);
  return "a finite number";
}

std::string Range::whole() const {
  char buffer[80];
  std::snprintf(buffer, sizeof buffer, "a whole number from %.0f to %.0f", lo, hi);
  return buffer;
}

std::vector<std::string_view> split_choices(std::string_view choices) {
  std::vector<std::string_view> out;
  for (std::size_t from = 0; from < choices.size();) {
    const std::size_t end = std::min(choices.find(", ", from), choices.size());
    out.push_back(choices.substr(from, end - from));
    from = end + 2;
  }
  return out;
}

std::string print_number(double x) {
  char buffer[40];
  if (std::isnan(x)) return "nan";
  std::snprintf(buffer, sizeof buffer, "%.10g", x);
  return buffer;
}

std::string print_value(double x) { return std::isfinite(x) ? print_number(x) : ""; }

std::string print_value(float x) {
  char buffer[40];
  if (!std::isfinite(x)) return "";
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, x).ptr};
}

std::string print_value(const Vec3& x) {
  return "{" + print_value(x[0]) + ", " + print_value(x[1]) + ", " + print_value(x[2]) + "}";
}

}  // namespace feder
