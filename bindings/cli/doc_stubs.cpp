#include "cli/doc_pages.h"
namespace feder::cli {
std::string pages_luacats(const Pages&) { return ""; }
}  // namespace feder::cli
