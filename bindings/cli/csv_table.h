// A CSV file with a row per step (RFC 4180; numbers in the shortest decimal text that reads back exactly). Columns may
// appear while it grows: rows wait in a side file, and the file is written at the end, one header line above them, with
// empty cells where a column was not there yet.
#pragma once
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "cli/command.h"

namespace feder::cli {

class CsvTable {
 public:
  // Failure (1) when it cannot be written, here and later.
  explicit CsvTable(std::filesystem::path file);
  ~CsvTable();  // without close() nothing is left
  CsvTable(const CsvTable&) = delete;
  CsvTable& operator=(const CsvTable&) = delete;

  // A new one at the right end; its number.
  std::size_t add_column(const std::string& header);
  std::size_t size() const { return cells_.size(); }
  // A cell of the current row; those that are not set are empty.
  template <class T>
  void set(std::size_t column, T value) {
    cells_[column] = fmt::format("{}", value);
  }
  void end_row();
  void close();

 private:
  [[noreturn]] void fail() const;

  std::filesystem::path file_, side_;
  std::ofstream rows_;
  std::vector<std::string> headers_, cells_;
};

}  // namespace feder::cli
