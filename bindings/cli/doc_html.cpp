// The reference as one HTML page: an index at the side, a search that needs no server, links within the page alone.
#include "cli/doc_pages.h"
#include "report/xml.h"

namespace feder::cli {
namespace {

constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>feder reference</title>
<style>
:root { color-scheme: light dark; --line: #8884; --soft: #8882; --link: #1a5fb4; }
@media (prefers-color-scheme: dark) { :root { --link: #8ab4f8; } }
body { margin: 0; display: flex; font: 15px/1.5 'Helvetica Neue', Helvetica, Arial, 'DejaVu Sans', sans-serif; }
nav { width: 260px; flex: none; height: 100vh; position: sticky; top: 0; overflow-y: auto; padding: 16px; box-sizing: border-box;
  border-right: 1px solid var(--line); font-size: 14px; }
nav input { width: 100%; box-sizing: border-box; font: inherit; padding: 6px 8px; }
nav h2 { font-size: 14px; margin: 14px 0 2px; }
nav a { display: block; } a { color: var(--link); text-decoration: none; } a:hover { text-decoration: underline; }
main { padding: 16px 28px 80px; max-width: 1000px; min-width: 0; }
section { border-top: 1px solid var(--line); padding: 6px 0 14px; }
h3 { margin: 10px 0 4px; font-size: 17px; }
code, pre { font: 13px/1.45 'DejaVu Sans Mono', Menlo, Consolas, monospace; }
pre { background: var(--soft); padding: 10px 12px; overflow-x: auto; }
table { border-collapse: collapse; font-size: 14px; } td, th { text-align: left; vertical-align: top; padding: 3px 12px 3px 0;
  border-bottom: 1px solid var(--soft); } td:first-child { white-space: nowrap; }
[hidden] { display: none !important; } #none { color: #c33; }
</style>
</head>
<body>
)";

// Words of the query must all be in a section; sections whose title begins with the query come into view.
constexpr const char* kScript = R"(<script>
const query = document.getElementById("search"), none = document.getElementById("none");
const sections = [...document.querySelectorAll("section")];
const links = new Map([...document.querySelectorAll("nav a")].map(a => [a.getAttribute("href").slice(1), a]));
const texts = sections.map(s => s.textContent.toLowerCase());
function search() {
  const words = query.value.toLowerCase().split(/\s+/).filter(w => w);
  let shown = 0;
  sections.forEach((s, i) => {
    const hit = words.every(w => texts[i].includes(w));
    s.hidden = !hit; links.get(s.id).hidden = !hit; shown += hit;
  });
  none.hidden = shown > 0;
  document.querySelectorAll("nav div").forEach(d => d.hidden = ![...d.querySelectorAll("a")].some(a => !a.hidden));
  const first = words.length && sections.find(s => !s.hidden && s.dataset.name.startsWith(words[0]));
  if (first) first.scrollIntoView();
}
query.addEventListener("input", search);
document.addEventListener("keydown", e => { if (e.key == "/" && document.activeElement != query) { e.preventDefault(); query.focus(); } });
</script>
</body>
</html>
)";

std::string safe(const std::string& text) { return report::xml_escape(text, true); }

// Of a title: "world:joint" is world-joint; unique because titles are.
std::string anchor(const std::string& title) {
  std::string out;
  for (const char c : title) out += c == ':' || c == '.' || c == ' ' ? '-' : c;
  return report::xml_escape(out);
}

std::string row_html(const lua::ReferenceRow& r) {
  std::string meaning = safe(r.text);
  if (!r.allowed.empty()) meaning += " <i>" + safe(r.allowed) + "</i>";
  if (!r.of.empty()) meaning += " (" + safe(r.of) + " alone)";
  return fmt::format("<tr><td><code>{}</code></td><td>{}</td><td>{}</td><td><code>{}</code></td><td>{}</td></tr>\n",
                     safe(r.name), safe(r.type), safe(r.unit), safe(r.fallback), meaning);
}

std::string section(const lua::ReferencePage& p) {
  std::string out =
      fmt::format("<section id=\"{}\" data-name=\"{}\"><h3>{}</h3>\n<pre>{}</pre>\n<p>{}</p>\n", anchor(p.title),
                  report::xml_escape(p.name), safe(p.title), safe(p.signature), safe(p.text));
  if (!p.rows.empty()) {
    out += "<table><tr><th>name</th><th>type</th><th>unit</th><th>default</th><th>meaning</th></tr>\n";
    for (const lua::ReferenceRow& r : p.rows) out += row_html(r);
    out += "</table>\n";
  }
  if (!p.example.empty()) out += "<pre>" + safe(p.example) + "</pre>\n";
  return out + "</section>\n";
}

}  // namespace

std::string pages_html(const Pages& pages) {
  std::string index, body;
  for (const Owner& owner : owners(pages)) {
    index += "<div><h2>" + safe(owner.name) + "</h2>\n";
    for (const lua::ReferencePage& p : pages) {
      if (p.owner != owner.name) continue;
      index += "<a href=\"#" + anchor(p.title) + "\">" + safe(p.name) + "</a>\n";
      body += section(p);
    }
    index += "</div>\n";
  }
  return kHead +
         ("<nav><input id=\"search\" type=\"search\" placeholder=\"search (/)\" autofocus>\n<p id=\"none\" hidden>"
          "nothing has all these words</p>\n" +
          index) +
         "</nav>\n<main><h1>feder reference</h1>\n<p>feder " FEDER_VERSION
         ": SI units, radians, y is up, right-handed. A table of options takes names; what is left out has its "
         "default.</p>\n" +
         body + "</main>\n" + kScript;
}

}  // namespace feder::cli
