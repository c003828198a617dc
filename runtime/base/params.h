// Options by name, as they come from a script, a YAML file or the command line. Remembers which keys were read, so
// that a misspelt one becomes an error that names the nearest known key.
#pragma once
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/error.h"
#include "base/types.h"

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

  // The value of `key`, or `fallback` when absent. Wrong kind, NaN or out of [lo, hi]: SceneError.
  double number(std::string_view key, double fallback, double lo = -1e300, double hi = 1e300) const;
  int integer(std::string_view key, int fallback, int lo, int hi) const;
  bool flag(std::string_view key, bool fallback) const;
  std::string text(std::string_view key, std::string fallback) const;
  // Three finite numbers.
  Vec3 vector(std::string_view key, const Vec3& fallback) const;

  void save(Writer& w) const;
  void load(Reader& r);  // in place of what is there

  // SceneError when a key was given that nobody asked for. `owner` is named in the message.
  void check_all_read(std::string_view owner) const;

 private:
  const Value* find(std::string_view key) const;

  std::map<std::string, Value> values_;
  mutable std::set<std::string, std::less<>> asked_;
};

// The member of `known` closest to `word` by edit distance, or "" when none is near.
std::string nearest_name(std::string_view word, const std::vector<std::string>& known);

}  // namespace feder
