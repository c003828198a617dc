#include "cli/lua_stubs.h"

#include <algorithm>
#include <functional>
#include <set>
#include <sstream>
#include <stdexcept>

namespace feder::test {
namespace {

using Form = LuaType::Form;

bool is_name_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.';
}

// Recursive descent over the rest of a line.
class LineParser {
 public:
  explicit LineParser(std::string text) : text_(std::move(text)) {}

  void skip() { at_ = std::min(text_.find_first_not_of(' ', at_), text_.size()); }
  bool at_end() { return skip(), at_ == text_.size(); }
  bool accept(std::string_view sign) {
    skip();
    if (text_.compare(at_, sign.size(), sign) != 0) return false;
    at_ += sign.size();
    return true;
  }
  void expect(std::string_view sign) {
    if (!accept(sign)) throw std::runtime_error("expected '" + std::string(sign) + "' at '" + text_.substr(at_) + "'");
  }
  std::string name() {
    skip();
    const std::size_t from = at_;
    while (at_ < text_.size() && is_name_letter(text_[at_])) ++at_;
    if (from == at_) throw std::runtime_error("expected a name at '" + text_.substr(at_) + "'");
    return text_.substr(from, at_ - from);
  }

  LuaType type() {
    std::vector<LuaType> all{unit()};
    while (accept("|")) all.push_back(unit());
    return all.size() == 1 ? all[0] : LuaType{.form = Form::either, .parts = std::move(all)};
  }

  // "name?: type"
  LuaType field() {
    const std::string label = name();
    const bool optional = accept("?");
    expect(":");
    LuaType out = type();
    out.label = label, out.optional = optional;
    return out;
  }

 private:
  LuaType unit() {
    LuaType out = simple();
    while (accept("[]")) out = {.form = Form::list, .parts = {std::move(out)}};
    return out;
  }
  LuaType simple() {
    if (accept("(")) {
      LuaType inside = type();
      return expect(")"), inside;
    }
    if (accept("{")) return record();
    if (accept("\"")) {
      const std::size_t end = text_.find('"', at_);
      LuaType out{.form = Form::literal, .name = text_.substr(at_ - 1, end - at_ + 2)};
      at_ = end + 1;
      return out;
    }
    if (accept("...")) return {.name = "any"};
    const std::string word = name();
    if (word == "true" || word == "false") return {.form = Form::literal, .name = word};
    if (word == "fun") return function();
    if (word != "table" || !accept("<")) return {.name = word};
    LuaType key = type();
    expect(",");
    LuaType value = type();
    expect(">");
    return {.form = Form::map, .parts = {std::move(key), std::move(value)}};
  }
  LuaType record() {
    LuaType out{.form = Form::record};
    std::set<std::string> names;
    while (!accept("}")) {
      out.fields.push_back(field());
      if (!names.insert(out.fields.back().label).second)
        throw std::runtime_error("field " + out.fields.back().label + " twice");
      if (!accept(",")) return expect("}"), out;
    }
    return out;
  }
  LuaType function() {
    LuaType out{.form = Form::function};
    expect("(");
    while (!accept(")")) {
      out.fields.push_back(field());
      if (!accept(",")) {
        expect(")");
        break;
      }
    }
    if (accept(":")) do
        out.parts.push_back(type());
      while (accept(","));
    return out;
  }

  std::string text_;
  std::size_t at_ = 0;
};

class Reader {
 public:
  explicit Reader(const std::string& text) : lines_(text) {}

  LuaStubs read() {
    for (std::string line; std::getline(lines_, line);) {
      ++number_;
      try {
        take(line);
      } catch (const std::exception& e) {
        complain(e.what());
      }
    }
    check_names();
    return std::move(stubs_);
  }

 private:
  void complain(const std::string& what) { stubs_.errors.push_back(std::to_string(number_) + ": " + what); }

  void take(const std::string& line) {
    if (line.starts_with("---@")) return tag(line.substr(4));
    if (line.starts_with("local ")) {  // the table of the class above
      owners_[line.substr(6, line.find(' ', 6) - 6)] = class_name_;
      finish_class();
    } else if (line.starts_with("function ")) {
      function(LineParser(line.substr(9)));
    } else if (line.starts_with("feder.")) {
      stubs_.classes.at("feder").fields["pi"] = type_;
    } else if (!line.empty() && !line.starts_with("--") && line != "return feder") {
      throw std::runtime_error("neither an annotation nor a function: " + line);
    }
  }

  void tag(const std::string& text) {
    LineParser in(text);
    const std::string word = in.name();
    if (word == "meta") return static_cast<void>(in.name());
    if (word == "class") return begin_class(in);
    if (word == "alias") {
      const std::string name = in.name();
      stubs_.aliases[name] = know(in.type());
    } else if (word == "field") {
      field(in);
    } else if (word == "operator") {
      in.name(), in.expect(":"), know(in.type());
    } else if (word == "type") {
      type_ = know(in.type());
    } else if (word == "generic") {
      generic_ = in.name();
      in.expect(":"), know(in.type());
    } else if (word == "param") {
      LuaType p = labelled(in);
      if (!signature_.fields.empty() && signature_.fields.back().optional && !p.optional)
        throw std::runtime_error("required parameter " + p.label + " behind an optional one");
      signature_.fields.push_back(std::move(p));
    } else if (word == "return") {
      signature_.parts.push_back(know(in.type()));
    } else if (word == "overload") {
      overloads_.push_back(know(in.type()));
      if (overloads_.back().form != Form::function || !in.at_end()) throw std::runtime_error("no function: " + text);
    } else {
      throw std::runtime_error("unknown annotation @" + word);
    }
  }

  void begin_class(LineParser& in) {
    class_name_ = in.name();
    if (stubs_.classes.count(class_name_)) throw std::runtime_error("class " + class_name_ + " twice");
    LuaClass& made = stubs_.classes[class_name_];
    if (in.accept(":")) made.parent = in.name(), used_.emplace_back(made.parent, number_);
    if (!in.at_end()) throw std::runtime_error("more behind the class");
  }
  void finish_class() { stubs_.classes.at(class_name_).calls = std::move(overloads_), overloads_.clear(); }

  void field(LineParser& in) {
    if (in.accept("[")) {
      in.expect("integer"), in.expect("]");
      stubs_.classes.at(class_name_).by_position = {know(in.type())};
      return;
    }
    const LuaType f = labelled(in);
    if (!stubs_.classes.at(class_name_).fields.emplace(f.label, f).second)
      throw std::runtime_error("field " + f.label + " twice");
  }
  // "name? type"
  LuaType labelled(LineParser& in) {
    const std::string label = in.name();
    const bool optional = in.accept("?");
    LuaType out = know(in.type());
    out.label = label, out.optional = optional;
    return out;
  }

  // "world:body(options) end", below its annotations.
  void function(LineParser in) {
    const std::string path = in.name();
    const bool method = in.accept(":");
    const std::size_t dot = path.rfind('.');
    const std::string owner = method ? path : path.substr(0, dot), name = method ? in.name() : path.substr(dot + 1);
    in.expect("(");
    std::vector<std::string> names, annotated;
    while (!in.accept(")")) names.push_back(in.name()), in.accept(",");
    in.expect("end");
    for (const LuaType& p : signature_.fields) annotated.push_back(p.label);
    signature_.form = Form::function;
    LuaSignatures all{std::move(signature_)};
    for (LuaType& overload : overloads_) {
      if (method && (overload.fields.empty() || overload.fields[0].label != "self")) complain("overload without self");
      if (method) overload.fields.erase(overload.fields.begin());
      all.push_back(std::move(overload));
    }
    signature_ = {}, overloads_.clear(), generic_.clear();
    if (names != annotated) throw std::runtime_error("parameters of " + path + " are others than its @param lines");
    if (!stubs_.classes.at(owners_.at(owner)).functions.emplace(name, std::move(all)).second)
      throw std::runtime_error(path + " twice");
  }

  // Names of types in it, to be looked up at the end.
  LuaType know(LuaType type) {
    const std::function<void(const LuaType&)> visit = [&](const LuaType& t) {
      if (t.form == Form::name && t.name != generic_) used_.emplace_back(t.name, number_);
      for (const LuaType& part : t.parts) visit(part);
      for (const LuaType& f : t.fields) visit(f);
    };
    visit(type);
    if (!generic_.empty() && type.name == generic_) type.name = "any";
    return type;
  }
  void check_names() {
    static const std::set<std::string> own = {"any",    "boolean", "function", "integer",
                                              "number", "string",  "table",    "nil"};
    for (const auto& [name, line] : used_)
      if (!own.count(name) && !stubs_.classes.count(name) && !stubs_.aliases.count(name))
        stubs_.errors.push_back(std::to_string(line) + ": unknown type " + name);
  }

  std::istringstream lines_;
  int number_ = 0;
  LuaStubs stubs_;
  std::string class_name_, generic_;
  std::map<std::string, std::string> owners_;  // classes of the locals that have their functions
  LuaType signature_, type_;
  LuaSignatures overloads_;
  std::vector<std::pair<std::string, int>> used_;
};

}  // namespace

LuaStubs read_stubs(const std::string& text) { return Reader(text).read(); }

std::string to_text(const LuaType& type) {
  std::string out;
  switch (type.form) {
    case Form::name:
    case Form::literal: return type.name;
    case Form::list: return to_text(type.parts[0]) + "[]";
    case Form::map: return "table<" + to_text(type.parts[0]) + ", " + to_text(type.parts[1]) + ">";
    case Form::function: return "function";
    case Form::record: return "table";
    case Form::either:
      for (const LuaType& part : type.parts) out += (out.empty() ? "" : "|") + to_text(part);
  }
  return out;
}

}  // namespace feder::test
