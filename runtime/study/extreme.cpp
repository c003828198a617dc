// The table of extreme inputs, and the check of a refusal: message, and the same hash before and after.
#include "study/extreme.h"

#include <cstdio>

#include "feder/error.h"

namespace feder {

#include "study_extremes_declare.inc"

std::vector<ExtremeCase> extreme_cases() {
  std::vector<ExtremeCase> all;
  for (std::vector<ExtremeCase> (*const make)() : {
#include "study_extremes_rows.inc"
       })
    for (ExtremeCase& c : make()) all.push_back(std::move(c));
  return all;
}

std::string labelled(const char* label, double value) {
  char text[160];
  std::snprintf(text, sizeof text, "%s %.6g", label, value);
  return text;
}

ExtremeOutcome expect_refusal(const char* word, const std::function<void()>& act,
                              const std::function<std::uint64_t()>& hash) {
  const std::uint64_t before = hash();
  try {
    act();
  } catch (const SceneError& e) {
    const std::string message = e.what();
    const bool named = message.find(word) != std::string::npos, unchanged = hash() == before;
    return {named && unchanged, Verdict::refused,
            message + (named ? "" : std::string("; does not name ") + word) + (unchanged ? "" : "; the world changed")};
  }
  return {false, Verdict::stable, "was accepted"};
}

}  // namespace feder
