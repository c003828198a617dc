// Extreme inputs, each with the result it must have: refused with the object named and the world
// unchanged, or run and end as said. Returns what happened; tests and reports compare.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "feder/params.h"
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

inline constexpr Real kNan = std::numeric_limits<Real>::quiet_NaN();

// Of a run that ends `good`, or else as the verdict says.
inline ExtremeOutcome outcome_of(bool good, Verdict otherwise, std::string detail) {
  return {good, good ? Verdict::stable : otherwise, std::move(detail)};
}

// Runs `act`, which must throw a SceneError that contains `word`, and asks `hash` before and after.
ExtremeOutcome expect_refusal(const char* word, const std::function<void()>& act,
                              const std::function<std::uint64_t()>& hash);
// "label value" with six digits, for details.
std::string labelled(const char* label, double value);

// A description that must be refused: what spoils it, and the word that the refusal must contain.
template <class Desc>
struct RefusalRow {
  const char* name;
  const char* expected;
  const char* word;
  void (*spoil)(Desc&);
};

template <class Desc>
using Refuse = ExtremeOutcome (*)(const char* word, void (*spoil)(Desc&));

template <class Desc>
void add_refusals(const char* system, std::span<const RefusalRow<Desc>> rows, Refuse<Desc> refuse,
                  std::vector<ExtremeCase>& all) {
  for (const RefusalRow<Desc>& row : rows)
    all.push_back({system, row.name, row.expected, false, [=] { return refuse(row.word, row.spoil); }});
}

// A run of every solver with one number that is out of the usual.
struct ExtremeRunRow {
  const char* name;
  const char* expected;
  double value;
  ExtremeOutcome (*run)(const std::string& solver, double value);
};

template <class Solver>
void add_runs(const char* system, std::span<const Variant<Solver>> solvers, std::span<const ExtremeRunRow> rows,
              std::vector<ExtremeCase>& all) {
  for (const Variant<Solver>& solver : solvers)
    for (const ExtremeRunRow& row : rows)
      all.push_back({system, std::string(row.name) + ", " + solver.name, row.expected, false,
                     [=, name = std::string(solver.name)] { return row.run(name, row.value); }});
}

}  // namespace feder
