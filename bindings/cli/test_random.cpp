// Property tests (Claessen and Hughes 2000): random values of the parameters, and shrinking of what fails.
#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/rng.h"
#include "cli/command.h"
#include "cli/test_file.h"

namespace feder::cli {
namespace {

using lua::ParamInfo;

constexpr int kMaxShrinks = 64;  // runs that shrinking may take

double number_of(const std::string& text) {
  double x = NAN;
  std::from_chars(text.data(), text.data() + text.size(), x);
  return x;
}

std::string text_of(double x) { return fmt::format("{:.9g}", x); }
bool is_whole(double x) { return x == std::floor(x); }
bool is_flag(const ParamInfo& p) { return p.fallback == "true" || p.fallback == "false"; }
bool has_range(const ParamInfo& p) { return p.has_min && p.has_max; }

// Onto the grid of `step`, or of whole numbers where default and range are whole.
double on_grid(const ParamInfo& p, double x) {
  const bool whole = is_whole(number_of(p.fallback)) && is_whole(p.min) && is_whole(p.max) && p.max - p.min >= 2;
  const double step = p.has_step ? p.step : whole ? 1 : 0;
  if (step > 0) x = p.min + std::round((x - p.min) / step) * step;
  return std::min(p.max, std::max(p.min, x));
}

// The first two draws are the ends of all ranges.
std::string draw_value(const ParamInfo& p, int number, Rng& random) {
  const double unit = number == 1 ? 0 : number == 2 ? 1 : random.unit53();
  const auto pick = [&](std::size_t count) {
    return std::min(count - 1, static_cast<std::size_t>(unit * static_cast<double>(count)));
  };
  if (is_flag(p)) return pick(2) ? "true" : "false";
  if (!p.choices.empty()) return p.choices[pick(p.choices.size())];
  return text_of(on_grid(p, p.min + unit * (p.max - p.min)));
}

// Values nearer to the default, the nearest first.
std::vector<std::string> nearer_values(const ParamInfo& p, const std::string& value) {
  std::vector<std::string> out = {p.fallback};
  if (is_flag(p) || !p.choices.empty() || !has_range(p)) return out;
  const double from = number_of(p.fallback), to = number_of(value);
  for (const double share : {0.25, 0.5, 0.75, 0.9}) {
    const double x = on_grid(p, from + share * (to - from));
    if (std::abs(x - from) < std::abs(to - from) && text_of(x) != out.back()) out.push_back(text_of(x));
  }
  // the neighbour on a grid of whole numbers
  const double next = on_grid(p, to + (from > to ? 1 : -1));
  if (is_whole(to) && std::abs(next - from) < std::abs(to - from) && text_of(next) != out.back())
    out.push_back(text_of(next));
  return out;
}

// One pass over the parameters; true when a value has come nearer to its default.
bool shrink_once(const std::vector<ParamInfo>& params, const std::function<bool(const Draw&)>& fails, Draw& draw,
                 int& runs) {
  for (const ParamInfo& p : params) {
    const auto at = draw.find(p.name);
    if (at == draw.end() || at->second == p.fallback) continue;
    for (const std::string& value : nearer_values(p, at->second)) {
      Draw nearer = draw;
      if (value == p.fallback)
        nearer.erase(p.name);
      else
        nearer[p.name] = value;
      if (++runs > kMaxShrinks) return false;
      if (!fails(nearer)) continue;
      draw = nearer;
      return true;
    }
  }
  return false;
}

}  // namespace

std::vector<std::string> set_words(const Draw& draw) {
  std::vector<std::string> words;
  for (const auto& [name, value] : draw) words.push_back(name + "=" + value);
  return words;
}

Draw draw_of(const std::vector<std::string>& words) {
  Draw draw;
  for (const std::string& word : words) {
    const std::size_t equals = std::min(word.find('='), word.size());
    draw[word.substr(0, equals)] = word.substr(std::min(equals + 1, word.size()));
  }
  return draw;
}

bool takes(const std::vector<ParamInfo>& params, const Draw& draw) {
  return std::ranges::all_of(draw, [&](const auto& named) {
    const auto& [name, value] = named;
    const auto p = std::ranges::find(params, name, &ParamInfo::name);
    if (p == params.end()) return false;
    if (is_flag(*p)) return value == "true" || value == "false";
    if (!p->choices.empty()) return std::ranges::find(p->choices, value) != p->choices.end();
    const double x = number_of(value);
    return std::isfinite(x) && !(p->has_min && x < p->min) && !(p->has_max && x > p->max);
  });
}

CounterExample find_counter_example(const std::vector<ParamInfo>& params, int count, std::uint64_t seed,
                                    const std::function<bool(const Draw&)>& fails) {
  std::vector<ParamInfo> drawn;
  for (const ParamInfo& p : params)
    if (is_flag(p) || !p.choices.empty() || has_range(p)) drawn.push_back(p);
  CounterExample found;
  if (drawn.empty()) return found;
  Rng random(seed);
  for (int number = 1; number <= count; ++number) {
    Draw draw;
    for (const ParamInfo& p : drawn) draw[p.name] = draw_value(p, number, random);
    if (!fails(draw)) continue;
    found = {number, draw, draw};
    for (const ParamInfo& p : drawn)
      if (found.shrunk[p.name] == p.fallback) found.shrunk.erase(p.name);
    int runs = 0;
    while (shrink_once(drawn, fails, found.shrunk, runs)) {
    }
    return found;
  }
  return found;
}

}  // namespace feder::cli
