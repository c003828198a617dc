// Extreme inputs, each with the result it must have: refused with the object named and the world
// unchanged, or run and end as said. Returns what happened; tests and reports compare.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "feder/stability.h"

namespace feder {

struct ExtremeOutcome {
  bool as_expected = false;
  Verdict verdict = Verdict::stable;
  std::string detail;  // numbers, or the message of the refusal
};

struct ExtremeCase {
  const char* system;  // "springs", "rigid", "cloth", "fluid", "world"
  std::string name;
  const char* expected;  // one sentence
  bool slow;             // takes more than about a second
  std::function<ExtremeOutcome()> run;
};

// All: a file extreme_<name>.cpp defines `std::vector<ExtremeCase> <name>_extremes()`, and a line of the module's table
// lists it.
std::vector<ExtremeCase> extreme_cases();

// Runs `act`, which must throw a SceneError that contains `word`, and asks `hash` before and after.
ExtremeOutcome expect_refusal(const char* word, const std::function<void()>& act,
                              const std::function<std::uint64_t()>& hash);
// "label value" with six digits, for details.
std::string labelled(const char* label, double value);

}  // namespace feder
