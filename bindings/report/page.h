// A self-contained HTML page: headings, paragraphs, tables and inline drawings; no script, nothing loaded.
#pragma once
#include <string>
#include <vector>

namespace feder::report {

class Page {
 public:
  explicit Page(const std::string& title);

  void lead(const std::string& words);  // below the title
  void heading(const std::string& words);
  void paragraph(const std::string& words);
  void list(const std::vector<std::string>& items);
  // Columns whose name starts with '>' hold numbers. A row may be marked: "bad" or "good" in `marks`.
  void table(const std::vector<std::string>& columns, const std::vector<std::vector<std::string>>& rows,
             const std::vector<std::string>& marks = {});
  void figure(const std::string& svg, const std::string& caption);
  // Terms with their meaning.
  void definitions(const std::vector<std::pair<std::string, std::string>>& terms);
  // Words with the place they lead to, relative to the page.
  void links(const std::vector<std::pair<std::string, std::string>>& items);
  // Fixed-width words, as typed.
  void code(const std::string& text);

  std::string text() const;

 private:
  std::string title_, body_;
};

}  // namespace feder::report
