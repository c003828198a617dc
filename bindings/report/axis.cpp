#include "report/axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/xml.h"

namespace feder::report {
namespace {

// 10^k as exactly as decimal input gives it.
double decade(int k) { return std::stod(fmt::format("1e{}", k)); }

std::string seconds_label(double s) {
  struct Unit {
    double size;
    const char* name;
  };
  static const Unit units[] = {{1, "s"}, {1e-3, "ms"}, {1e-6, "µs"}, {1e-9, "ns"}};
  for (const Unit& u : units)
    if (s >= u.size * 0.999) return number_text(s / u.size, 4) + " " + u.name;
  return number_text(s, 3) + " s";
}

std::string label_of(TickStyle style, double mantissa, int exponent) {
  const double value = mantissa * decade(exponent);
  if (style == TickStyle::seconds) return seconds_label(value);
  if (style == TickStyle::plain && exponent >= -3 && exponent <= 4) return number_text(value, 6);
  const std::string power = fmt::format("10^{{{}}}", exponent);
  return mantissa == 1 ? power : fmt::format("{:g}·", mantissa) + power;
}

std::vector<Tick> log_ticks(const Axis& a, int max_labels) {
  std::vector<Tick> out;
  const double lo = std::log10(a.lo), hi = std::log10(a.hi);
  const int first = static_cast<int>(std::floor(lo + 1e-9)), last = static_cast<int>(std::ceil(hi - 1e-9));
  const int decades = last - first;
  int every = 1;
  while (decades / every + 1 > max_labels) every = every == 1 ? 2 : every == 2 ? 3 : every + 3;
  const bool with_2_5 = decades <= 2 && 3 * decades + 1 <= max_labels;
  for (int k = first; k <= last; ++k) {
    for (int m = 1; m <= 9; ++m) {
      const double value = m * decade(k);
      if (value < a.lo * (1 - 1e-9) || value > a.hi * (1 + 1e-9)) continue;
      const bool labelled = (m == 1 && k % every == 0) || (with_2_5 && (m == 2 || m == 5));
      if (m > 1 && !labelled && 2 * decades > max_labels) continue;  // too dense for a grid
      out.push_back({value, labelled ? label_of(a.style, m, k) : ""});
    }
  }
  return out;
}

std::vector<Tick> linear_ticks(const Axis& a, int max_labels) {
  const double span = a.hi - a.lo;
  if (!(span > 0)) return {{a.lo, number_text(a.lo, 6)}};
  // the finest step of 1, 2, 5 times a power of ten that gives few enough labels
  int exponent = static_cast<int>(std::floor(std::log10(span / max_labels))) - 1;
  double mantissa = 1;
  while (span / (mantissa * decade(exponent)) > max_labels - 1 + 1e-9) {
    mantissa = mantissa == 1 ? 2 : mantissa == 2 ? 5 : 1;
    exponent += mantissa == 1;
  }
  const double step = mantissa * decade(exponent);
  const int minor_count = mantissa == 2 ? 4 : 5;
  std::vector<Tick> out;
  const double first = std::ceil(a.lo / step - 1e-9) - 1;
  for (double n = first; n * step <= a.hi + 1e-9 * span; n += 1) {
    for (int k = 0; k < minor_count; ++k) {
      const double value = (n + static_cast<double>(k) / minor_count) * step;
      if (value < a.lo - 1e-9 * span || value > a.hi + 1e-9 * span) continue;
      const double shown = std::fabs(value) < 1e-9 * span ? 0 : value;
      const int digits =
          static_cast<int>(std::clamp(std::log10(std::max(std::fabs(shown), step) / step) + 2.5, 3.0, 12.0));
      out.push_back({shown, k == 0 ? number_text(shown, digits) : ""});
    }
  }
  return out;
}

Axis fit_log(Axis a, double lo, double hi) {
  // whole decades when there are several, otherwise ends of 1, 2, 5
  const auto down = [](double v, bool whole) {
    const int k = static_cast<int>(std::floor(std::log10(v) + 1e-9));
    if (whole) return decade(k);
    for (const double m : {5.0, 2.0})
      if (m * decade(k) <= v * (1 + 1e-9)) return m * decade(k);
    return decade(k);
  };
  const auto up = [](double v, bool whole) {
    const int k = static_cast<int>(std::ceil(std::log10(v) - 1e-9));
    if (whole) return decade(k);
    for (const double m : {2.0, 5.0})
      if (m * decade(k - 1) >= v * (1 - 1e-9)) return m * decade(k - 1);
    return decade(k);
  };
  const bool whole = std::log10(hi / lo) > 3;
  a.lo = down(lo, whole);
  a.hi = up(hi, whole);
  if (a.hi < a.lo * 9.99) {
    a.lo = down(lo, true);
    a.hi = std::max(up(hi, true), a.lo * 10);
  }
  return a;
}

}  // namespace

double Axis::at(double value) const {
  if (!std::isfinite(value)) return value > 0 ? 1 : 0;
  if (!log) return hi > lo ? (value - lo) / (hi - lo) : 0;
  return value > 0 && hi > lo && lo > 0 ? std::log10(value / lo) / std::log10(hi / lo) : 0;
}

std::vector<Tick> Axis::ticks(int max_labels) const {
  if (!fixed.empty()) return fixed;
  return log ? log_ticks(*this, max_labels) : linear_ticks(*this, max_labels);
}

Axis fit_axis(const std::string& label, bool log, const std::vector<double>& values, TickStyle style) {
  Axis a{label, log, log ? 1.0 : 0.0, log ? 10.0 : 1.0, style, {}};
  double lo = 0, hi = 0;
  bool any = false;
  for (const double v : values) {
    if (!std::isfinite(v) || (log && v <= 0)) continue;
    lo = any ? std::min(lo, v) : v;
    hi = any ? std::max(hi, v) : v;
    any = true;
  }
  if (!any) return a;
  if (log) return fit_log(a, lo, hi);
  if (hi == lo) {
    const double half = lo == 0 ? 1 : std::fabs(lo) * 0.1;
    lo -= half, hi += half;
  }
  // ends on ticks
  a.lo = lo, a.hi = hi;
  std::vector<double> labelled;
  for (const Tick& t : linear_ticks(a, 6))
    if (!t.label.empty()) labelled.push_back(t.value);
  if (labelled.size() < 2) return a;
  const double step = labelled[1] - labelled[0];
  a.lo = std::floor(lo / step + 1e-9) * step;
  a.hi = std::ceil(hi / step - 1e-9) * step;
  return a;
}

}  // namespace feder::report
