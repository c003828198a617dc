// A formula in x y z vx vy vz m t and named parameters, parsed once and evaluated often:
//   + - * / ^ (right to left), sin cos exp log pow sqrt abs min max, pi, numbers, parentheses.
// Values in double by functions of feder/types.h, so that they do not depend on the C library; derivatives by the same
// program on dual numbers (forward mode; Griewank & Walther 2008, 3). Where an operation has no value (division by
// zero, logarithm or root of a negative number, overflow) the formula has none.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace feder {

class Expression {
 public:
  // Places of the variables: x y z vx vy vz m t.
  static constexpr int kVariables = 8;
  static constexpr int kVelocity = 3;  // first of three; positions begin at 0
  static constexpr int kMaxDepth = 64;

  using Parameter = std::pair<std::string, double>;

  // SceneError with the column, counted from 1.
  Expression(std::string_view text, std::span<const Parameter> parameters);

  const std::string& text() const { return text_; }
  bool uses(int variable) const { return (used_ >> variable & 1) != 0; }

  // False: it has no value there; `out` is not touched.
  bool value(const double (&variables)[kVariables], double& out) const;
  // The value's derivatives by variables first .. first + 2.
  bool gradient(const double (&variables)[kVariables], int first, double (&out)[3]) const;

 private:
  friend class ExpressionParser;

  enum class Op : unsigned char {
    constant,
    variable,  // push
    negate,
    sine,
    cosine,
    exponential,
    logarithm,
    root,
    absolute,
    whole_power,  // one operand
    add,
    subtract,
    multiply,
    divide,
    power,
    least,
    largest  // two
  };
  struct Instruction {
    Op op;
    int at = 0;        // variable, or the whole exponent
    double value = 0;  // constant
  };

  template <class Number>
  bool run(const Number* variables, Number& out) const;

  std::string text_;
  std::vector<Instruction> program_;  // postfix
  unsigned used_ = 0;                 // bit per variable
};

}  // namespace feder
