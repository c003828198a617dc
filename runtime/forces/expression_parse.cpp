// Recursive descent into postfix. sum = product {(+|-) product}; product = signed {(*|/) signed}; signed = {+|-}
// raised; raised = atom [^ signed], so -x^2 is -(x^2) and 2^-1 reads; atom = number, name, name(arguments), (sum).
// Weak spot: recursion, therefore the limits on nesting and on values in flight.
#include <charconv>
#include <cmath>

#include "feder/error.h"
#include "feder/params.h"
#include "forces/expression.h"

namespace feder {
namespace {

constexpr const char* kVariableNames[] = {"x", "y", "z", "vx", "vy", "vz", "m", "t"};
constexpr double kPiDouble = 3.14159265358979323846;
constexpr int kMaxWhole = 64;     // exponents up to here are products
constexpr int kMaxNesting = 100;  // of parentheses, signs and powers

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

}  // namespace

class ExpressionParser {
 public:
  ExpressionParser(Expression& out, std::string_view text, std::span<const Expression::Parameter> parameters)
      : out_(out), text_(text), parameters_(parameters) {}

  void parse() {
    for (const auto& [name, value] : parameters_) check_parameter(name, value);
    sum();
    if (at_ < text_.size()) expected("an operator or the end");
  }

 private:
  using Op = Expression::Op;

  struct Function {
    const char* name;
    Op op;
    int arguments;
  };
  static constexpr Function kFunctions[] = {
      {"sin", Op::sine, 1},      {"cos", Op::cosine, 1}, {"exp", Op::exponential, 1},
      {"log", Op::logarithm, 1}, {"sqrt", Op::root, 1},  {"abs", Op::absolute, 1},
      {"pow", Op::power, 2},     {"min", Op::least, 2},  {"max", Op::largest, 2}};

  void check_parameter(const std::string& name, double value) const {
    bool taken = name == "pi" || name.empty() || !is_letter(name[0]);
    for (const char c : name) taken = taken || !(is_letter(c) || is_digit(c));
    for (const char* v : kVariableNames) taken = taken || name == v;
    for (const Function& f : kFunctions) taken = taken || name == f.name;
    if (taken) throw SceneError("params: expected a name that is no variable or function, got '" + name + "'");
    if (!std::isfinite(value)) throw SceneError("params." + name + ": expected a finite number");
  }

  void skip() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n')) ++at_;
  }
  bool take(char c) {
    skip();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  [[noreturn]] void fail(std::size_t at, const std::string& what) const {
    throw SceneError("column " + std::to_string(at + 1) + " of '" + std::string(text_) + "': " + what);
  }
  [[noreturn]] void expected(const std::string& what) {
    skip();
    fail(at_, "expected " + what + ", got " +
                  (at_ < text_.size() ? "'" + std::string(1, text_[at_]) + "'" : std::string("the end")));
  }

  void emit(Op op, int pops, int at = 0, double value = 0) {
    depth_ += 1 - pops;
    if (depth_ > Expression::kMaxDepth) fail(at_, "expected at most 64 values in flight; use fewer parentheses");
    out_.program_.push_back({op, at, value});
  }

  void enter() {
    if (++nesting_ > kMaxNesting) fail(at_, "expected at most 100 nested parts");
  }

  void sum() {
    enter();
    product();
    for (;;) {
      if (take('+'))
        product(), emit(Op::add, 2);
      else if (take('-'))
        product(), emit(Op::subtract, 2);
      else
        break;
    }
    --nesting_;
  }

  void product() {
    signed_part();
    for (;;) {
      if (take('*'))
        signed_part(), emit(Op::multiply, 2);
      else if (take('/'))
        signed_part(), emit(Op::divide, 2);
      else
        break;
    }
  }

  void signed_part() {
    enter();
    if (take('-'))
      signed_part(), emit(Op::negate, 1);
    else if (take('+'))
      signed_part();
    else
      raised();
    --nesting_;
  }

  void raised() {
    atom();
    if (!take('^')) return;
    const std::size_t first = out_.program_.size();
    signed_part();
    raise(first);
  }

  // The exponent is the program from `first` on: a whole number there becomes a product.
  void raise(std::size_t first) {
    auto& p = out_.program_;
    const bool negative = p.size() == first + 2 && p[first + 1].op == Op::negate;
    const bool constant = p[first].op == Op::constant && (p.size() == first + 1 || negative);
    const double n = constant ? (negative ? -p[first].value : p[first].value) : 0.5;
    if (n != std::floor(n) || std::fabs(n) > kMaxWhole) return emit(Op::power, 2);
    p.resize(first);
    --depth_;
    emit(Op::whole_power, 1, static_cast<int>(n));
  }

  void atom() {
    skip();
    if (take('(')) {
      sum();
      if (!take(')')) expected("')'");
    } else if (at_ < text_.size() && (is_digit(text_[at_]) || text_[at_] == '.')) {
      number();
    } else if (at_ < text_.size() && is_letter(text_[at_])) {
      name();
    } else {
      expected("a number, a name or '('");
    }
  }

  void number() {
    double value = 0;
    const char* const begin = text_.data() + at_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
    if (error != std::errc() || !std::isfinite(value)) fail(at_, "expected a number");
    at_ += static_cast<std::size_t>(end - begin);
    emit(Op::constant, 0, 0, value);
  }

  void name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    const std::string word(text_.substr(begin, at_ - begin));
    for (const Function& f : kFunctions)
      if (word == f.name) return call(f);
    for (int k = 0; k < Expression::kVariables; ++k)
      if (word == kVariableNames[k]) {
        out_.used_ |= 1u << k;
        return emit(Op::variable, 0, k);
      }
    for (const auto& [given, value] : parameters_)
      if (word == given) return emit(Op::constant, 0, 0, value);
    if (word == "pi") return emit(Op::constant, 0, 0, kPiDouble);
    unknown(word, begin);
  }

  void call(const Function& f) {
    if (!take('(')) expected("'(' after " + std::string(f.name));
    const std::size_t first = out_.program_.size();
    sum();
    std::size_t second = first;
    if (f.arguments == 2) {
      if (!take(',')) expected("',' and a second argument of " + std::string(f.name));
      second = out_.program_.size();
      sum();
    }
    if (!take(')')) expected("')' after the arguments of " + std::string(f.name));
    if (f.op == Op::power) return raise(second);
    emit(f.op, f.arguments);
  }

  [[noreturn]] void unknown(const std::string& word, std::size_t at) const {
    std::vector<std::string> known(std::begin(kVariableNames), std::end(kVariableNames));
    for (const Function& f : kFunctions) known.emplace_back(f.name);
    for (const auto& [given, value] : parameters_) known.push_back(given);
    const std::string near = nearest_name(word, known);
    fail(at,
         "unknown name '" + word + "'" +
             (near.empty() ? "; known: x y z vx vy vz m t, params and functions" : "; did you mean '" + near + "'?"));
  }

  Expression& out_;
  std::string_view text_;
  std::span<const Expression::Parameter> parameters_;
  std::size_t at_ = 0;
  int depth_ = 0, nesting_ = 0;
};

Expression::Expression(std::string_view text, std::span<const Parameter> parameters) : text_(text) {
  ExpressionParser(*this, text_, parameters).parse();
}

}  // namespace feder
