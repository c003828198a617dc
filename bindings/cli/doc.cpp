// feder doc: the reference, on the terminal, as Markdown, as a page to search, and for editors and shells.
#include <cstdio>
#include <filesystem>

#include "cli/doc_pages.h"
#include "report/output_file.h"

namespace feder::cli {
namespace {

class Doc final : public Command {
 public:
  void declare(Arguments& a) override {
    a.text("WORD", word_, "a name (world:joint, hit, run), an option (density) or any word; none: the list of all");
    a.text("--html", html_, "folder for index.html: all pages, with a search that works offline");
    a.text("--schemas", schemas_,
           "folder for OUTPUT.schema.json: JSON Schemas of all that --json prints, and of scenes in YAML");
    a.flag("--markdown", markdown_, "print all pages as one Markdown document");
    a.flag("--luacats", luacats_, "print stubs with types for the Lua language server");
    a.flag("--man", man_, "print the man page feder.1");
    a.text("--completion", shell_, "print completion for bash, zsh or fish");
  }

  int run(const Options& options) override {
    const Pages pages = all_pages(options.build);
    if (!schemas_.empty()) return write_schema_files(pages, options);
    if (!html_.empty()) return write_html(pages, options);
    if (options.json && !word_.empty()) return print_json(pages_json(find_pages(pages, word_).pages)), kPass;
    const std::string whole = markdown_         ? pages_markdown(pages)
                              : luacats_        ? pages_luacats(pages)
                              : man_            ? pages_man(pages)
                              : !shell_.empty() ? completion(pages, shell_)
                              : !word_.empty()  ? doc_text(pages, word_)
                              : options.json    ? report::to_text(pages_json(pages))
                                                : index_text(pages);
    return print_text(whole);
  }

 private:
  static int print_text(const std::string& text) {
    if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0)
      throw Failure(kFailed, "feder doc: standard output cannot be written");
    return kPass;
  }

  int write_html(const Pages& pages, const Options& options) const {
    namespace fs = std::filesystem;
    const std::string file = (fs::path(html_) / "index.html").string();
    std::error_code told_by_the_file;
    fs::create_directories(html_, told_by_the_file);
    try {
      report::write_text(file, pages_html(pages));
    } catch (const std::runtime_error& e) {
      throw Failure(kFailed, e.what());
    }
    if (options.json)
      print_json({{"file", file}});
    else if (!options.quiet)
      fmt::print("{}\n", file);
    return kPass;
  }

  int write_schema_files(const Pages& pages, const Options& options) const {
    std::error_code told_by_the_file;
    std::filesystem::create_directories(schemas_, told_by_the_file);
    try {
      const std::vector<std::string> files = write_schemas(pages, schemas_);
      if (options.json)
        print_json({{"files", files}});
      else if (!options.quiet)
        fmt::print("{}\n", fmt::join(files, "\n"));
    } catch (const std::runtime_error& e) {
      throw Failure(kFailed, e.what());
    }
    return kPass;
  }

  std::string word_, html_, schemas_, shell_;
  bool markdown_ = false, luacats_ = false, man_ = false;
};

}  // namespace

Row cli_doc() { return command_row<Doc>("doc", "the reference: functions, options, events and commands"); }

}  // namespace feder::cli
