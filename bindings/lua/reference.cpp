// Sentences on options, from the options.txt of all folders.
#include <string>

#include "lua/docs.h"

namespace feder::lua {
namespace {

// Lines "owner.option  sentence", of all options.txt.
constexpr std::string_view kTexts =
#include "option_texts.inc"
    ;

std::string_view sentence(const std::string& key) {
  const std::size_t at = kTexts.find("\n" + key + " ");
  if (at == std::string_view::npos) return {};
  const std::size_t from = kTexts.find_first_not_of(' ', at + 1 + key.size());
  return kTexts.substr(from, kTexts.find('\n', from) - from);
}

}  // namespace

std::string_view option_sentence(std::string_view owner, std::string_view option) {
  const std::string_view own = sentence(std::string(owner) + "." + std::string(option));
  return own.empty() ? sentence("*." + std::string(option)) : own;
}

std::string_view option_texts() { return kTexts; }

}  // namespace feder::lua
