#include "cli/test_case.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "base/rng.h"
#include "cli/command.h"
#include "cli/scene_files.h"
#include "cli/session.h"

namespace feder::cli {
namespace {

// Folders also hold modules and material tables.
bool looks_like_test(const std::string& file) { return is_plain_test(file) || looks_like_scene(file, ".scene"); }

std::vector<std::string> split_list(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  return parts;
}

struct Sweep {
  std::string name;
  std::vector<std::string> values;
};

Sweep read_sweep(const std::string& given) {
  const std::size_t equals = given.find('=');
  const std::string values = equals == std::string::npos ? "" : given.substr(equals + 1);
  if (equals == 0 || values.empty())
    throw Failure(kUsage, "--sweep: expected NAME=A,B,C or NAME=FROM:TO:STEP, got '{}'", given);
  Sweep sweep{given.substr(0, equals), {}};
  const std::vector<std::string> range = split_list(values, ':');
  if (range.size() == 1) {
    sweep.values = split_list(values, ',');
    return sweep;
  }
  if (range.size() != 3) throw Failure(kUsage, "--sweep: expected NAME=FROM:TO:STEP, got '{}'", given);
  const double from = read_number(range[0], "--sweep"), to = read_number(range[1], "--sweep"),
               step = read_number(range[2], "--sweep");
  const double count = step > 0 ? std::floor((to - from) / step + 1e-9) : -1;
  if (!(count >= 0 && count < 10000))
    throw Failure(kUsage, "--sweep: expected 1 to 10000 values from FROM up to TO, got '{}'", given);
  for (int i = 0; i <= static_cast<int>(count); ++i) sweep.values.push_back(fmt::format("{:.12g}", from + i * step));
  return sweep;
}

// Every combination of values, the last name changing fastest.
std::vector<std::vector<std::string>> combinations(const std::vector<std::string>& sweeps) {
  std::vector<std::vector<std::string>> all = {{}};
  for (const std::string& given : sweeps) {
    const Sweep sweep = read_sweep(given);
    std::vector<std::vector<std::string>> longer;
    for (const auto& sets : all)
      for (const std::string& value : sweep.values) {
        longer.push_back(sets);
        longer.back().push_back(sweep.name + "=" + value);
      }
    all = std::move(longer);
    if (all.size() > 10000) throw Failure(kUsage, "--sweep: more than 10000 combinations");
  }
  return all;
}

bool is_wanted(const TestCase& test, const TestChoice& choice) {
  if (test.file.find(choice.filter) == std::string::npos) return false;
  if (choice.tags.empty()) return true;
  const std::vector<std::string> own = tags_of(test.file);
  const auto has = [&](const std::string& tag) { return std::ranges::find(own, tag) != own.end(); };
  bool any = false, asked = false;
  for (const std::string& tag : choice.tags) {
    if (tag.starts_with('~')) {
      if (has(tag.substr(1))) return false;
    } else {
      asked = true, any = any || has(tag);
    }
  }
  return any || !asked;
}

// Every count-th, so that neighbours, which cost alike, are shared out.
void take_share(std::vector<TestCase>& tests, const std::string& shard) {
  if (shard.empty()) return;
  const std::vector<std::string> parts = split_list(shard, '/');
  const double number = parts.size() == 2 ? read_number(parts[0], "--shard") : 0;
  const double count = parts.size() == 2 ? read_number(parts[1], "--shard") : 0;
  if (!(number >= 1 && number <= count && count <= 10000 && number == std::floor(number) && count == std::floor(count)))
    throw Failure(kUsage, "--shard: expected I/N with I from 1 to N, got '{}'", shard);
  std::vector<TestCase> mine;
  for (std::size_t i = static_cast<std::size_t>(number) - 1; i < tests.size(); i += static_cast<std::size_t>(count))
    mine.push_back(tests[i]);
  tests = std::move(mine);
}

}  // namespace

std::string TestCase::name() const { return set.empty() ? file : fmt::format("{}[{}]", file, fmt::join(set, ",")); }

TestCase read_case(const std::string& name) {
  std::error_code ignored;
  const std::size_t open = name.rfind('[');
  if (!name.ends_with(']') || open == std::string::npos || std::filesystem::exists(name, ignored)) return {name, {}};
  return {name.substr(0, open), split_list(name.substr(open + 1, name.size() - open - 2), ',')};
}

std::vector<TestCase> choose_tests(const TestChoice& choice) {
  std::vector<TestCase> tests;
  std::vector<std::string> places;
  const auto all_values = combinations(choice.sweeps);
  const auto add = [&](const TestCase& test) {
    if (!is_wanted(test, choice)) return;
    for (const auto& values : all_values) {
      tests.push_back(test);
      tests.back().set.insert(tests.back().set.end(), values.begin(), values.end());
    }
  };
  for (const std::string& path : choice.paths) {
    const TestCase test = read_case(path);
    if (test.set.empty()) places.push_back(path);
    // the same complaint about a missing file as below
    if (!test.set.empty()) find_files({test.file}, looks_like_test), add(test);
  }
  for (const std::string& file : find_files(places, looks_like_test)) add({file, {}});
  std::ranges::stable_sort(tests, {}, &TestCase::file);
  take_share(tests, choice.shard);
  if (!choice.shuffle) return tests;
  // Fisher and Yates
  Rng random(choice.order);
  for (std::size_t i = tests.size(); i > 1; --i) std::swap(tests[i - 1], tests[random.next() % i]);
  return tests;
}

std::vector<std::string> tags_of(const std::string& file) {
  constexpr int kLines = 20;
  std::istringstream in(read_text(file));
  std::string line;
  for (int i = 0; i < kLines && std::getline(in, line); ++i) {
    const std::size_t at = line.find("tags:");
    if (at == std::string::npos || line.find_first_not_of("-# \t") != at || at == 0) continue;
    std::ranges::replace(line, ',', ' ');
    std::istringstream words(line.substr(at + 5));
    std::vector<std::string> tags;
    for (std::string word; words >> word;) tags.push_back(word);
    return tags;
  }
  return {};
}

bool is_plain_test(const std::string& file) {
  const std::string stem = std::filesystem::path(file).stem().string();
  return file.ends_with(".lua") && (stem.ends_with("_test") || stem.starts_with("test_"));
}

}  // namespace feder::cli
