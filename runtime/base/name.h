// A word of a family that modules may add to ("cloth" among the kinds of objects): a constant in the header of who
// brings it. Equal texts are equal words, so nothing depends on what else a build holds.
#pragma once
#include <string_view>

namespace feder {

template <class Family>
class Name {
 public:
  // `text` lives as long as the program.
  explicit constexpr Name(const char* text) : text_(text) {}
  constexpr const char* text() const { return text_; }
  friend constexpr bool operator==(const Family& x, const Family& y) {
    return x.text() == y.text() || std::string_view(x.text()) == y.text();
  }
  friend constexpr bool operator<(const Family& x, const Family& y) {
    return x.text() != y.text() && std::string_view(x.text()) < y.text();
  }

 private:
  const char* text_;
};

}  // namespace feder
