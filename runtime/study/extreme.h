// The extreme inputs of numerics.md 3.6, each with the result it must have: refused with the object named and the world
// unchanged, or run and end as said. Returns what happened; tests and reports compare.
#pragma once
#include <functional>
#include <span>
#include <string>

#include "study/stability.h"

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

std::span<const ExtremeCase> extreme_spring_cases();
std::span<const ExtremeCase> extreme_rigid_cases();
std::vector<ExtremeCase> extreme_cloth_cases();  // where cloth is built; with each of its solvers
std::vector<ExtremeCase> extreme_fluid_cases();  // likewise
std::vector<ExtremeCase> extreme_cases();        // all

// Runs `act`, which must throw a SceneError that contains `word`, and asks `hash` before and after.
ExtremeOutcome expect_refusal(const char* word, const std::function<void()>& act,
                              const std::function<std::uint64_t()>& hash);
// "label value" with six digits, for details.
std::string labelled(const char* label, double value);

}  // namespace feder
