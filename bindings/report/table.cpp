#include "report/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/xml.h"

namespace feder::report {

Table::Table(std::vector<std::string> columns) : columns_(std::move(columns)) {
  for (std::string& name : columns_) {
    right_.push_back(!name.empty() && name[0] == '>');
    if (right_.back()) name.erase(0, 1);
  }
}

void Table::add(std::vector<std::string> cells, const char* mark) {
  cells.resize(columns_.size());
  rows_.push_back({std::move(cells), mark});
}

std::string Table::text(const std::string& indent) const {
  std::vector<std::size_t> widths;
  for (const std::string& name : columns_) widths.push_back(name.size());
  for (const TableRow& row : rows_)
    for (std::size_t k = 0; k < widths.size(); ++k) widths[k] = std::max(widths[k], row.cells[k].size());

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
  for (const TableRow& row : rows_) line(row.cells);
  return out;
}

std::string Table::html() const {
  std::string out = "<div class=\"wide\"><table>\n<thead><tr>";
  const auto line = [&](const std::vector<std::string>& cells, const char* tag) {
    for (std::size_t k = 0; k < cells.size(); ++k)
      out += fmt::format("<{0}{1}>{2}</{0}>", tag, right_[k] ? " class=\"n\"" : "", xml_escape(cells[k], true));
  };
  line(columns_, "th");
  out += "</tr></thead>\n<tbody>\n";
  for (const TableRow& row : rows_) {
    out += row.mark.empty() ? "<tr>" : "<tr class=\"" + row.mark + "\">";
    line(row.cells, "td");
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string bytes_text(std::size_t bytes) {
  if (bytes < 1000) return fmt::format("{}", bytes);
  const double k = static_cast<double>(bytes) / 1e3;
  return k < 1000 ? fmt::format("{:.3g} k", k) : fmt::format("{:.4g} M", k / 1e3);
}

std::string csv_cell(double value) { return std::isnan(value) ? "" : fmt::format("{}", value); }
std::string csv_cell(bool value) { return value ? "1" : "0"; }
std::string csv_cell(const char* text) { return csv_cell(std::string(text)); }

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + "\"";
}

}  // namespace feder::report
