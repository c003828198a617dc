// Recursive descent over Lua 5.4 (reference manual, section 9), with operator precedences as in its table. Names are
// resolved to variables on the way, as the compiler does it. Lua itself has compiled the text, which bounds how deep it
// nests.
#include "cli/check_tree.h"

#include <algorithm>
#include <stdexcept>

#include "cli/check_tokens.h"

namespace feder::cli {
namespace {

struct BinaryOperator {
  std::string_view sign;
  int left, right;  // binding powers
};
constexpr BinaryOperator kBinary[] = {
    {"or", 1, 1},  {"and", 2, 2}, {"<", 3, 3},   {">", 3, 3},   {"<=", 3, 3},  {">=", 3, 3},   {"~=", 3, 3},
    {"==", 3, 3},  {"|", 4, 4},   {"~", 5, 5},   {"&", 6, 6},   {"<<", 7, 7},  {">>", 7, 7},   {"..", 9, 8},
    {"+", 10, 10}, {"-", 10, 10}, {"*", 11, 11}, {"/", 11, 11}, {"%", 11, 11}, {"//", 11, 11}, {"^", 14, 13}};
constexpr int kUnary = 12;

class Parser {
 public:
  explicit Parser(std::string_view text) : tokens_(text) {}

  std::unique_ptr<LuaTree> parse() {
    block();
    if (now().kind != TokenKind::end) confused();
    return std::move(tree_);
  }

 private:
  using Nodes = std::vector<LuaNode*>;

  const Token& now() const { return tokens_.now(); }
  bool is(std::string_view text) const {
    return (now().kind == TokenKind::sign || now().kind == TokenKind::word) && now().text == text;
  }
  bool accept(std::string_view text) {
    if (!is(text)) return false;
    tokens_.take();
    return true;
  }
  void expect(std::string_view text) {
    if (!accept(text)) confused();
  }
  std::string name() {
    if (now().kind != TokenKind::name) confused();
    return tokens_.take().text;
  }
  [[noreturn]] void confused() const {
    throw std::runtime_error(std::to_string(now().line) + ": no Lua at '" + now().text + "'");
  }

  LuaNode* make(Syntax syntax, int line, std::string text = "") {
    tree_->nodes.push_back({.syntax = syntax, .line = line, .text = std::move(text), .function = function_});
    return &tree_->nodes.back();
  }
  void adopt(LuaNode* node, LuaNode* part) {
    node->parts.push_back(part);
    part->parent = node;
  }
  LuaNode* around(Syntax syntax, LuaNode* part) {
    LuaNode* node = make(syntax, part->line);
    adopt(node, part);
    return node;
  }

  // Scopes.
  LuaVariable* declare(std::string text) {
    tree_->variables.push_back({.name = std::move(text)});
    return &tree_->variables.back();
  }
  void see(LuaVariable* variable) { scope_.push_back(variable); }
  LuaNode* name_node(int line, const std::string& text) {
    LuaNode* node = make(Syntax::name, line, text);
    const auto found = std::find_if(scope_.rbegin(), scope_.rend(), [&](const auto* v) { return v->name == text; });
    if (found != scope_.rend()) {
      node->variable = *found;
    } else {
      LuaVariable*& global = tree_->globals[text];
      if (!global) global = declare(text), global->global = true;
      node->variable = global;
      node->visible.assign(scope_.begin(), scope_.end());
    }
    node->variable->uses.push_back(node);
    return node;
  }
  void give(LuaVariable* variable, const Nodes& values, std::size_t k) {
    variable->sources.push_back(source(values, k));
  }
  // The k-th of the values of a list: its last may have several results.
  static LuaSource source(const Nodes& values, std::size_t k) {
    if (values.empty()) return {};
    if (k < values.size()) return {values[k], 0};
    return {values.back(), k - values.size() + 1};
  }

  // Statements.
  bool at_end() const { return now().kind == TokenKind::end || is("end") || is("else") || is("elseif") || is("until"); }
  void block() {
    const std::size_t outer = scope_.size();
    statements();
    scope_.resize(outer);
  }
  void statements() {
    while (!at_end() && !is("return")) statement();
    if (is("return")) return_statement();
  }
  void return_statement() {
    tokens_.take();
    Nodes values;
    if (!at_end() && !is(";")) values = expressions();
    accept(";");
    LuaNode* const first = values.size() == 1 ? values[0] : nullptr;
    if (function_)
      function_->returns.push_back(first);
    else
      tree_->result = at_end() && now().kind == TokenKind::end ? first : tree_->result;
  }
  void statement() {
    if (accept(";") || accept("break")) return;
    if (accept("goto")) return static_cast<void>(name());
    if (accept("::")) return name(), expect("::");
    if (accept("do")) return block(), expect("end");
    if (accept("while")) return condition(), expect("do"), block(), expect("end");
    if (accept("if")) return if_statement();
    if (accept("repeat")) return repeat_statement();
    if (accept("for")) return for_statement();
    if (accept("function")) return function_statement();
    if (accept("local")) return local_statement();
    expression_statement();
  }
  void condition() { around(Syntax::test, expression()); }
  void if_statement() {
    condition(), expect("then"), block();
    while (accept("elseif")) condition(), expect("then"), block();
    if (accept("else")) block();
    expect("end");
  }
  void repeat_statement() {
    const std::size_t outer = scope_.size();
    statements();  // the condition sees their locals
    expect("until"), condition();
    scope_.resize(outer);
  }
  void for_statement() {
    std::vector<LuaVariable*> variables{declare(name())};
    if (accept("=")) {
      expressions();
      give(variables[0], {}, 0);
    } else {
      while (accept(",")) variables.push_back(declare(name()));
      expect("in");
      LuaNode* loop = make(Syntax::loop, now().line);
      for (LuaNode* value : expressions()) adopt(loop, value);
      for (std::size_t k = 0; k < variables.size(); ++k) variables[k]->sources.push_back({loop, k});
    }
    expect("do");
    const std::size_t outer = scope_.size();
    for (LuaVariable* v : variables) see(v);
    block(), expect("end");
    scope_.resize(outer);
  }
  void function_statement() {
    const int line = now().line;
    LuaNode* target = name_node(line, name());
    bool method = false;
    while (is(".") || is(":")) {
      method = tokens_.take().text == ":";
      target = around(Syntax::index, target);
      target->text = name();
    }
    assign({target}, {function_body(line, method)});
  }
  void local_statement() {
    if (accept("function")) {
      const int line = now().line;
      LuaVariable* variable = declare(name());
      see(variable);
      give(variable, {function_body(line, false)}, 0);
      return;
    }
    std::vector<LuaVariable*> variables;
    do {
      variables.push_back(declare(name()));
      if (accept("<")) name(), expect(">");
    } while (accept(","));
    Nodes values;
    if (accept("="))
      values = expressions();
    else
      values = {make(Syntax::nothing, now().line)};
    for (std::size_t k = 0; k < variables.size(); ++k) give(variables[k], values, k), see(variables[k]);
  }
  void expression_statement() {
    Nodes targets{suffixed()};
    while (accept(",")) targets.push_back(suffixed());
    if (accept("=")) assign(targets, expressions());
  }
  void assign(const Nodes& targets, const Nodes& values) {
    for (std::size_t k = 0; k < targets.size(); ++k) {
      targets[k]->assigned = true;
      if (targets[k]->syntax == Syntax::name)
        give(targets[k]->variable, values, k);
      else
        tree_->writes.emplace_back(targets[k], source(values, k));
    }
  }

  // Expressions.
  Nodes expressions() {
    Nodes all{expression()};
    while (accept(",")) all.push_back(expression());
    return all;
  }
  LuaNode* unary() {
    const Token& t = now();
    const bool sign = t.kind == TokenKind::sign && (t.text == "-" || t.text == "#" || t.text == "~");
    if (!sign && !is("not")) return simple();
    const Syntax syntax = is("not") ? Syntax::test : Syntax::other;
    std::string text = tokens_.take().text;
    LuaNode* const whole = around(syntax, expression(kUnary));
    whole->text = std::move(text);
    return whole;
  }
  LuaNode* expression(int least = 0) {
    LuaNode* left = unary();
    for (;;) {
      const auto op = std::ranges::find_if(kBinary, [&](const BinaryOperator& o) { return is(o.sign); });
      if (op == std::end(kBinary) || op->left <= least) return left;
      const bool asks = op->sign == "and" || op->sign == "or" || op->sign == "==" || op->sign == "~=";
      LuaNode* whole = make(asks ? Syntax::test : Syntax::other, tokens_.take().line, std::string(op->sign));
      adopt(whole, left);
      adopt(whole, expression(op->right));
      left = whole;
    }
  }
  LuaNode* simple() {
    const Token& t = now();
    if (t.kind == TokenKind::string) return string();
    if (t.kind == TokenKind::number || is("true") || is("false") || is("...")) {
      const int line = t.line;
      return make(Syntax::other, line, tokens_.take().text);
    }
    if (is("nil")) return make(Syntax::nothing, tokens_.take().line);
    if (is("{")) return table();
    if (is("function")) {
      const int line = tokens_.take().line;
      return function_body(line, false);
    }
    return suffixed();
  }
  LuaNode* string() {
    const Token t = tokens_.take();
    return make(Syntax::string, t.line, t.text);
  }
  LuaNode* suffixed() {
    LuaNode* base = nullptr;
    if (accept("(")) {
      base = expression();
      expect(")");
    } else {
      const int line = now().line;
      base = name_node(line, name());
    }
    while (LuaNode* longer = suffix(base)) base = longer;
    return base;
  }
  LuaNode* suffix(LuaNode* base) {
    const int line = now().line;
    if (is(".") || is("[")) {
      const bool dot = tokens_.take().text == ".";
      LuaNode* node = make(Syntax::index, now().line);
      adopt(node, base);
      if (dot)
        node->text = name();
      else
        key(node), expect("]");
      return node;
    }
    if (accept(":")) {
      LuaNode* node = make(Syntax::method, now().line);
      adopt(node, base);
      node->text = name();
      return arguments(node);
    }
    if (!is("(") && !is("{") && now().kind != TokenKind::string) return nullptr;
    LuaNode* node = make(Syntax::call, line);
    adopt(node, base);
    return arguments(node);
  }
  LuaNode* arguments(LuaNode* node) {
    if (now().kind == TokenKind::string) {
      adopt(node, string());
    } else if (is("{")) {
      adopt(node, table());
    } else {
      expect("(");
      if (!is(")"))
        for (LuaNode* value : expressions()) adopt(node, value);
      expect(")");
    }
    return node;
  }
  // A key in brackets.
  void key(LuaNode* node) {
    LuaNode* const inside = expression();
    if (inside->syntax == Syntax::string && !inside->text.empty()) node->text = inside->text;
    adopt(node, inside);
  }
  LuaNode* table() {
    LuaNode* node = make(Syntax::table, now().line);
    expect("{");
    while (!is("}")) {
      LuaNode* entry = make(Syntax::entry, now().line);
      adopt(node, entry);
      LuaNode* bracket = nullptr;
      if (now().kind == TokenKind::name && tokens_.next().kind == TokenKind::sign && tokens_.next().text == "=") {
        entry->text = name();
        expect("=");
      } else if (accept("[")) {
        bracket = make(Syntax::other, now().line);
        key(bracket), expect("]"), expect("=");
        entry->text = bracket->text;
      }
      adopt(entry, expression());
      if (bracket) adopt(entry, bracket);
      if (!accept(",")) accept(";");
    }
    expect("}");
    return node;
  }
  LuaNode* function_body(int line, bool method) {
    LuaNode* node = make(Syntax::function, line);
    LuaNode* const outer_function = function_;
    const std::size_t outer = scope_.size();
    function_ = node;
    if (method) parameter(node, "self");
    expect("(");
    while (!accept(")")) {
      if (!accept("...")) parameter(node, name());
      accept(",");
    }
    block(), expect("end");
    scope_.resize(outer);
    function_ = outer_function;
    return node;
  }
  void parameter(LuaNode* function, const std::string& text) {
    LuaVariable* variable = declare(text);
    variable->function = function;
    variable->parameter = function->parameters.size();
    function->parameters.push_back(variable);
    see(variable);
  }

  LuaTokens tokens_;
  std::unique_ptr<LuaTree> tree_ = std::make_unique<LuaTree>();
  LuaNode* function_ = nullptr;
  std::vector<LuaVariable*> scope_;
};

}  // namespace

std::unique_ptr<LuaTree> parse_lua(std::string_view text) { return Parser(text).parse(); }

}  // namespace feder::cli
