// The man page (roff), and completion of commands, options and scene files for bash, zsh and fish: from the same rows
// as
// --help.
#include <algorithm>

#include "cli/doc_pages.h"

namespace feder::cli {
namespace {

std::vector<const lua::ReferencePage*> commands_of(const Pages& pages) {
  std::vector<const lua::ReferencePage*> out;
  for (const lua::ReferencePage& p : pages)
    if (p.kind == lua::PageKind::command) out.push_back(&p);
  return out;
}

// "-q,--quiet" in its parts, those with dashes.
std::vector<std::string> spellings(const std::string& name) {
  std::vector<std::string> out;
  for (std::size_t at = 0; at < name.size();) {
    const std::size_t end = std::min(name.find(',', at), name.size());
    if (name[at] == '-') out.push_back(name.substr(at, end - at));
    at = end + 1;
  }
  return out;
}

std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '\\' ? "\\e" : c == '-' ? "\\-" : std::string(1, c);
  return !out.empty() && (out[0] == '.' || out[0] == '\'') ? "\\&" + out : out;
}

// In single quotes of a shell.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

std::string bash(const Pages& pages) {
  std::string names, cases;
  for (const lua::ReferencePage* p : commands_of(pages)) {
    names += " " + p->name;
    std::string options;
    for (const lua::ReferenceRow& r : p->rows)
      for (const std::string& s : spellings(r.name)) options += " " + s;
    cases += "    " + p->name + ") options='" + options.substr(std::min<std::size_t>(1, options.size())) + "' ;;\n";
  }
  return "# Completion of feder for bash: source <(feder doc --completion bash)\n_feder() {\n"
         "  local word=${COMP_WORDS[COMP_CWORD]} options=''\n  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
         "    COMPREPLY=($(compgen -W '" +
         names.substr(1) + "' -- \"$word\"))\n    return\n  fi\n  case ${COMP_WORDS[1]} in\n" + cases +
         "  esac\n  case $word in\n    -*) COMPREPLY=($(compgen -W \"$options\" -- \"$word\")) ;;\n"
         "    *) COMPREPLY=($(compgen -f -- \"$word\")) ;;\n  esac\n}\ncomplete -o filenames -F _feder feder\n";
}

std::string zsh(const Pages& pages) {
  std::string names, cases;
  const auto described = [](std::string text) {
    for (std::size_t at = 0; (at = text.find_first_of("[]:", at)) != std::string::npos; at += 2) text.insert(at, "\\");
    return text;
  };
  for (const lua::ReferencePage* p : commands_of(pages)) {
    names += " " + quoted(p->name + ":" + described(p->text));
    cases += "    " + p->name + ") _arguments";
    for (const lua::ReferenceRow& r : p->rows)
      for (const std::string& s : spellings(r.name))
        cases += " " + quoted(s + "[" + described(r.text) + "]" + (r.type.empty() ? "" : ":value:_files"));
    cases += " '*:file:_files' ;;\n";
  }
  return "#compdef feder\n# Completion of feder for zsh: feder doc --completion zsh > \"${fpath[1]}/_feder\"\n_feder() "
         "{\n"
         "  local -a commands\n  commands=(" +
         names.substr(1) +
         ")\n  if (( CURRENT == 2 )); then\n    _describe command commands\n    return\n  fi\n"
         "  local command=$words[2]\n  shift words\n  (( CURRENT-- ))\n  case $command in\n" +
         cases + "  esac\n}\n_feder \"$@\"\n";
}

std::string fish(const Pages& pages) {
  std::string out = "# Completion of feder for fish: feder doc --completion fish | source\n";
  for (const lua::ReferencePage* p : commands_of(pages)) {
    out += "complete -c feder -n __fish_use_subcommand -f -a " + p->name + " -d " + quoted(p->text) + "\n";
    for (const lua::ReferenceRow& r : p->rows) {
      std::string words;
      for (const std::string& s : spellings(r.name))
        words += s.starts_with("--") ? " -l " + s.substr(2) : " -s " + s.substr(1);
      if (words.empty()) continue;
      out += "complete -c feder -n '__fish_seen_subcommand_from " + p->name + "'" + words +
             (r.type.empty() ? "" : " -r") + " -d " + quoted(r.text) + "\n";
    }
  }
  return out;
}

}  // namespace

std::string pages_man(const Pages& pages) {
  std::string out = ".TH FEDER 1 \"\" \"feder " FEDER_VERSION
                    "\"\n.SH NAME\nfeder \\- a physics sandbox scripted from Lua\n"
                    ".SH SYNOPSIS\n.B feder\n.I COMMAND\n[\\fISCENE\\fR] [\\fIoptions\\fR]\n.SH COMMANDS\n";
  for (const lua::ReferencePage* p : commands_of(pages)) {
    out += ".SS " + roff(p->signature) + "\n" + roff(p->text) + "\n";
    for (const lua::ReferenceRow& r : p->rows) out += ".TP\n.B " + roff(r.name) + "\n" + roff(r.text) + "\n";
  }
  return out + ".SH EXIT STATUS\n" + kStatusText +
         "\n.SH SEE ALSO\nfeder doc lists what scripts may use; feder doc \\-\\-html writes it as pages.\n";
}

std::string completion(const Pages& pages, const std::string& shell) {
  if (shell == "bash") return bash(pages);
  if (shell == "zsh") return zsh(pages);
  if (shell == "fish") return fish(pages);
  throw Failure(kUsage, "feder doc: --completion: expected bash, zsh or fish, got '{}'", shell);
}

}  // namespace feder::cli
