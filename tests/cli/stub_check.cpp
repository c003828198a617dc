#include "cli/stub_check.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>

#include "cli/check_tree.h"

namespace feder::test {
namespace {

using cli::LuaNode;
using cli::LuaTree;
using cli::LuaVariable;
using cli::Syntax;
using Form = LuaType::Form;
using Known = std::optional<LuaType>;

LuaType named(std::string name) { return {.name = std::move(name)}; }

bool is_feder(const LuaNode& call) {
  return call.syntax == Syntax::call && call.parts[0]->syntax == Syntax::name && call.parts[0]->text == "require" &&
         call.parts.size() == 2 && call.parts[1]->syntax == Syntax::string && call.parts[1]->text.starts_with("feder");
}

// What strings answer to, and what they return.
const std::map<std::string, LuaType>& string_methods() {
  static const std::map<std::string, LuaType> all = {
      {"format", named("string")}, {"rep", named("string")},   {"gsub", named("string")}, {"sub", named("string")},
      {"lower", named("string")},  {"upper", named("string")}, {"match", named("any")},   {"gmatch", named("any")},
      {"find", named("any")},      {"byte", named("any")},     {"len", named("integer")}, {"reverse", named("string")}};
  return all;
}

class Checker {
 public:
  Checker(const LuaTree& tree, const LuaStubs& stubs, std::filesystem::path libraries)
      : tree_(tree), stubs_(stubs), libraries_(std::move(libraries)) {}

  StubFindings run() {
    for (const LuaNode& node : tree_.nodes) {
      if (is_feder(node)) continue;
      if (node.syntax == Syntax::call || node.syntax == Syntax::method) check_call(node);
      if (node.syntax == Syntax::index) check_index(node);
    }
    return std::move(out_);
  }

 private:
  void say(const LuaNode& node, const std::string& what) {
    out_.errors.push_back(std::to_string(node.line) + ": " + what);
  }

  // Classes and their functions.
  const LuaClass* class_of(const Known& type) const {
    const auto found = type && type->form == Form::name ? stubs_.classes.find(type->name) : stubs_.classes.end();
    return found == stubs_.classes.end() ? nullptr : &found->second;
  }
  const LuaSignatures* function(const LuaClass* of, const std::string& name) const {
    for (; of; of = class_of(named(of->parent)))
      if (const auto found = of->functions.find(name); found != of->functions.end()) return &found->second;
    return nullptr;
  }
  const LuaType* field(const LuaClass* of, const std::string& name) const {
    for (; of; of = class_of(named(of->parent)))
      if (const auto found = of->fields.find(name); found != of->fields.end()) return &found->second;
    return nullptr;
  }
  bool is_a(std::string name, const std::string& base) const {
    if (const auto alias = stubs_.aliases.find(base); alias != stubs_.aliases.end())
      return std::ranges::any_of(alias->second.parts, [&](const LuaType& one) { return is_a(name, one.name); });
    if (const auto alias = stubs_.aliases.find(name); alias != stubs_.aliases.end())
      return std::ranges::any_of(alias->second.parts, [&](const LuaType& one) { return is_a(one.name, base); });
    while (name != base && stubs_.classes.count(name)) name = stubs_.classes.at(name).parent;
    return name == base;
  }

  // A module of the libraries: its functions with as many optional parameters as they have.
  const LuaClass* module(const std::string& name) {
    const auto [at, fresh] = modules_.try_emplace(name);
    if (!fresh) return &at->second;
    std::string path = name;
    std::ranges::replace(path, '.', '/');
    std::ifstream in(libraries_ / (path + ".lua"));
    std::ostringstream text;
    text << in.rdbuf();
    const auto tree = cli::parse_lua(text.str());
    if (!tree->result || tree->result->syntax != Syntax::name) return &at->second;
    for (const auto& [target, source] : tree->writes) {
      const LuaNode& base = *target->parts[0];
      if (base.syntax != Syntax::name || base.variable != tree->result->variable) continue;
      if (!source.value || source.value->syntax != Syntax::function) {
        at->second.fields[target->text] = named("any");
        continue;
      }
      LuaType made{.form = Form::function, .parts = {named("any")}};
      for (const LuaVariable* p : source.value->parameters)
        made.fields.push_back({.name = "any", .label = p->name, .optional = true});
      at->second.functions[target->text] = {std::move(made)};
    }
    return &at->second;
  }
  const LuaClass* module_of(const LuaNode& node) {
    if (node.syntax != Syntax::name || node.variable->sources.size() != 1) return nullptr;
    const LuaNode* const value = node.variable->sources[0].value;
    return value && is_feder(*value) && value->parts[1]->text != "feder" ? module(value->parts[1]->text) : nullptr;
  }

  // Types of expressions; nothing where they are not known.
  Known type_of(const LuaNode& node, std::size_t result = 0) {
    if (depth_ > 50) return {};
    ++depth_;
    Known type = find_type(node, result);
    --depth_;
    if (type && type->form == Form::name && type->name == "any") return {};
    return type;
  }
  Known find_type(const LuaNode& node, std::size_t result) {
    switch (node.syntax) {
      case Syntax::string: return LuaType{.form = Form::literal, .name = '"' + node.text + '"'};
      case Syntax::function: return named("function");
      case Syntax::table: return named("table");
      case Syntax::name: return type_of_variable(*node.variable);
      case Syntax::index: return type_of_index(node);
      case Syntax::call:
      case Syntax::method: return type_of_call(node, result);
      case Syntax::loop: return type_of_loop(node, result);
      case Syntax::test: return node.text == "and" || node.text == "or" ? Known{} : named("boolean");
      case Syntax::other: return type_of_operator(node);
      default: return {};
    }
  }
  Known type_of_operator(const LuaNode& node) {
    if (node.parts.empty()) {
      if (node.text == "...") return {};
      if (node.text == "true" || node.text == "false") return LuaType{.form = Form::literal, .name = node.text};
      return named(node.text.find_first_of(".eEpP") == std::string::npos || node.text[1] == 'x' ? "integer" : "number");
    }
    if (node.text == "..") return named("string");
    if (node.text == "<" || node.text == ">" || node.text == "<=" || node.text == ">=") return named("boolean");
    if (node.text == "#") return named("integer");
    return node.parts.size() == 1 ? type_of(*node.parts[0]) : Known(named("number"));
  }
  Known type_of_variable(const LuaVariable& v) {
    if (const auto bound = parameters_.find(&v); bound != parameters_.end()) return bound->second;
    if (v.function && v.name == "world" && v.sources.empty()) return named("feder.World");
    if (v.sources.size() != 1 || !v.sources[0].value || v.function || v.global) return {};
    const LuaNode& value = *v.sources[0].value;
    return is_feder(value) ? Known(named(value.parts[1]->text)) : type_of(value, v.sources[0].result);
  }
  Known type_of_index(const LuaNode& node) {
    const Known base = type_of(*node.parts[0]);
    if (base && base->form == Form::list) return base->parts[0];
    if (const LuaType* f = field(class_of(base), node.text)) return *f;
    // a field of the scene: what the script puts there, if that is one thing
    if (!base || node.text.empty() || base->form != Form::name || base->name != "table") return {};
    Known type;
    for (const auto& [target, source] : tree_.writes) {
      const bool same = target->text == node.text && target->parts[0]->syntax == Syntax::name &&
                        node.parts[0]->syntax == Syntax::name && target->parts[0]->text == node.parts[0]->text;
      if (!same || !source.value) continue;
      const Known one = type_of(*source.value, source.result);
      if (!one || (type && to_text(*type) != to_text(*one))) return {};
      type = one;
    }
    return type;
  }
  Known type_of_call(const LuaNode& node, std::size_t result) {
    if (node.syntax == Syntax::method) {
      const Known base = type_of(*node.parts[0]);
      const auto own = string_methods().find(node.text);
      if (base && to_text(*base)[0] == '"' && own != string_methods().end()) return own->second;
    }
    const LuaSignatures* const called = signatures(node);
    if (!called) return {};
    const LuaType* const fits = matching(node, *called);
    const LuaType& signature = fits ? *fits : called->front();
    return result < signature.parts.size() ? Known(signature.parts[result]) : Known{};
  }
  Known type_of_loop(const LuaNode& loop, std::size_t result) {
    if (loop.parts.empty()) return {};
    const LuaNode& list = *loop.parts[0];
    const bool ipairs =
        list.syntax == Syntax::call && list.parts[0]->syntax == Syntax::name && list.parts[0]->text == "ipairs";
    if (ipairs && list.parts.size() == 2) {
      const Known of = type_of(*list.parts[1]);
      if (result == 0) return named("integer");
      return of && of->form == Form::list ? Known(of->parts[0]) : Known{};
    }
    const Known iterator = type_of(list);
    if (!iterator || iterator->form != Form::function || result >= iterator->parts.size()) return {};
    return iterator->parts[result];
  }

  // What is called; null where nobody knows.
  const LuaSignatures* signatures(const LuaNode& call) {
    if (call.syntax == Syntax::method) {
      const Known base = type_of(*call.parts[0]);
      return base ? method_of(*base, call) : nullptr;
    }
    const LuaNode& callee = *call.parts[0];
    if (callee.syntax == Syntax::index) {
      const LuaClass* const of = module_of(*callee.parts[0]);
      return function(of ? of : class_of(type_of(*callee.parts[0])), callee.text);
    }
    const LuaClass* const thing = class_of(type_of(callee));
    return thing && !thing->calls.empty() ? &thing->calls : nullptr;
  }

  // Of a class; of several the one that the arguments fit.
  const LuaSignatures* method_of(const LuaType& type, const LuaNode& call) {
    if (const auto alias = stubs_.aliases.find(type.name); type.form == Form::name && alias != stubs_.aliases.end())
      return method_of(alias->second, call);
    if (type.form != Form::either) return function(class_of(type), call.text);
    const LuaSignatures* any = nullptr;
    for (const LuaType& one : type.parts) {
      const LuaSignatures* const called = method_of(one, call);
      if (called && (!any || matching(call, *called))) any = called;
    }
    return any;
  }

  void check_call(const LuaNode& call) {
    if (const LuaSignatures* called = signatures(call)) {
      ++out_.calls, ++out_.typed;
      const std::string error = mismatch(call, *called);
      if (!error.empty()) say(call, error);
    } else if (call.syntax == Syntax::method) {
      check_method(call);
    }
  }

  // A method: of a class that lacks it, or of who knows what.
  void check_method(const LuaNode& call) {
    const Known base = type_of(*call.parts[0]);
    const std::string of = base ? to_text(*base) : "";
    if (of.starts_with("feder.")) return say(call, of + " has no method " + call.text);
    if (string_methods().count(call.text) || made_here(call.text)) return;
    std::string error = "no class has a method " + call.text;
    for (const auto& [name, c] : stubs_.classes) {
      const LuaSignatures* const called = function(&c, call.text);
      if (!called) continue;
      error = mismatch(call, *called);
      if (!error.empty()) continue;
      ++out_.calls;
      return;
    }
    say(call, error);
  }
  bool made_here(const std::string& name) const {
    return std::ranges::any_of(tree_.writes, [&](const auto& w) { return w.first->text == name; }) ||
           std::ranges::any_of(tree_.nodes, [&](const LuaNode& n) {
             return n.syntax == Syntax::entry && n.text == name && n.parts[0]->syntax == Syntax::function;
           });
  }

  // Fields of modules, and of what has a class.
  void check_index(const LuaNode& node) {
    if (node.text.empty()) return;
    const LuaClass* const library = module_of(*node.parts[0]);
    const Known base = type_of(*node.parts[0]);
    const LuaClass* const of = library ? library : class_of(base);
    if (!of || node.assigned || field(of, node.text) || function(of, node.text)) return;
    if (base && base->name == "feder.Event") return;  // of which kind is not known
    say(node, (library ? "the module" : base->name) + " has no " + node.text);
  }

  // The overload that the arguments fit, else the function itself; null for neither.
  const LuaType* matching(const LuaNode& call, const LuaSignatures& all) {
    for (std::size_t k = 1; k < all.size(); ++k)
      if (mismatch_of(call, all[k]).empty()) return &all[k];
    return mismatch_of(call, all[0]).empty() ? all.data() : nullptr;
  }
  // The mistake of the arguments; "" when a signature fits.
  std::string mismatch(const LuaNode& call, const LuaSignatures& all) {
    if (matching(call, all)) return "";
    return (call.syntax == Syntax::method ? call.text : call.parts[0]->text) + ": " + mismatch_of(call, all[0]);
  }
  std::string mismatch_of(const LuaNode& call, const LuaType& signature) {
    const std::size_t count = call.parts.size() - 1, most = signature.fields.size();
    const LuaNode* const last = count > 0 ? call.parts.back() : nullptr;
    const bool open = last && (last->syntax == Syntax::call || last->syntax == Syntax::method || last->text == "...");
    if (count > most) return "at most " + std::to_string(most) + " arguments, got " + std::to_string(count);
    for (std::size_t k = 0; k < most; ++k) {
      const LuaType& p = signature.fields[k];
      if (k >= count) {
        if (!p.optional && !open) return "argument " + p.label + " is missing";
        continue;
      }
      const LuaNode& argument = *call.parts[k + 1];
      if (argument.syntax == Syntax::nothing && p.optional) continue;
      ++out_.arguments;
      if (std::string error = misfit(argument, p); !error.empty()) return p.label + ": " + error;
    }
    return "";
  }

  // "" when the value may be of that type.
  std::string misfit(const LuaNode& value, const LuaType& type) {
    if (type.form == Form::either) {
      std::string told;
      for (const LuaType& one : type.parts) {
        const std::string error = misfit(value, one);
        if (error.empty()) return "";
        // of a table, what its keys should be says more than that it is no string
        if (told.empty() || (value.syntax == Syntax::table && told.starts_with("expected"))) told = error;
      }
      return value.syntax == Syntax::table ? told : "expected " + to_text(type) + ", got " + describe(value);
    }
    if (const auto alias = stubs_.aliases.find(type.name); type.form == Form::name && alias != stubs_.aliases.end())
      return misfit(value, alias->second);
    if (value.syntax == Syntax::table) return misfit_of_table(value, type);
    if (value.syntax == Syntax::function && type.form == Form::function) return bind(value, type);
    const Known known = type_of(value);
    return !known || accepts(*known, type) ? "" : "expected " + to_text(type) + ", got " + describe(value);
  }
  std::string describe(const LuaNode& value) {
    const Known known = type_of(value);
    return known ? to_text(*known) : "?";
  }

  bool accepts(const LuaType& given, const LuaType& wanted) const {
    if (given.form == Form::either)
      return std::ranges::any_of(given.parts, [&](const LuaType& one) { return accepts(one, wanted); });
    if (wanted.form == Form::name && wanted.name == "any") return true;
    if (wanted.form == Form::literal) return given.form == Form::literal ? given.name == wanted.name : false;
    if (given.form == Form::literal)
      return wanted.form == Form::name && wanted.name == (given.name[0] == '"' ? "string" : "boolean");
    if (given.form == Form::name && given.name == "table") return wanted.form != Form::function && !is_plain(wanted);
    if (wanted.form == Form::function) return given.form == Form::function || given.name == "function";
    if (wanted.form != Form::name) return given.form == wanted.form;
    if (given.form != Form::name) return wanted.name == "table" && given.form != Form::function;
    return is_a(given.name, wanted.name) || (given.name == "integer" && wanted.name == "number") ||
           (given.name == "number" && wanted.name == "integer");
  }
  static bool is_plain(const LuaType& type) {
    return type.form == Form::literal || (type.form == Form::name && type.name != "table" && type.name != "any");
  }

  // The parameters of a function by what it is passed as.
  std::string bind(const LuaNode& function, const LuaType& type) {
    for (std::size_t k = 0; k < function.parameters.size(); ++k) {
      if (k >= type.fields.size()) return "a function of at most " + std::to_string(type.fields.size()) + " parameters";
      parameters_[function.parameters[k]] = type.fields[k];
    }
    return "";
  }

  std::string misfit_of_table(const LuaNode& table, const LuaType& type) {
    const LuaClass* const of = class_of(type);
    if (type.form == Form::list || type.form == Form::map) {
      for (const LuaNode* entry : table.parts) {
        if (type.form == Form::list && !entry->text.empty()) return "a list has no key " + entry->text;
        const LuaType& inner = type.parts.back();
        if (std::string error = misfit(*entry->parts[0], inner); !error.empty()) return error;
      }
      return "";
    }
    if (type.form == Form::record || of) return misfit_of_fields(table, type, of);
    return type.form == Form::name && (type.name == "table" || type.name == "any")
               ? ""
               : "expected " + to_text(type) + ", got a table";
  }
  std::string misfit_of_fields(const LuaNode& table, const LuaType& type, const LuaClass* of) {
    for (const LuaNode* entry : table.parts) {
      if (entry->text.empty()) {
        if (entry->parts.size() > 1) continue;  // a key that is computed
        if (!of || of->by_position.empty()) return "a key is missing: options have names";
        if (std::string error = misfit(*entry->parts[0], of->by_position[0]); !error.empty()) return error;
        continue;
      }
      const auto own = std::ranges::find(type.fields, entry->text, &LuaType::label);
      const LuaType* const f = of ? field(of, entry->text) : own == type.fields.end() ? nullptr : &*own;
      if (!f) return "no option " + entry->text;
      ++out_.keys;
      if (std::string error = misfit(*entry->parts[0], *f); !error.empty()) return entry->text + ": " + error;
    }
    for (const auto& [name, f] : of ? of->fields : std::map<std::string, LuaType>{})
      if (!f.optional && std::ranges::find(table.parts, name, &LuaNode::text) == table.parts.end())
        return "option " + name + " is missing";
    return "";
  }

  const LuaTree& tree_;
  const LuaStubs& stubs_;
  std::filesystem::path libraries_;
  StubFindings out_;
  std::map<const LuaVariable*, LuaType> parameters_;  // by what their functions are passed as
  std::map<std::string, LuaClass> modules_;
  int depth_ = 0;
};

}  // namespace

StubFindings check_with_stubs(const std::string& lua, const LuaStubs& stubs, const std::filesystem::path& libraries) {
  const auto tree = cli::parse_lua(lua);
  return Checker(*tree, stubs, libraries).run();
}

}  // namespace feder::test
