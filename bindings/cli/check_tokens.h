// Tokens of a Lua text.
#pragma once
#include <string>
#include <string_view>

namespace feder::cli {

enum class TokenKind { name, word, sign, string, number, end };

struct Token {
  TokenKind kind = TokenKind::end;
  std::string text = {};  // strings: what they say
  int line = 1;
  std::size_t offset = 0;  // of its first byte
};

class LuaTokens {
 public:
  explicit LuaTokens(std::string_view text);

  const Token& now() const { return now_; }
  const Token& next() const { return next_; }
  Token take();  // moves on by one

 private:
  Token read();
  void skip_blanks();
  char at(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }
  std::size_t long_bracket() const;  // length of "[[", "[=[" ... here; 0 for none
  std::string read_long(std::size_t open);
  std::string read_quoted();
  void read_escape(std::string& out);
  void read_number();

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
  Token now_, next_;
};

}  // namespace feder::cli
