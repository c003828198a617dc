// Options by name, as they come from a script, a YAML file or the command line. Remembers which keys were read, so
// that a misspelt one becomes an error that names the nearest known key, and the rows they were read by.
#pragma once
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.h"
#include "base/option.h"

namespace feder {

class Writer;
class Reader;

class Params {
 public:
  using Value = std::variant<bool, double, std::string, std::vector<double>>;

  void set(std::string key, Value value) { values_[std::move(key)] = std::move(value); }
  bool has(std::string_view key) const { return values_.find(std::string(key)) != values_.end(); }
  bool empty() const { return values_.empty(); }
  const std::map<std::string, Value>& values() const { return values_; }

  // The value of the row's option, or `fallback` when absent. Wrong kind, NaN or out of the row's range: SceneError.
  double number(const OptionRow& row, double fallback) const;
  Real real(const OptionRow& row, double fallback) const { return static_cast<Real>(number(row, fallback)); }
  int integer(const OptionRow& row, int fallback) const;
  bool flag(const OptionRow& row, bool fallback) const;
  // `choices`: of a family that checks the name itself.
  std::string text(const OptionRow& row, std::string fallback, std::string choices = "") const;
  // The place of the word among the row's choices; the first when absent.
  std::size_t choice(const OptionRow& row) const;
  // Three finite numbers.
  Vec3 vector(const OptionRow& row, const Vec3& fallback) const;
  // Numbers under names that the user makes up: all but those of `rows`.
  std::vector<std::pair<std::string, double>> others(std::span<const OptionRow> rows) const;
  // Rows read so far, by name. What a maker read of empty options is all it knows.
  std::vector<OptionInfo> rows() const;

  void save(Writer& w) const;
  void load(Reader& r);  // in place of what is there

  // SceneError when a key was given that nobody asked for. `owner` is named in the message.
  void check_all_read(std::string_view owner) const;

 private:
  const Value* find(const OptionRow& row, const char* type, std::string fallback, std::string choices = "") const;

  std::map<std::string, Value> values_;
  mutable std::map<std::string, OptionInfo, std::less<>> asked_;
};

// kernels = "auto" | "plain": may loops use the vector instructions that the processor has? Results are the same.
bool wide_kernels(const Params& options);

// The member of `known` closest to `word` by edit distance, or "" when none is near.
std::string nearest_name(std::string_view word, const std::vector<std::string>& known);

}  // namespace feder
