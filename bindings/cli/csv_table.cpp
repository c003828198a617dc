#include "cli/csv_table.h"

#include <algorithm>
#include <cerrno>

#include "report/output_file.h"

namespace feder::cli {
namespace {

namespace fs = std::filesystem;

std::string csv_quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

}  // namespace

CsvTable::CsvTable(fs::path file) : file_(std::move(file)) {
  errno = 0;
  // a device has no room beside it
  const bool beside = report::is_replaceable(file_);
  side_ = report::side_file(beside ? file_ : fs::temp_directory_path() / "feder_rows");
  side_ += ".csv";
  rows_.open(side_, std::ios::binary | std::ios::trunc);
  if (!rows_) fail();
}

CsvTable::~CsvTable() {
  rows_.close();
  std::error_code ignored;
  fs::remove(side_, ignored);
}

void CsvTable::fail() const {
  try {
    report::fail_to_write(file_);
  } catch (const std::runtime_error& e) {
    throw Failure(kFailed, e.what());
  }
}

std::size_t CsvTable::add_column(const std::string& header) {
  headers_.push_back(header);
  cells_.emplace_back();
  return cells_.size() - 1;
}

void CsvTable::end_row() {
  errno = 0;
  for (std::size_t k = 0; k < cells_.size(); ++k) rows_ << (k ? "," : "") << cells_[k];
  if (!(rows_ << '\n')) fail();
  for (std::string& cell : cells_) cell.clear();
}

void CsvTable::close() {
  errno = 0;
  rows_.close();
  if (!rows_) fail();
  try {
    report::OutputFile out(file_);
    std::ifstream rows(side_, std::ios::binary);
    for (std::size_t k = 0; k < headers_.size(); ++k) out.stream() << (k ? "," : "") << csv_quoted(headers_[k]);
    out.stream() << '\n';
    for (std::string row; std::getline(rows, row);) {
      const auto there = static_cast<std::size_t>(std::ranges::count(row, ',')) + 1;
      out.stream() << row << std::string(headers_.size() - there, ',') << '\n';
    }
    out.close();
  } catch (const std::runtime_error& e) {
    throw Failure(kFailed, e.what());
  }
}

}  // namespace feder::cli
