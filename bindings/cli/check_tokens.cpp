// Lexical analysis of Lua 5.4 (reference manual, section 3.1). What is no Lua is never seen here: the text has been
// compiled before.
#include "cli/check_tokens.h"

#include <algorithm>
#include <array>

namespace feder::cli {
namespace {

constexpr std::array<std::string_view, 22> kWords = {
    "and", "break", "do",  "else", "elseif", "end",    "false",  "for",  "function", "goto",  "if",
    "in",  "local", "nil", "not",  "or",     "repeat", "return", "then", "true",     "until", "while"};
constexpr std::array<std::string_view, 10> kLongSigns = {"...", "<<", ">>", "//", "==", "~=", "<=", ">=", "::", ".."};

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return c == '_' || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_hex(char c) { return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F'); }

}  // namespace

LuaTokens::LuaTokens(std::string_view text) : text_(text) {
  // a mark of UTF-8 and a #! line belong to other programs
  if (text_.substr(0, 3) == "\xef\xbb\xbf") at_ = 3;
  if (at() == '#') at_ = std::min(text_.find('\n', at_), text_.size());
  take(), take();
}

Token LuaTokens::take() {
  Token taken = std::move(now_);
  now_ = std::move(next_);
  next_ = read();
  return taken;
}

std::size_t LuaTokens::long_bracket() const {
  if (at() != '[') return 0;
  std::size_t length = 1;
  while (at(length) == '=') ++length;
  return at(length) == '[' ? length + 1 : 0;
}

std::string LuaTokens::read_long(std::size_t open) {
  std::string close(open, '=');  // as long as the opening one
  close.front() = close.back() = ']';
  const std::size_t from = at_ + open, end = std::min(text_.find(close, from), text_.size());
  std::string out(text_.substr(from, end - from));
  line_ += static_cast<int>(std::count(out.begin(), out.end(), '\n'));
  at_ = std::min(end + open, text_.size());
  if (!out.empty() && out.front() == '\n') out.erase(0, 1);
  return out;
}

void LuaTokens::skip_blanks() {
  for (;;) {
    if (at() == '-' && at(1) == '-') {
      at_ += 2;
      if (const std::size_t open = long_bracket())
        read_long(open);
      else
        at_ = std::min(text_.find('\n', at_), text_.size());
    } else if (at() == '\n') {
      ++line_, ++at_;
    } else if (at() == ' ' || (at() >= '\t' && at() <= '\r')) {
      ++at_;
    } else {
      return;
    }
  }
}

// Behind the backslash. Bytes by number are left as they are written: no name has them.
void LuaTokens::read_escape(std::string& out) {
  const char c = at();
  ++at_;
  if (c == '\n') ++line_;
  if (c == 'z') {
    while (at() == ' ' || (at() >= '\t' && at() <= '\r')) {
      line_ += at() == '\n';
      ++at_;
    }
    return;
  }
  if (c == 'x' || c == 'u' || is_digit(c)) out += '\\';
  out += c;
}

std::string LuaTokens::read_quoted() {
  const char quote = at();
  std::string out;
  for (++at_; at_ < text_.size() && at() != quote;) {
    const char c = at();
    ++at_;
    if (c == '\\')
      read_escape(out);
    else
      out += c;
  }
  ++at_;
  return out;
}

void LuaTokens::read_number() {
  const bool hex = at() == '0' && (at(1) == 'x' || at(1) == 'X');
  if (hex) at_ += 2;
  for (;; ++at_) {
    const char c = at();
    const bool exponent = hex ? c == 'p' || c == 'P' : c == 'e' || c == 'E';
    if (exponent && (at(1) == '+' || at(1) == '-')) ++at_;
    if (!exponent && !is_hex(c) && c != '.') return;
  }
}

Token LuaTokens::read() {
  skip_blanks();
  Token token{.line = line_, .offset = at_};
  if (at_ >= text_.size()) return token;
  const std::size_t from = at_;
  if (is_letter(at())) {
    while (is_letter(at()) || is_digit(at())) ++at_;
    token.text = text_.substr(from, at_ - from);
    token.kind = std::ranges::find(kWords, token.text) != kWords.end() ? TokenKind::word : TokenKind::name;
  } else if (is_digit(at()) || (at() == '.' && is_digit(at(1)))) {
    read_number();
    token.kind = TokenKind::number, token.text = text_.substr(from, at_ - from);
  } else if (const std::size_t open = long_bracket()) {
    token.kind = TokenKind::string, token.text = read_long(open);
  } else if (at() == '"' || at() == '\'') {
    token.kind = TokenKind::string, token.text = read_quoted();
  } else {
    std::size_t length = 1;
    for (std::string_view sign : kLongSigns)
      if (text_.substr(at_, sign.size()) == sign) length = std::max(length, sign.size());
    token.kind = TokenKind::sign, token.text = text_.substr(at_, length);
    at_ += length;
  }
  return token;
}

}  // namespace feder::cli
