// A strict reader of stubs: LuaCATS annotations as the Lua language server documents them
// (https://luals.github.io/wiki/annotations), and the empty functions below them. What is no such line is an error.
#pragma once
#include <map>
#include <string>
#include <vector>

namespace feder::test {

struct LuaType {
  enum class Form { name, literal, list, map, record, function, either };
  Form form = Form::name;
  std::string name = {};             // of a name; of a literal what it says: "ball", false
  std::vector<LuaType> parts = {};   // of a list its item, of a map key and value, of a function its results
  std::vector<LuaType> fields = {};  // of a record; of a function its parameters
  // As a field or a parameter:
  std::string label = {};
  bool optional = false;
};

using LuaSignatures = std::vector<LuaType>;  // of a function, its own first; `self` is no parameter

struct LuaClass {
  std::string parent = {};
  std::map<std::string, LuaType> fields = {};
  std::map<std::string, LuaSignatures> functions = {};
  LuaSignatures calls = {};               // of the thing itself
  std::vector<LuaType> by_position = {};  // of [integer]; none or one
};

struct LuaStubs {
  std::map<std::string, LuaClass> classes;
  std::map<std::string, LuaType> aliases;
  std::vector<std::string> errors;  // "line: what is wrong"
};

LuaStubs read_stubs(const std::string& text);
std::string to_text(const LuaType& type);

}  // namespace feder::test
