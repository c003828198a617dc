// YAML documents as Lua values, with the line of every key in a table beside them.
#include "feder/yaml.h"

#include <lua.hpp>

#include "feder/lua.h"
#include "yaml/document.h"

namespace feder::yaml {
namespace {

constexpr const char* kPlaces = "feder.places";

// Builds the Lua value of a document, or only checks for errors when there is no Lua state.
class Builder {
 public:
  Builder(lua_State* lua, const std::string& file, const Document& document)
      : lua_(lua), file_(file), document_(document) {}

  void value(std::uint32_t index) {
    const Node& node = document_.nodes[index];
    if (lua_) luaL_checkstack(lua_, 16, "YAML nested too deep");
    switch (node.kind) {
      case NodeKind::list: return list(node);
      case NodeKind::map: return map(node);
      default:
        if (lua_) scalar(node);
    }
  }

 private:
  [[noreturn]] void fail(const Node& node, const std::string& message) const {
    throw lua::ScriptError(location(node) + ": " + message);
  }
  std::string location(const Node& node) const { return file_ + ":" + std::to_string(node.line); }

  void scalar(const Node& node) {
    switch (node.kind) {
      case NodeKind::boolean: lua_pushboolean(lua_, node.flag); break;
      case NodeKind::integer: lua_pushinteger(lua_, static_cast<lua_Integer>(node.integer)); break;
      case NodeKind::number: lua_pushnumber(lua_, node.number); break;
      case NodeKind::text: lua_pushlstring(lua_, node.text.data(), node.text.size()); break;
      default: lua_pushnil(lua_);
    }
  }

  // Leaves the new table at the top and its table of locations below it.
  void begin_table(const Node& node) {
    if (!lua_) return;
    lua_newtable(lua_);
    lua_newtable(lua_);
    if (!luaL_getsubtable(lua_, LUA_REGISTRYINDEX, kPlaces)) {
      lua_newtable(lua_);
      lua_pushliteral(lua_, "k");
      lua_setfield(lua_, -2, "__mode");
      lua_setmetatable(lua_, -2);
    }
    lua_pushvalue(lua_, -3);
    lua_pushvalue(lua_, -3);
    lua_rawset(lua_, -3);  // places[value] = own locations; keys are weak
    lua_pop(lua_, 1);
    lua_insert(lua_, -2);
    lua_pushboolean(lua_, 1);
    record_location(node);
  }
  void end_table() {
    if (lua_) lua_remove(lua_, -2);
  }
  // Takes the key from the top of the stack; the table and its locations are below it.
  void record_location(const Node& node) {
    const std::string text = location(node);
    lua_pushlstring(lua_, text.data(), text.size());
    lua_rawset(lua_, -4);
  }

  void list(const Node& node) {
    begin_table(node);
    lua_Integer i = 0;
    for (const std::uint32_t child : node.children) {
      const Node& item = document_.nodes[child];
      if (item.kind == NodeKind::null) fail(item, "null in a list: expected a value");
      value(child);
      if (!lua_) continue;
      lua_rawseti(lua_, -2, ++i);
      lua_pushinteger(lua_, i);
      record_location(item);
    }
    end_table();
  }

  void map(const Node& node) {
    begin_table(node);
    std::map<std::string, int> seen;  // key text -> line
    for (std::size_t k = 0; k + 1 < node.children.size(); k += 2) {
      const Node& key = document_.nodes[node.children[k]];
      check_key(key, seen);
      if (key.kind == NodeKind::text && key.text == "<<") continue;
      pair(key, node.children[k + 1]);
    }
    for (std::size_t k = 0; k + 1 < node.children.size(); k += 2) {
      const Node& key = document_.nodes[node.children[k]];
      if (key.kind == NodeKind::text && key.text == "<<") merge(node.children[k + 1], seen);
    }
    end_table();
  }

  void check_key(const Node& key, std::map<std::string, int>& seen) const {
    if (key.kind == NodeKind::list || key.kind == NodeKind::map) fail(key, "a key is a word or a number");
    if (key.kind == NodeKind::null) fail(key, "a key is missing here");
    const auto [first, fresh] = seen.emplace(key.text, key.line);
    if (!fresh) fail(key, "the key '" + key.text + "' is here twice, first in line " + std::to_string(first->second));
  }

  void pair(const Node& key, std::uint32_t child) {
    if (!lua_) return value(child);
    if (key.kind == NodeKind::number && key.number != key.number) fail(key, "NaN is no key");
    scalar(key);
    value(child);
    lua_rawset(lua_, -3);
    scalar(key);
    record_location(key);
  }

  // `<<: *base` or `<<: [*a, *b]`: takes over the keys that are not there yet; the first one wins.
  void merge(std::uint32_t index, std::map<std::string, int>& seen) {
    const Node& from = document_.nodes[index];
    if (from.kind == NodeKind::list) {
      for (const std::uint32_t child : from.children) {
        if (document_.nodes[child].kind != NodeKind::map) fail(from, "<< expects a map or a list of maps");
        merge(child, seen);
      }
      return;
    }
    if (from.kind != NodeKind::map) fail(from, "<< expects a map or a list of maps");
    for (std::size_t k = 0; k + 1 < from.children.size(); k += 2) {
      const Node& key = document_.nodes[from.children[k]];
      if (key.kind == NodeKind::text && key.text == "<<") {
        merge(from.children[k + 1], seen);
      } else if (seen.emplace(key.text, key.line).second) {
        pair(key, from.children[k + 1]);
      }
    }
  }

  lua_State* lua_;
  const std::string& file_;
  const Document& document_;
};

}  // namespace

void push(void* lua_state, const std::string& file, const std::string& text) {
  const Document document = read(file, text);
  Builder(static_cast<lua_State*>(lua_state), file, document).value(document.root);
}

void check(const std::string& file, const std::string& text) {
  const Document document = read(file, text);
  Builder(nullptr, file, document).value(document.root);
}

}  // namespace feder::yaml
