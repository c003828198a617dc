// Stubs for the Lua language server (LuaCATS annotations, https://luals.github.io/wiki/annotations): a class for every
// owner, for every table of options and every kind of event, an overload of `on` for every kind of event. Types of
// arguments and results follow from their names in signatures, those of options from their rows. Functions within a
// union stand in parentheses: what follows a comma would be another result. tests/cli/test_stubs.cpp reads it all.
#include <algorithm>

#include "cli/doc_pages.h"
#include "cli/doc_stub_types.h"

namespace feder::cli {
namespace {

bool is_object(const std::string& owner) {
  static const char* const others[] = {"feder", "world", "object", "shape",   "buffer",  "connection",
                                       "task",  "event", "expect", "options", "command", "yaml"};
  return std::ranges::find(others, owner) == std::end(others);
}

// An argument of a signature: "x", "[max]", "fn | buffer", "within = 10", "{min, max}", "\"<\" | \"<=\"".
struct Argument {
  std::string name;
  bool optional = false;
  std::string type;
};

class Stubs {
 public:
  explicit Stubs(const Pages& pages) : pages_(pages) {}

  std::string write() {
    out_ = "---@meta feder\n-- Written by `feder doc --luacats` of feder " FEDER_VERSION ".\n";
    aliases();
    filters();
    for (const lua::ReferencePage& p : pages_) {
      if (p.kind == lua::PageKind::event) event_class(p);
      if (has_options(p)) options_class(p, options_name(p), "");
    }
    for (const Owner& owner : owners(pages_))
      if (owner.name != "options" && owner.name != "command" && owner.name != "yaml") owner_class(owner.name);
    return out_ + "\n---@type number\nfeder.pi = 3.141592653589793\n\nreturn feder\n";
  }

 private:
  using Page = lua::ReferencePage;
  using Row = lua::ReferenceRow;

  template <class... Parts>
  void line(const char* format, const Parts&... parts) {
    out_ += fmt::format(fmt::runtime(format), parts...) + "\n";
  }

  bool is_class(const std::string& word) const {
    return std::ranges::any_of(pages_,
                               [&](const Page& p) { return p.owner == word && p.kind != lua::PageKind::command; });
  }
  static bool has_options(const Page& p) {
    const bool reads =
        p.kind == lua::PageKind::options || p.kind == lua::PageKind::function || p.kind == lua::PageKind::method;
    return reads && !p.rows.empty();
  }
  // "feder.BodyOptions"; with its owner in front where two have such a method.
  std::string options_name(const Page& p) const {
    const bool shared =
        std::ranges::count_if(pages_, [&](const Page& o) { return has_options(o) && o.name == p.name; }) > 1;
    return stub_class(shared ? p.owner + "_" + p.name : p.name, "Options");
  }

  void aliases() {
    std::string kinds, objects;
    for (const Page& p : pages_)
      if (p.kind == lua::PageKind::event) kinds += (kinds.empty() ? "\"" : "|\"") + p.name + '"';
    for (const Owner& owner : owners(pages_))
      if (is_object(owner.name)) objects += (objects.empty() ? "" : "|") + stub_class(owner.name);
    line("\n---@alias feder.EventKind {}", kinds);
    line("---@alias feder.AnyObject {}", objects);
  }

  // Types of arguments, results and rows.
  std::string type_of(const std::string& name) const {
    if (const std::string* known = stub_type_of_name(name)) return *known;
    if (name == "scene" || name.starts_with("{{")) return name == "scene" ? "table" : "table[]";
    if (name.starts_with("{[name]")) return "table<string, number>";
    if (name.starts_with("{")) return type_of(name.substr(1, name.find(',') - 1)) + "[]";
    return is_class(name) ? stub_class(name) : "unknown";
  }

  std::string type_of(const Row& r, const Page& p, const std::string& inner) const {
    if (p.title == "feder.scene" && r.name == "world") return "feder.WorldOptions";
    std::string names;
    if (r.type == "string" && !r.allowed.empty() && !r.allowed.starts_with("a "))
      for (const std::string_view word : split_choices(r.allowed))
        names += (names.empty() ? "\"" : "|\"") + std::string(word) + '"';
    if (!names.empty()) return names;
    const std::string* const known = stub_type_of_row(r.type);
    std::string type = known                   ? *known
                       : is_plain_type(r.type) ? r.type
                       : is_class(r.type)      ? stub_class(r.type)
                                               : "unknown";
    // tables with rows of their own have a class; in lists, that one
    const std::size_t table = type.find("table<") == 0 ? type.find("table", 6) : type.find("table");
    if (inner.empty() || r.type == "list of tables") return type;
    if (r.type == "list") return inner + "[]";
    if (table == std::string::npos) return type + "|" + inner;
    return type.replace(table, 5, inner);
  }

  // A class for the rows below `prefix` ("study.certainty."), after those of the tables within them.
  void options_class(const Page& p, const std::string& name, const std::string& prefix) {
    struct Field {
      const Row* row;
      std::string name, type;
    };
    std::vector<Field> fields;
    for (const Row& r : p.rows) {
      if (!r.name.starts_with(prefix) || r.name.find('.', prefix.size()) != std::string::npos) continue;
      const std::string below = r.name + ".", own = r.name.substr(prefix.size());
      const auto same = std::ranges::find(fields, own, &Field::name);
      const bool inner = std::ranges::any_of(p.rows, [&](const Row& o) { return o.name.starts_with(below); }) &&
                         !(p.title == "feder.scene" && r.name == "world");
      const std::string nested = inner ? stub_class(name.substr(6) + "." + own) : "";
      if (inner && same == fields.end()) options_class(p, nested, below);
      const std::string type = type_of(r, p, nested);
      if (same == fields.end())
        fields.push_back({&r, own, type});
      else  // of several variants
        same->type = join_types(same->type, type);
    }
    line("\n---@class {}", name);
    for (const Field& f : fields)
      line("---@field {}? {} {}{}{}", f.name, f.type, f.row->unit.empty() ? "" : "(" + f.row->unit + ") ", f.row->text,
           f.row->fallback.empty() ? "" : " Default " + f.row->fallback + ".");
    // values by position: the ends of a spring, the materials of a pair
    if (std::ranges::any_of(p.rows, [&](const Row& r) { return r.name + "." == prefix && is_tuple(r); }))
      line("---@field [integer] integer|string");
    if (p.title == "feder.world" && prefix.empty()) system_fields();
  }
  static bool is_tuple(const Row& r) { return r.type == "list" || r.type == "list of {i, j, ...}"; }
  void system_fields() {
    for (const Page& system : pages_)
      if (system.kind == lua::PageKind::options)
        line("---@field {}? {} {}", system.name, options_name(system), system.text);
  }

  void event_class(const Page& p) {
    line("\n---@class {} : feder.Event", stub_class(p.name, "Event"));
    for (const Row& r : p.rows)
      if (r.name.starts_with("e.")) line("---@field {} {} {}", r.name.substr(2), type_of(r, p, ""), r.text);
    if (!has_filter(p)) return;
    line("\n---@class {} : feder.Filter", stub_class(p.name, "Filter"));
    for (const Row& r : p.rows)
      if (r.name.starts_with("filter.")) line("---@field {}? {} {}", r.name.substr(7), type_of(r, p, ""), r.text);
  }
  static bool has_filter(const Page& p) {
    return std::ranges::any_of(p.rows, [](const Row& r) { return r.name.starts_with("filter."); });
  }
  void filters() { line("\n---@class feder.Filter"); }

  // A class with the functions of its pages.
  void owner_class(const std::string& owner) {
    line("\n---@class {}{}", owner == "feder" ? owner : stub_class(owner), is_object(owner) ? " : feder.Object" : "");
    if (owner == "buffer") out_ += "---@field [integer] number\n---@operator len: integer\n";
    if (owner == "expect") line("---@overload fun(condition: any, message?: string): boolean");
    line("local {} = {{}}", owner);
    for (const Page& p : pages_)
      if (p.owner == owner && p.kind != lua::PageKind::event) function(p);
  }

  Argument argument(const Page& p, const std::string& part) const {
    Argument out;
    for (const std::string& one : split_top(part, '|')) {
      const std::string word = one.substr(0, one.find(" ="));
      const std::string inner = one[0] == '{' ? one.substr(1, one.find('}') - 1) : "";
      if (out.name.empty()) out.name = one[0] == '"' ? "word" : inner.empty() ? word : split_top(inner, ',').front();
      const std::string* const known = stub_type_of_argument(p.title, word);
      std::string type = known ? *known : one[0] == '"' ? one : type_of(word);
      if (type.starts_with("fun(") && part != one) type = "(" + type + ")";
      if (inner == "min, max") type = "number[][]", out.name = out.name == "min" ? "corners" : out.name;
      if (inner == "x, y, z") type = "number[]";
      if (inner == "from, to" && out.name == "from") out.name = "window";
      if (inner == "least, most") type = "integer[]";
      if (inner == "objects") type = "feder.AnyObject[]";
      if (word == "filter" && has_options(p)) type = options_name(p);
      if (word == "filter" && !has_options(p))
        type = p.name == "on" ? "feder.Filter|fun(e: feder.Event)" : "feder.Filter";
      if (word == "fn" && p.name == "on") type = "fun(e: feder.Event)";
      out.type += (out.type.empty() ? "" : "|") + type;
    }
    return out;
  }

  // Optional ones stand in brackets; a table of options comes last.
  std::vector<Argument> arguments(const Page& p) const {
    const std::string& s = p.signature;
    const std::size_t open = s.find_first_of("({"), arrow = s.find(" -> ");
    const bool table = open != std::string::npos && s[open] == '{';
    const std::string list =
        table || open == std::string::npos ? "" : s.substr(open + 1, s.rfind(')', arrow) - open - 1);
    std::vector<Argument> all;
    bool optional = false, options = table;
    for (std::string part : split_top(list, ',')) {
      optional = optional || part.find('[') != std::string::npos;
      std::erase_if(part, [](char c) { return c == '[' || c == ']'; });
      if (part[0] == '{' && part.find('=') != std::string::npos) {
        options = true;
        continue;
      }
      all.push_back(argument(p, part));
      all.back().optional = optional;
    }
    if (options) all.push_back({"options", optional, options_type(p)});
    // a handler comes last, with a filter before it or in its place
    if (p.name == "on") all[1].optional = false;
    // in two dimensions z is left out
    if (all.size() > 2 && !table && all.back().name == "z" && all[all.size() - 2].name == "y")
      all.back().optional = true;
    return all;
  }
  std::string options_type(const Page& p) const {
    const Page* net = nullptr;
    if (p.title == "net:add_spring")
      for (const Page& other : pages_)
        if (other.title == "world:net") net = &other;
    if (net) return stub_class(options_name(*net).substr(6) + ".springs");
    const bool list = p.signature.find("{ {") != std::string::npos;  // of tables
    return (has_options(p) ? options_name(p) : "table") + (list ? "[]" : "");
  }

  void function(const Page& p) {
    const std::vector<Argument> all = arguments(p);
    const std::string own = results(p);
    line("\n---{}", p.text);
    const bool same_type = p.title == "feder.param";
    if (same_type) line("---@generic T : number|string|boolean");
    std::string names;
    for (const Argument& a : all) {
      line("---@param {}{} {}", a.name, a.optional ? "?" : "", same_type && a.name == "default" ? "T" : a.type);
      names += (names.empty() ? "" : ", ") + a.name;
    }
    for (const std::string& result : result_list(p))
      line("---@return {}", same_type ? "T" : result_with_name(p, result));
    overloads(p, all, own);
    const bool dot = p.signature.starts_with(p.owner + ".");
    line("function {}{}{}({}) end", p.owner, dot ? "." : ":", p.name, names);
  }

  static std::vector<std::string> result_list(const Page& p) {
    const std::size_t arrow = p.signature.find(" -> ");
    return arrow == std::string::npos ? std::vector<std::string>{} : split_top(p.signature.substr(arrow + 4), ',');
  }
  std::string result_type(const Page& p, const std::string& name) const {
    if (name == "self") return stub_class(p.owner);
    return p.name == "count" ? "integer" : type_of(name);
  }
  std::string result_with_name(const Page& p, const std::string& name) const {
    const bool told = name[0] == '{' || name == "self" || is_class(name) || is_plain_type(name);
    return result_type(p, name) + (told ? "" : " " + name);
  }
  std::string results(const Page& p) const {
    std::string out;
    for (const std::string& name : result_list(p)) out += (out.empty() ? ": " : ", ") + result_type(p, name);
    return out;
  }

  void overload(const Page& p, const std::string& list, const std::string& returns) {
    const bool method = !p.signature.starts_with(p.owner + ".");
    const std::string self = method ? "self: " + stub_class(p.owner) + (list.empty() ? "" : ", ") : "";
    line("---@overload fun({}{}){}", self, list, returns);
  }
  void overloads(const Page& p, const std::vector<Argument>& all, const std::string& own) {
    if (!all.empty() && all[0].name == "kind" && all[0].type == "feder.EventKind") return by_kind(p, own);
    if (const std::string* table = stub_table_form(p.title)) overload(p, *table, own);
    vector_form(p, all, own);
  }

  // The kind of event tells what the handler gets, or what is returned.
  void by_kind(const Page& p, const std::string& own) {
    for (const Page& event : pages_) {
      if (event.kind != lua::PageKind::event) continue;
      const std::string kind = "kind: \"" + event.name + '"', type = stub_class(event.name, "Event");
      const std::string filter = "filter: " + stub_class(event.name, "Filter");
      if (p.name == "events") overload(p, kind, ": fun(): " + type);
      if (p.name == "wait_for") overload(p, kind, ": " + type);
      if (p.name == "wait_for" && has_filter(event)) overload(p, kind + ", " + filter, ": " + type);
      if (p.name == "on") overload(p, kind + ", fn: fun(e: " + type + ")", own);
      if (p.name == "on" && has_filter(event)) overload(p, kind + ", " + filter + ", fn: fun(e: " + type + ")", own);
    }
  }

  // Vectors as tables in place of three numbers each.
  void vector_form(const Page& p, const std::vector<Argument>& all, const std::string& own) {
    static const std::pair<const char*, const char*> vectors[] = {
        {"x", "vector"}, {"px", "point"}, {"dx", "direction"}, {"nx", "normal"}};
    std::string list;
    bool changed = false;
    for (std::size_t k = 0; k < all.size(); ++k) {
      const auto named = std::ranges::find_if(vectors, [&](const auto& v) { return all[k].name == v.first; });
      std::string third = all[k].name;
      third.back() = 'z';
      const bool vector = named != std::end(vectors) && k + 2 < all.size() && all[k + 2].name == third;
      if (!list.empty()) list += ", ";
      list += (vector ? named->second : all[k].name) + std::string(all[k].optional ? "?: " : ": ") +
              (vector ? "number[]" : all[k].type);
      if (vector) k += 2, changed = true;
    }
    const bool rotation = !all.empty() && all.back().name == "w";  // no vector
    if (changed && !rotation) overload(p, list, own);
  }

  const Pages& pages_;
  std::string out_;
};

}  // namespace

std::string pages_luacats(const Pages& pages) { return Stubs(pages).write(); }

}  // namespace feder::cli
