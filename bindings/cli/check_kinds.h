// Kinds of values by what a script does, without running it: a local that is made by world:body{} is a body, the first
// parameter of build a world. A variable with values of two kinds, or one that nobody knows, has none: then nothing is
// said about it.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "cli/check_names.h"
#include "cli/check_tree.h"

namespace feder::cli {

struct Kind {
  std::string name;      // "": no value yet; kUnknown; a class, "feder", "library string", "module x", "scene"
  Words events = {};     // of an event: which it may be
  bool own = false;      // an event in a handler of an object
  bool list = false;     // a list of such things
  bool guessed = false;  // by the name of a parameter alone

  static constexpr const char* kUnknown = "?";
  bool known() const { return !name.empty() && name != kUnknown; }
  bool operator==(const Kind&) const = default;
};

class Kinds {
 public:
  Kinds(const ScriptNames& names, const LuaTree& tree, std::filesystem::path folder);

  Kind of(const LuaNode* value, std::size_t result = 0);
  // The row of the function that is called; null when unknown. `receiver`: kind of the object or module.
  const lua::DocRow* row_of(const LuaNode* call, Kind* receiver = nullptr);
  // The options that a table constructor gives; null when unknown. `owner`: who reads them, for messages.
  const std::vector<OptionInfo>* options_of(const LuaNode* table, std::string* owner = nullptr);
  // The module of `require "x"`; "" for other calls, and where it is not a constant.
  std::string required(const LuaNode* call) const;
  // What a module has; null: not known.
  const Words* exports(const std::string& module);

 private:
  using Rows = std::vector<OptionInfo>;

  // What may hold a list: a local, or a field of the scene.
  struct Place {
    const LuaVariable* variable = nullptr;
    std::string field = {};
    explicit operator bool() const { return variable || !field.empty(); }
    auto operator<=>(const Place&) const = default;
  };

  bool find_all();
  Kind find(const LuaNode* value, std::size_t result);
  Kind find_variable(const LuaVariable* variable);
  std::map<Place, Kind> find_elements();
  Kind of_variable(const LuaVariable* variable) const;
  Kind of_parameter(const LuaVariable* variable);
  Kind of_call(const LuaNode* call, std::size_t result);
  Kind of_index(const LuaNode* index);
  Kind of_loop(const LuaNode* loop, std::size_t result);
  // What a function gets as its k-th parameter where it stands as a value: a handler, an option.
  Kind passed(const LuaNode* function, const LuaNode* place, std::size_t k);
  Kind event_of(const LuaNode* call, const lua::DocRow& row, const Kind& receiver) const;
  Place place_of(const LuaNode* node);
  Kind element(const LuaNode* list);
  Kind elements_in(const LuaSource& source);
  bool reads(const LuaNode* use) const;
  const OptionInfo* option_row(const LuaNode* entry, std::string* owner = nullptr);
  const Rows* options_of_entry(const LuaNode* entry, std::string* owner);
  const Rows* options_of_argument(const LuaNode* call, const LuaNode* table, std::string* owner);

  static constexpr int kMaxRounds = 100;

  const ScriptNames& names_;
  const LuaTree& tree_;
  std::filesystem::path folder_;
  bool uses_feder_ = false;
  bool gave_up_ = false;                                 // too many rounds: nothing is known
  std::map<const LuaNode*, const LuaVariable*> holder_;  // of values that a variable is given
  // As far as the rounds have come.
  std::map<const LuaVariable*, Kind> variables_;
  std::map<const LuaNode*, Kind> returned_;  // by functions
  std::map<std::string, Kind> fields_;       // of the scene
  std::map<Place, Kind> elements_;
  std::map<std::pair<const LuaNode*, std::size_t>, Kind> known_;  // in this round
  bool waits_ = false;                                            // row_of has met a value without a kind yet
  std::map<std::string, std::pair<bool, Words>> exports_;
};

// The kind of a value that may be either.
Kind join(const Kind& a, const Kind& b);

}  // namespace feder::cli
