// A table: as aligned text with two spaces between columns, as HTML; and its cells as CSV.
#pragma once
#include <concepts>
#include <string>
#include <utility>
#include <vector>

namespace feder::report {

class Table {
 public:
  // A column whose name starts with '>' holds numbers and is aligned to the right.
  explicit Table(std::vector<std::string> columns);
  // `mark` of a row on a page: "bad" or "good".
  void add(std::vector<std::string> cells, const char* mark = "");
  bool empty() const { return rows_.empty(); }
  // Every line starts with `indent`; no blanks at line ends.
  std::string text(const std::string& indent = "") const;
  std::string html() const;

 private:
  struct TableRow {
    std::vector<std::string> cells;
    std::string mark;
  };
  std::vector<std::string> columns_;
  std::vector<bool> right_;
  std::vector<TableRow> rows_;
};

// "512", "14.2 k", "3.05 M" bytes.
std::string bytes_text(std::size_t bytes);

// Cells of CSV (RFC 4180); empty where something does not apply: NaN, counts below 0.
std::string csv_cell(double value);
template <std::integral T>
std::string csv_cell(T value) {
  return std::cmp_less(value, 0) ? "" : std::to_string(value);
}
std::string csv_cell(bool value);
std::string csv_cell(const std::string& text);
std::string csv_cell(const char* text);

template <class T, class... More>
std::string csv_line(const T& first, const More&... more) {
  return (csv_cell(first) + ... + ("," + csv_cell(more)));
}

}  // namespace feder::report
