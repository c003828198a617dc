// A table as aligned text: two spaces between columns, numbers to the right.
#pragma once
#include <string>
#include <vector>

namespace feder::report {

class Table {
 public:
  // A column whose name starts with '>' is aligned to the right.
  explicit Table(std::vector<std::string> columns);
  void add(std::vector<std::string> cells);
  bool empty() const { return rows_.empty(); }
  // Every line starts with `indent`; no blanks at line ends.
  std::string text(const std::string& indent = "") const;

 private:
  std::vector<std::string> columns_;
  std::vector<bool> right_;
  std::vector<std::vector<std::string>> rows_;
};

// "512", "14.2 k", "3.05 M" bytes.
std::string bytes_text(std::size_t bytes);

}  // namespace feder::report
