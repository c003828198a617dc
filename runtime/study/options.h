// Parameters of a problem: read from options, and recorded with range and help for listings. Private to the module.
#pragma once
#include <charconv>

#include "feder/study.h"

namespace feder {

// Shortest digits that read back as the same number.
inline std::string print_shortest(double x) {
  char buffer[40];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, x);
  return error == std::errc() ? std::string(buffer, end) : std::string("?");
}

class ProblemOptions {
 public:
  ProblemOptions(const Params& given, ProblemInfo& info) : given_(given), info_(info) {}

  double number(const char* name, double fallback, double lo, double hi, const char* help) {
    const double x = given_.number({name, "", {lo, hi}}, fallback);
    info_.params.push_back({name, print_shortest(x), print_shortest(fallback), help, lo, hi, {}});
    return x;
  }
  int integer(const char* name, int fallback, int lo, int hi, const char* help) {
    const int n = given_.integer({name, "", {double(lo), double(hi)}}, fallback);
    info_.params.push_back({name, std::to_string(n), std::to_string(fallback), help, double(lo), double(hi), {}});
    return n;
  }
  bool flag(const char* name, bool fallback, const char* help) {
    const bool b = given_.flag({name}, fallback);
    const auto word = [](bool x) { return std::string(x ? "true" : "false"); };
    info_.params.push_back({name, word(b), word(fallback), help, NAN, NAN, {"false", "true"}});
    return b;
  }
  // The index of the word in `choices`.
  std::size_t choice(const char* name, const char* fallback, std::vector<std::string> choices, const char* help) {
    const std::string word = given_.text({name}, fallback);
    std::string known;
    for (std::size_t i = 0; i < choices.size(); ++i) {
      known += (i ? ", " : "") + choices[i];
      if (choices[i] != word) continue;
      info_.params.push_back({name, word, fallback, help, NAN, NAN, std::move(choices)});
      return i;
    }
    throw SceneError(std::string(name) + ": expected one of " + known + ", got '" + word + "'");
  }

 private:
  const Params& given_;
  ProblemInfo& info_;
};

}  // namespace feder
