// A YAML document as a flat list of nodes, read from yaml-cpp's events under limits.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace feder::yaml {

struct Limits {
  std::size_t bytes = std::size_t(16) << 20;  // of text
  std::size_t nodes = 1000000;                // after aliases are expanded
  std::size_t depth = 64;                     // of nesting, after aliases are expanded
};

enum class NodeKind : std::uint8_t { null, boolean, integer, number, text, list, map };

struct Node {
  NodeKind kind = NodeKind::null;
  bool flag = false;
  std::int64_t integer = 0;
  double number = 0;
  std::string text;
  int line = 0;                         // counts from 1
  std::vector<std::uint32_t> children;  // list: values; map: key, value, key, value ...; aliases repeat an index
};

struct Document {
  std::vector<Node> nodes;
  std::uint32_t root = 0;
};

// Throws lua::ScriptError "file:line: message".
Document read(const std::string& file, const std::string& text, const Limits& limits = {});

// The kind and value of a scalar by the YAML 1.2 core schema: `tag` is "?" for plain scalars, "!" for quoted ones, else
// an explicit tag. False when the tag is unknown or does not fit the text.
bool resolve_scalar(const std::string& tag, const std::string& text, Node& node);

}  // namespace feder::yaml
