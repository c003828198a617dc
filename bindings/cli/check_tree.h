// Syntax tree of a Lua text, as far as a check of names needs it: expressions, what each name stands for, and which
// values a variable may have. Statements leave no nodes of their own.
#pragma once
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace feder::cli {

struct LuaVariable;

enum class Syntax {
  name,      // text; variable
  index,     // base, [key]; text is the key when it is a constant name
  call,      // function, arguments
  method,    // object, arguments; text is the method's name
  table,     // entries
  entry,     // value, [key]; text is the key when it is a constant name; neither: by position
  function,  // parameters, returns
  string,    // text
  nothing,   // nil
  loop,      // the list of a generic for: its variables are results of this
  test,      // operand of and, or, not, ==, ~=, or a condition: asks whether there is such a thing
  other,     // operands; text is the operator; without operands a number, true, false or ...
};

struct LuaNode {
  Syntax syntax = Syntax::other;
  int line = 0;
  std::string text = {};
  std::vector<LuaNode*> parts = {};
  LuaNode* parent = nullptr;
  bool assigned = false;                         // it is the target of an assignment
  LuaVariable* variable = nullptr;               // of a name; globals have one too
  std::vector<LuaVariable*> parameters = {};     // of a function, `self` of function a:b() included
  std::vector<LuaNode*> returns = {};            // of a function: first value of each return; null for none or several
  LuaNode* function = nullptr;                   // that it stands in; null in the main chunk
  std::vector<const LuaVariable*> visible = {};  // of the name of a global: locals there
};

// A value that an assignment gives: the result-th (from 0) of an expression; null: unknown.
struct LuaSource {
  LuaNode* value = nullptr;
  std::size_t result = 0;
};

struct LuaVariable {
  std::string name;
  bool global = false;
  LuaNode* function = nullptr;  // whose parameter it is
  std::size_t parameter = 0;
  std::vector<LuaSource> sources = {};
  std::vector<LuaNode*> uses = {};  // all names that mean it
};

struct LuaTree {
  std::deque<LuaNode> nodes;  // in the order of their beginnings
  std::deque<LuaVariable> variables;
  std::map<std::string, LuaVariable*, std::less<>> globals;
  // Places in tables that are assigned: `a.b = value`.
  std::vector<std::pair<LuaNode*, LuaSource>> writes;
  LuaNode* result = nullptr;  // what the main chunk returns at its end
};

// `text` has been compiled by Lua already: what is no Lua has no meaning here. std::runtime_error where it is none.
std::unique_ptr<LuaTree> parse_lua(std::string_view text);

}  // namespace feder::cli
