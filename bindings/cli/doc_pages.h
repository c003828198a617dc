// The pages of `feder doc`: those of scripts (lua/reference.h) and one per command; found by word, and written as text,
// Markdown, HTML, stubs for the Lua language server, a man page and completion of shells.
#pragma once
#include "cli/command.h"
#include "lua/reference.h"

namespace feder::cli {

using Pages = std::vector<lua::ReferencePage>;

// Everything that this build has.
Pages all_pages(const Build& build);

// What a word finds: pages of that name, else of that owner, else options and fields of that name, else what has the
// word in its text. `exact`: pages to show whole.
struct Found {
  Pages pages;
  bool exact = false;
};
Found find_pages(const Pages& all, const std::string& word);

// What `feder doc WORD` prints. Failure where nothing has the word.
std::string doc_text(const Pages& all, const std::string& word);

// Owners in their order, each with what it is: "world", "a world's methods".
struct Owner {
  std::string name, text;
};
std::vector<Owner> owners(const Pages& pages);

std::string page_text(const lua::ReferencePage& page);                 // whole
std::string line_text(const lua::ReferencePage& page);                 // signature and sentence
std::string index_text(const Pages& pages);                            // all owners with their names
std::string pages_markdown(const Pages& pages);                        // one document
std::string pages_html(const Pages& pages);                            // one page, searchable without a server
std::string pages_luacats(const Pages& pages);                         // a stub file, library/feder.lua
std::string pages_man(const Pages& pages);                             // feder.1, roff
std::string completion(const Pages& pages, const std::string& shell);  // bash, zsh, fish; Failure (usage) for others
// What --json of a command prints, a row per field: ".energy.kinetic".
std::vector<lua::ReferenceRow> output_fields(const std::string& command);
// OUTPUT.schema.json for everything that --json prints, and of scenes in YAML; their paths. std::runtime_error "file:
// cannot be written".
std::vector<std::string> write_schemas(const Pages& pages, const std::string& folder);
// scene.yaml.schema.json: of scenes in YAML, for editors.
inline constexpr const char* kYamlSchema = "scene.yaml.schema.json";
report::Json yaml_schema(const Pages& pages);
report::Json pages_json(const Pages& pages);

}  // namespace feder::cli
