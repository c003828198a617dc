#include "report/table.h"

#include <fmt/format.h>

#include <algorithm>

namespace feder::report {

Table::Table(std::vector<std::string> columns) : columns_(std::move(columns)) {
  for (std::string& name : columns_) {
    right_.push_back(!name.empty() && name[0] == '>');
    if (right_.back()) name.erase(0, 1);
  }
}

void Table::add(std::vector<std::string> cells) {
  cells.resize(columns_.size());
  rows_.push_back(std::move(cells));
}

std::string Table::text(const std::string& indent) const {
  std::vector<std::size_t> widths;
  for (const std::string& name : columns_) widths.push_back(name.size());
  for (const auto& row : rows_)
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], row[k].size());

  std::string out;
  const auto line = [&](const std::vector<std::string>& cells) {
    std::string text = indent;
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const std::string blanks(widths[k] - cells[k].size(), ' ');
      text += (k ? "  " : "") + (right_[k] ? blanks + cells[k] : cells[k] + blanks);
    }
    text.erase(text.find_last_not_of(' ') + 1);
    out += text + "\n";
  };
  line(columns_);
  for (const auto& row : rows_) line(row);
  return out;
}

std::string bytes_text(std::size_t bytes) {
  if (bytes < 1000) return fmt::format("{}", bytes);
  const double k = static_cast<double>(bytes) / 1e3;
  return k < 1000 ? fmt::format("{:.3g} k", k) : fmt::format("{:.4g} M", k / 1e3);
}

}  // namespace feder::report
