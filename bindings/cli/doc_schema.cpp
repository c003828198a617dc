// JSON Schemas (2020-12) of what --json prints, and the rows that a command's page has on it: from the lines of
// outputs.txt, whose head says what they may be.
#include <algorithm>
#include <filesystem>
#include <sstream>

#include "cli/doc_pages.h"
#include "report/output_file.h"

namespace feder::cli {
namespace {

using report::Json;

// "run.energy.kinetic", "number|null", "J", "Of motion."
struct OutputRow {
  std::string path, type, unit, text;
};

const std::vector<OutputRow>& output_rows() {
  static const auto all = [] {
    std::istringstream lines(
#include "output_texts.inc"
    );
    std::vector<OutputRow> rows;
    for (std::string line; std::getline(lines, line);) {
      if (line.empty() || line[0] == '#') continue;
      OutputRow row;
      std::istringstream words(line);
      words >> row.path >> row.type >> row.unit >> std::ws;
      std::getline(words, row.text);
      if (row.unit == "-") row.unit.clear();
      rows.push_back(std::move(row));
    }
    return rows;
  }();
  return all;
}

Json schema_of(const std::string& path);

// "number|null[]?": names of types, then what is made of them; or the path of another row.
Json typed(std::string type) {
  if (type.back() == '?') type.pop_back();
  const auto same_path = [&](const OutputRow& row) { return row.path == type; };
  if (std::ranges::any_of(output_rows(), same_path)) return schema_of(type);
  if (type.ends_with("[0]")) return typed(type.substr(0, type.size() - 3)).at("items");
  const std::string last = type.substr(type.size() - 2), inner = type.substr(0, type.size() - 2);
  if (last == "[]") return {{"type", "array"}, {"items", typed(inner)}};
  if (last == "{}") return {{"type", "object"}, {"additionalProperties", typed(inner)}};
  Json schema = Json::object(), types = Json::array();
  std::istringstream words(type);
  for (std::string name; std::getline(words, name, '|');) {
    types.push_back(name == "inf" ? "string" : name);
    if (name == "inf") schema["pattern"] = "^-?inf$";
  }
  schema["type"] = types.size() == 1 ? types[0] : types;
  if (std::ranges::find(types, Json("object")) != types.end())
    schema.update({{"properties", Json::object()}, {"required", Json::array()}, {"additionalProperties", false}});
  return schema;
}

Json described(const OutputRow& row) {
  Json schema = typed(row.type);
  schema["description"] = row.text + (row.unit.empty() ? "" : " Unit: " + row.unit + ".");
  return schema;
}

// `below`: what is left of the row's path, ".plan[].ms".
void place(Json& schema, const std::string& below, const OutputRow& row) {
  if (below[0] == '[') return place(schema["items"], below.substr(2), row);
  const std::size_t end = below.find_first_of(".[", 1);
  const std::string name = below.substr(1, end - 1);
  Json& field = name == "*" ? schema["additionalProperties"] : schema["properties"][name];
  if (end != std::string::npos) return place(field, below.substr(end), row);
  field = described(row);
  if (name != "*" && row.type.back() != '?') schema["required"].push_back(name);
}

// Of a row and all rows below it.
Json schema_of(const std::string& path) {
  Json schema;
  for (const OutputRow& row : output_rows()) {
    if (row.path == path) schema = described(row);
    if (row.path.starts_with(path + ".") || row.path.starts_with(path + "["))
      place(schema, row.path.substr(path.size()), row);
  }
  return schema;
}

// Tables of a command: points.csv.
struct Table {
  std::string_view name, command;
};
constexpr Table kTables[] = {{"points", "study"}, {"cells", "stability"}, {"limits", "stability"}};

}  // namespace

std::vector<lua::ReferenceRow> output_fields(const std::string& command) {
  std::vector<lua::ReferenceRow> out;
  for (const auto& [path, type, unit, text] : output_rows()) {
    // study_list[].name: paths as jq has them, behind the word that makes the command print this
    const std::size_t end = std::min(path.find_first_of(".["), path.size());
    const std::string output = path.substr(0, end), word = output.substr(0, output.find('_'));
    const auto table = std::ranges::find(kTables, output, &Table::name);
    if (table == std::end(kTables) ? word != command : table->command != command) continue;
    std::string name = (end == path.size() || path[end] == '[' ? "." : "") + path.substr(end);
    if (output != word) name = output.substr(word.size() + 1) + " " + name;
    if (table != std::end(kTables)) name = path;
    const bool of_json = end == path.size() && !text.starts_with("In ");
    out.push_back({name, type, unit, "", "", "", (of_json ? "Of --json: " : "") + text});
  }
  return out;
}

std::vector<std::string> write_schemas(const Pages& pages, const std::string& folder) {
  std::vector<std::string> files;
  for (const OutputRow& row : output_rows()) {
    if (row.path.find('.') != std::string::npos || row.path.find('[') != std::string::npos) continue;
    Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "feder " + row.path}};
    schema.update(schema_of(row.path));
    files.push_back((std::filesystem::path(folder) / (row.path + ".schema.json")).string());
    report::write_text(files.back(), report::to_text(schema));
  }
  files.push_back((std::filesystem::path(folder) / kYamlSchema).string());
  report::write_text(files.back(), report::to_text(yaml_schema(pages)));
  return files;
}

}  // namespace feder::cli
