// Which tests run: files and values of their parameters, chosen by path, tag and share, in an order.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace feder::cli {

struct TestCase {
  std::string file;
  std::vector<std::string> set;  // NAME=VALUE of its parameters

  std::string name() const;  // "tower.lua", "tower.lua[height=3,friction=0.5]"
};
// A name as above; a file whose own name looks like one is a file.
TestCase read_case(const std::string& name);

struct TestChoice {
  std::vector<std::string> paths;   // files, folders, names of cases
  std::string filter;               // text of the path
  std::vector<std::string> tags;    // any of these, none of the ones with ~ in front
  std::vector<std::string> sweeps;  // NAME=A,B,C or NAME=FROM:TO:STEP: every combination is a case
  std::string shard;                // "2/5": the second of five shares
  bool shuffle = false;
  std::uint64_t order = 0;  // seed of the shuffle
};
// Sorted by name, unless shuffled. Failure (usage) for what cannot be read.
std::vector<TestCase> choose_tests(const TestChoice& choice);

// The words behind "-- tags:" ("# tags:" in YAML) in the first lines of a file.
std::vector<std::string> tags_of(const std::string& file);
bool is_plain_test(const std::string& file);  // *_test.lua, test_*.lua

}  // namespace feder::cli
