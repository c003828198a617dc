// Reads events instead of yaml-cpp's own tree, so that a hostile text is stopped at a limit and not after it has grown:
// an alias costs as many nodes as what it stands for ("billion laughs" ends at the node limit), nesting is counted.
#include "yaml/document.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <map>
#include <sstream>

#include "feder/lua.h"

namespace feder::yaml {
namespace {

class Reader final : public YAML::EventHandler {
 public:
  Reader(const std::string& file, const Limits& limits) : file_(file), limits_(limits) {}

  Document take() { return std::move(document_); }
  bool has_root() const { return has_root_; }

  [[noreturn]] void fail(int line, const std::string& message) const {
    throw lua::ScriptError(file_ + ":" + std::to_string(line) + ": " + message);
  }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (documents_++) fail(mark.line + 1, "expected one YAML document, found another one");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { leaf(mark, anchor, Node{}); }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    Node node;
    if (!resolve_scalar(tag, value, node)) fail(mark.line + 1, "the tag " + tag + " does not fit '" + value + "'");
    leaf(mark, anchor, std::move(node));
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto known = anchors_.find(anchor);
    if (known == anchors_.end()) fail(mark.line + 1, "unknown alias");
    if (sizes_[known->second].open) fail(mark.line + 1, "an alias inside the value it stands for");
    const Size& size = sizes_[known->second];
    attach(mark.line + 1, known->second, size.nodes, size.height);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, NodeKind::list);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, NodeKind::map);
  }
  void OnMapEnd() override { close(); }

 private:
  // What a node costs when an alias repeats it.
  struct Size {
    std::size_t nodes = 1, height = 1;
    bool open = false;
  };

  std::uint32_t add(const YAML::Mark& mark, YAML::anchor_t anchor, Node node) {
    const auto index = static_cast<std::uint32_t>(document_.nodes.size());
    node.line = mark.line + 1;
    document_.nodes.push_back(std::move(node));
    sizes_.push_back({});
    if (anchor) anchors_[anchor] = index;
    return index;
  }

  // Attaches a finished or just opened node to the innermost open one.
  void attach(int line, std::uint32_t index, std::size_t nodes, std::size_t height) {
    total_ += nodes;
    if (total_ > limits_.nodes)
      fail(line, "more than " + std::to_string(limits_.nodes) + " values, counting what aliases repeat");
    if (stack_.size() + height > limits_.depth)
      fail(line, "nested deeper than " + std::to_string(limits_.depth) + " levels");
    if (stack_.empty()) {
      document_.root = index;
      has_root_ = true;
      return;
    }
    document_.nodes[stack_.back()].children.push_back(index);
    if (!sizes_[index].open) grow(stack_.back(), nodes, height);
  }

  void grow(std::uint32_t parent, std::size_t nodes, std::size_t height) {
    sizes_[parent].nodes += nodes;
    sizes_[parent].height = std::max(sizes_[parent].height, height + 1);
  }

  void leaf(const YAML::Mark& mark, YAML::anchor_t anchor, Node node) {
    attach(mark.line + 1, add(mark, anchor, std::move(node)), 1, 1);
  }

  void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, NodeKind kind) {
    static const std::string core = "tag:yaml.org,2002:";
    const std::string expected = core + (kind == NodeKind::map ? "map" : "seq");
    if (tag != "?" && tag != "!" && !tag.empty() && tag != expected) fail(mark.line + 1, "unknown tag " + tag);
    Node node;
    node.kind = kind;
    const std::uint32_t index = add(mark, anchor, std::move(node));
    sizes_[index].open = true;
    attach(mark.line + 1, index, 1, 1);
    stack_.push_back(index);
  }

  void close() {
    const std::uint32_t index = stack_.back();
    stack_.pop_back();
    sizes_[index].open = false;
    if (!stack_.empty()) grow(stack_.back(), sizes_[index].nodes, sizes_[index].height);
  }

  const std::string& file_;
  Limits limits_;
  Document document_;
  std::vector<Size> sizes_;  // beside document_.nodes
  std::vector<std::uint32_t> stack_;
  std::map<YAML::anchor_t, std::uint32_t> anchors_;
  std::size_t total_ = 0;
  int documents_ = 0;
  bool has_root_ = false;
};

}  // namespace

Document read(const std::string& file, const std::string& text, const Limits& limits) {
  Reader reader(file, limits);
  if (text.size() > limits.bytes) reader.fail(1, "larger than " + std::to_string(limits.bytes) + " bytes");
  std::istringstream stream(text);
  try {
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(reader)) continue;
  } catch (const YAML::Exception& e) {
    reader.fail(e.mark.is_null() ? 1 : e.mark.line + 1, e.msg);
  }
  if (!reader.has_root()) reader.fail(1, "no YAML document in here");
  return reader.take();
}

}  // namespace feder::yaml
