#include "base/params.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/archive.h"

namespace feder {
namespace {

const char* kind_name(const Params::Value& v) {
  static const char* const names[] = {"a boolean", "a number", "a string", "a list of numbers"};
  return names[v.index()];
}

std::string print(double x) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.10g", x);
  return buffer;
}

}  // namespace

const Params::Value* Params::find(std::string_view key) const {
  asked_.emplace(key);
  const auto it = values_.find(std::string(key));
  return it == values_.end() ? nullptr : &it->second;
}

double Params::number(std::string_view key, double fallback, double lo, double hi) const {
  const Value* v = find(key);
  if (!v) return fallback;
  const double* d = std::get_if<double>(v);
  if (!d) throw SceneError(std::string(key) + ": expected a number, got " + kind_name(*v));
  if (!std::isfinite(*d)) throw SceneError(std::string(key) + ": expected a finite number, got " + print(*d));
  if (*d < lo || *d > hi)
    throw SceneError(std::string(key) + ": expected a number from " + print(lo) + " to " + print(hi) + ", got " +
                     print(*d));
  return *d;
}

int Params::integer(std::string_view key, int fallback, int lo, int hi) const {
  const double d = number(key, fallback, lo, hi);
  if (d != std::floor(d)) throw SceneError(std::string(key) + ": expected a whole number, got " + print(d));
  return static_cast<int>(d);
}

bool Params::flag(std::string_view key, bool fallback) const {
  const Value* v = find(key);
  if (!v) return fallback;
  const bool* b = std::get_if<bool>(v);
  if (!b) throw SceneError(std::string(key) + ": expected true or false, got " + kind_name(*v));
  return *b;
}

std::string Params::text(std::string_view key, std::string fallback) const {
  const Value* v = find(key);
  if (!v) return fallback;
  const std::string* s = std::get_if<std::string>(v);
  if (!s) throw SceneError(std::string(key) + ": expected a string, got " + kind_name(*v));
  return *s;
}

Vec3 Params::vector(std::string_view key, const Vec3& fallback) const {
  const Value* v = find(key);
  if (!v) return fallback;
  const auto* list = std::get_if<std::vector<double>>(v);
  if (!list) throw SceneError(std::string(key) + ": expected three numbers, got " + kind_name(*v));
  if (list->size() != 3)
    throw SceneError(std::string(key) + ": expected three numbers, got " + std::to_string(list->size()));
  Vec3 out;
  for (std::size_t i = 0; i < 3; ++i) {
    const double d = (*list)[i];
    if (!std::isfinite(static_cast<Real>(d)))
      throw SceneError(std::string(key) + ": expected finite numbers, got " + print(d));
    out[static_cast<Eigen::Index>(i)] = static_cast<Real>(d);
  }
  return out;
}

void Params::save(Writer& w) const {
  w.add(static_cast<std::uint64_t>(values_.size()));
  for (const auto& [key, value] : values_) {
    w.text(key);
    w.add(static_cast<std::uint8_t>(value.index()));
    if (const bool* b = std::get_if<bool>(&value)) w.add(*b);
    if (const double* d = std::get_if<double>(&value)) w.add(*d);
    if (const auto* s = std::get_if<std::string>(&value)) w.text(*s);
    if (const auto* l = std::get_if<std::vector<double>>(&value)) w.list(*l);
  }
}

void Params::load(Reader& r) {
  values_.clear();
  std::uint64_t count = 0;
  r.get(count);
  for (std::uint64_t k = 0; k < count; ++k) {
    std::string key;
    std::uint8_t kind = 0;
    r.text(key), r.get(kind);
    Value& value = values_[key];
    if (kind == 0)
      r.get(value.emplace<bool>());
    else if (kind == 1)
      r.get(value.emplace<double>());
    else if (kind == 2)
      r.text(value.emplace<std::string>());
    else if (kind == 3)
      r.list(value.emplace<std::vector<double>>());
    else
      throw SceneError("snapshot: truncated or of another build");
  }
}

void Params::check_all_read(std::string_view owner) const {
  for (const auto& [key, value] : values_) {
    if (asked_.count(key)) continue;
    const std::string near = nearest_name(key, {asked_.begin(), asked_.end()});
    std::string known;
    for (const std::string& name : asked_) known += (known.empty() ? "; known: " : ", ") + name;
    throw SceneError(std::string(owner) + ": unknown option '" + key + "'" +
                     (near.empty() ? known : "; did you mean '" + near + "'?"));
  }
}

std::string nearest_name(std::string_view word, const std::vector<std::string>& known) {
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 2) + 1;
  std::vector<std::size_t> row;
  for (const std::string& candidate : known) {
    // Levenshtein distance, one row at a time
    row.resize(candidate.size() + 1);
    for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= word.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i;
      for (std::size_t j = 1; j <= candidate.size(); ++j) {
        const std::size_t above = row[j];
        row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (word[i - 1] == candidate[j - 1] ? 0 : 1)});
        diagonal = above;
      }
    }
    if (row.back() < best_distance) best_distance = row.back(), best = candidate;
  }
  return best;
}

}  // namespace feder
