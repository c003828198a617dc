// A self-contained HTML page: headings, paragraphs, tables and inline drawings; no script, nothing loaded.
#pragma once
#include <string>
#include <vector>

#include "report/table.h"

namespace feder::report {

class Page {
 public:
  explicit Page(const std::string& title);

  void lead(const std::string& words);  // below the title
  void heading(const std::string& words);
  void paragraph(const std::string& words);
  void list(const std::vector<std::string>& items);
  void table(const Table& table);
  void figure(const std::string& svg, const std::string& caption);
  // Terms with their meaning.
  void definitions(const std::vector<std::pair<std::string, std::string>>& terms);
  // Words with the address they lead to, relative to the page.
  void links(const std::vector<std::pair<std::string, std::string>>& items);
  // Fixed-width words, as typed.
  void code(const std::string& text);

  std::string text() const;

 private:
  std::string title_, body_;
};

}  // namespace feder::report
