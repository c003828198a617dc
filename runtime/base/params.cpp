// Options by name: reading, and the error that names the nearest known key.
#include "feder/params.h"

#include <algorithm>
#include <cmath>

#include "feder/snapshot.h"

namespace feder {
namespace {

const char* kind_name(const Params::Value& v) {
  static const char* const names[] = {"a boolean", "a number", "a string", "a list of numbers"};
  return names[v.index()];
}

[[noreturn]] void wrong(const OptionRow& row, const std::string& expected, const std::string& got) {
  throw SceneError(std::string(row.name) + ": expected " + expected + ", got " + got);
}

}  // namespace

const Params::Value* Params::find(const OptionRow& row, const char* type, std::string fallback,
                                  std::string choices) const {
  asked_.insert_or_assign(row.name, OptionInfo{row, type, std::move(fallback),
                                               choices.empty() ? std::string(row.choices) : std::move(choices)});
  const auto it = values_.find(row.name);
  return it == values_.end() ? nullptr : &it->second;
}

double Params::number(const OptionRow& row, double fallback) const {
  const Value* v = find(row, "number", print_value(fallback));
  if (!v) return fallback;
  const double* d = std::get_if<double>(v);
  if (!d) wrong(row, "a number", kind_name(*v));
  if (!std::isfinite(*d)) wrong(row, "a finite number", print_number(*d));
  if (!row.range.holds(*d)) wrong(row, row.range.text(), print_number(*d));
  return *d;
}

int Params::integer(const OptionRow& row, int fallback) const {
  const Value* v = find(row, "integer", print_value(fallback));
  if (!v) return fallback;
  const double* d = std::get_if<double>(v);
  if (!d || *d != std::floor(*d) || !row.range.holds(*d))
    wrong(row, row.range.whole(), d ? print_number(*d) : kind_name(*v));
  return static_cast<int>(*d);
}

bool Params::flag(const OptionRow& row, bool fallback) const {
  const Value* v = find(row, "boolean", print_value(fallback));
  if (!v) return fallback;
  const bool* b = std::get_if<bool>(v);
  if (!b) wrong(row, "true or false", kind_name(*v));
  return *b;
}

std::string Params::text(const OptionRow& row, std::string fallback, std::string choices) const {
  const Value* v = find(row, "string", print_value(fallback), std::move(choices));
  if (!v) return fallback;
  const std::string* s = std::get_if<std::string>(v);
  if (!s) wrong(row, "a string", kind_name(*v));
  return *s;
}

std::size_t Params::choice(const OptionRow& row) const {
  const std::vector<std::string_view> known = split_choices(row.choices);
  const std::string word = text(row, std::string(known.at(0)));
  const auto found = std::find(known.begin(), known.end(), word);
  if (found == known.end()) wrong(row, std::string("one of ") + row.choices, "'" + word + "'");
  return static_cast<std::size_t>(found - known.begin());
}

Vec3 Params::vector(const OptionRow& row, const Vec3& fallback) const {
  const Value* v = find(row, "vector", print_value(fallback));
  if (!v) return fallback;
  const auto* list = std::get_if<std::vector<double>>(v);
  if (!list) wrong(row, "three numbers", kind_name(*v));
  if (list->size() != 3) wrong(row, "three numbers", std::to_string(list->size()));
  Vec3 out;
  for (std::size_t i = 0; i < 3; ++i) {
    const double d = (*list)[i];
    if (!std::isfinite(static_cast<Real>(d))) wrong(row, "finite numbers", print_number(d));
    out[static_cast<Eigen::Index>(i)] = static_cast<Real>(d);
  }
  return out;
}

std::vector<std::pair<std::string, double>> Params::others(std::span<const OptionRow> rows) const {
  std::vector<std::pair<std::string, double>> out;
  for (const auto& entry : values_) {
    const std::string& name = entry.first;
    if (std::any_of(rows.begin(), rows.end(), [&](const OptionRow& row) { return name == row.name; })) continue;
    out.emplace_back(name, number({name.c_str()}, 0));
    asked_.find(name)->second.row.name = "";
  }
  return out;
}

std::vector<OptionInfo> Params::rows() const {
  std::vector<OptionInfo> out;
  for (const auto& [name, info] : asked_)
    if (info.row.name[0]) out.push_back(info);
  return out;
}

bool wide_kernels(const Params& options) { return options.choice({.name = "kernels", .choices = "auto, plain"}) == 0; }

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
    std::vector<std::string> names;
    std::string known;
    for (const auto& [name, info] : asked_) names.push_back(name), known += (known.empty() ? "; known: " : ", ") + name;
    const std::string near = nearest_name(key, names);
    throw SceneError(std::string(owner) + ": unknown option '" + key + "'" +
                     (near.empty() ? known : "; did you mean '" + near + "'?"));
  }
}

// How many letters two words share at their ends.
static std::size_t shared_ends(std::string_view a, std::string_view b) {
  const std::size_t most = std::min(a.size(), b.size());
  std::size_t front = 0, back = 0;
  while (front < most && a[front] == b[front]) ++front;
  while (back < most && a[a.size() - 1 - back] == b[b.size() - 1 - back]) ++back;
  return front + back;
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
    const bool closer = row.back() < best_distance || (row.back() == best_distance && !best.empty() &&
                                                       shared_ends(word, candidate) > shared_ends(word, best));
    if (closer) best_distance = row.back(), best = candidate;
  }
  return best;
}

}  // namespace feder
