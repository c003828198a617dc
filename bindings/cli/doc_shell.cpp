#include "cli/doc_pages.h"
namespace feder::cli {
std::string pages_man(const Pages&) { return ""; }
std::string completion(const Pages&, const std::string&) { return ""; }
}  // namespace feder::cli
