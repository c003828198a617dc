#include "report/page.h"

#include "report/xml.h"

namespace feder::report {
namespace {

constexpr const char* kStyle = R"(
:root { color-scheme: light; }
body { margin: 0; background: #ffffff; color: #1f2328; font: 15px/1.5 'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif; }
main { max-width: 1140px; margin: 0 auto; padding: 24px 20px 60px; }
h1 { font-size: 26px; line-height: 1.25; margin: 0 0 6px; }
h2 { font-size: 19px; margin: 36px 0 10px; border-bottom: 1px solid #d9dee3; padding-bottom: 4px; }
p { margin: 6px 0 10px; max-width: 80ch; }
.lead { color: #59636e; font-size: 16px; }
figure { margin: 14px 0 26px; }
figure svg { max-width: 100%; height: auto; border: 1px solid #eaeef2; }
figcaption { color: #59636e; font-size: 14px; margin-top: 4px; max-width: 100ch; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; margin: 8px 0 16px; font-size: 14px; font-variant-numeric: tabular-nums; }
th, td { padding: 4px 12px 4px 8px; border-bottom: 1px solid #e4e8ec; text-align: left; vertical-align: top; }
th { border-bottom: 2px solid #b6c2cf; font-weight: 600; }
th.n, td.n { text-align: right; white-space: nowrap; }
tr.bad td { background: #fff1ee; }
tr.good td { background: #eef8f0; }
dt { font-weight: 600; margin-top: 8px; }
dd { margin: 0 0 4px 0; max-width: 90ch; }
pre, code { font: 13px/1.45 'DejaVu Sans Mono', 'Liberation Mono', Menlo, Consolas, monospace; }
pre { background: #f6f8fa; padding: 10px 12px; overflow-x: auto; }
@media print { main { max-width: none; padding: 0; } h2 { break-after: avoid; } figure, tr { break-inside: avoid; } }
)";

std::string escaped(const std::string& words) { return xml_escape(words, true); }

}  // namespace

Page::Page(const std::string& title) : title_(title) {}

void Page::lead(const std::string& words) { body_ += "<p class=\"lead\">" + escaped(words) + "</p>\n"; }
void Page::heading(const std::string& words) { body_ += "<h2>" + escaped(words) + "</h2>\n"; }
void Page::table(const Table& table) { body_ += table.html(); }
void Page::paragraph(const std::string& words) { body_ += "<p>" + escaped(words) + "</p>\n"; }

void Page::list(const std::vector<std::string>& items) {
  if (items.empty()) return;
  body_ += "<ul>\n";
  for (const std::string& item : items) body_ += "<li>" + escaped(item) + "</li>\n";
  body_ += "</ul>\n";
}

void Page::figure(const std::string& svg, const std::string& caption) {
  body_ += "<figure>\n" + svg + "<figcaption>" + escaped(caption) + "</figcaption>\n</figure>\n";
}

void Page::definitions(const std::vector<std::pair<std::string, std::string>>& terms) {
  body_ += "<dl>\n";
  for (const auto& [term, meaning] : terms)
    body_ += "<dt>" + escaped(term) + "</dt><dd>" + escaped(meaning) + "</dd>\n";
  body_ += "</dl>\n";
}

void Page::links(const std::vector<std::pair<std::string, std::string>>& items) {
  body_ += "<ul>\n";
  for (const auto& [words, target] : items)
    body_ += "<li><a href=\"" + xml_escape(target) + "\">" + escaped(words) + "</a></li>\n";
  body_ += "</ul>\n";
}

void Page::code(const std::string& text) { body_ += "<pre>" + escaped(text) + "</pre>\n"; }

std::string Page::text() const {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         escaped(title_) + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<main>\n<h1>" + escaped(title_) +
         "</h1>\n" + body_ + "</main>\n</body>\n</html>\n";
}

}  // namespace feder::report
