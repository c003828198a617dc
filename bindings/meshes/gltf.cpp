// glTF 2.0 and GLB through tinygltf (https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html): the triangles that the
// file's scene shows, where its nodes place them. The library checks the JSON and brings the buffers; numbers, offsets
// and the tree of nodes are checked here. Meshes are read in their rest shape: skins, morph targets and animations are
// left out, pictures are not opened. Compressed and sparse data is refused.
#include <tiny_gltf.h>

#include <array>
#include <cmath>
#include <cstring>

#include "feder/error.h"
#include "meshes/builder.h"

namespace feder::meshes {
namespace {

constexpr int kMaxNesting = 64;  // of JSON: the library follows it by recursion
constexpr std::size_t kGlbHeader = 12, kChunkHeader = 8;

using Matrix = std::array<double, 16>;  // by columns

constexpr Matrix kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix out = {};
  for (std::size_t column = 0; column < 4; ++column)
    for (std::size_t row = 0; row < 4; ++row)
      for (std::size_t k = 0; k < 4; ++k) out[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  return out;
}

std::array<double, 3> transformed(const Matrix& m, const std::array<float, 3>& p) {
  std::array<double, 3> out = {};
  for (std::size_t row = 0; row < 3; ++row)
    out[row] = m[row] * double(p[0]) + m[4 + row] * double(p[1]) + m[8 + row] * double(p[2]) + m[12 + row];
  return out;
}

// Does it turn the inside out? Triangles are then wound the other way.
bool mirrors(const Matrix& m) {
  return m[0] * (m[5] * m[10] - m[9] * m[6]) - m[4] * (m[1] * m[10] - m[9] * m[2]) +
             m[8] * (m[1] * m[6] - m[5] * m[2]) <
         0;
}

// Elements of an accessor, within their buffer.
struct Elements {
  const unsigned char* data = nullptr;
  std::size_t count = 0, stride = 0;
  int component = 0;
};

std::string named(const char* kind, std::size_t number, const std::string& name = {}) {
  std::string clean = name.substr(0, 60);
  for (char& c : clean)
    if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) == 127) c = '?';
  return kind + std::to_string(number) + (clean.empty() ? "" : " (\"" + clean + "\")");
}

class GltfReader {
 public:
  GltfReader(const lua::MeshFile& file, Builder& builder) : file_(file), builder_(builder) {}

  void load(bool binary) {
    check_nesting(binary ? glb_json() : file_.content);
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader([](tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int,
                             void*) { return true; },
                          nullptr);
    loader.SetFsCallbacks({[](const std::string&, void*) { return true; },
                           [](const std::string& name, void*) { return name; }, read_file, nullptr, this});
    const auto size = static_cast<unsigned int>(file_.content.size());
    std::string error, warning;
    bool good = false;
    try {
      good = binary ? loader.LoadBinaryFromMemory(&model_, &error, &warning,
                                                  reinterpret_cast<const unsigned char*>(file_.content.data()), size)
                    : loader.LoadASCIIFromString(&model_, &error, &warning, file_.content.data(), size, "");
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& e) {
      error = e.what();
    }
    if (good) return;
    if (!file_error_.empty()) fail_file(file_, file_error_);
    error = error.substr(0, error.find_first_of("\r\n"));
    fail_file(file_, error.empty() ? "is no glTF 2.0" : "is no valid glTF 2.0: " + error.substr(0, 200));
  }

  void build() {
    for (const std::string& extension : model_.extensionsRequired)
      if (extension.find("compression") != std::string::npos || extension.find("quantization") != std::string::npos)
        fail_file(file_, "needs " + extension.substr(0, 60) + ", which is not read: export it without");
    if (model_.nodes.empty()) {
      for (std::size_t i = 0; i < model_.meshes.size(); ++i) add_mesh(i, kIdentity);
      return;
    }
    visited_.assign(model_.nodes.size(), false);
    for (const int root : roots()) add_tree(root);
  }

 private:
  // The chunk of JSON; the library trusts lengths that reach eight bytes too far.
  std::string_view glb_json() const {
    const std::string_view all = file_.content;
    const auto number = [all](std::size_t at) {
      std::uint32_t x = 0;
      for (std::size_t k = 4; k-- > 0;) x = x << 8 | static_cast<unsigned char>(all[at + k]);
      return std::uint64_t(x);
    };
    if (all.size() < kGlbHeader + kChunkHeader || !all.starts_with("glTF"))
      fail_file(file_, "is no GLB: expected a header of 20 bytes that begins with glTF");
    const std::uint64_t length = number(8), json = number(kGlbHeader);
    if (length > all.size())
      fail_file(file_,
                "is cut off: says that it has " + std::to_string(length) + " bytes, has " + std::to_string(all.size()));
    const std::uint64_t next = kGlbHeader + kChunkHeader + json;
    if (next > length) fail_file(file_, "is no valid GLB: its JSON ends behind the file");
    if (next < length &&
        (next + kChunkHeader > length || next + kChunkHeader + number(static_cast<std::size_t>(next)) > length))
      fail_file(file_, "is no valid GLB: its binary chunk ends behind the file");
    return all.substr(kGlbHeader + kChunkHeader, static_cast<std::size_t>(json));
  }

  void check_nesting(std::string_view json) const {
    int depth = 0;
    bool text = false;
    for (std::size_t i = 0; i < json.size(); ++i) {
      const char c = json[i];
      if (text && c == '\\')
        ++i;
      else if (c == '"')
        text = !text;
      else if (!text && (c == '{' || c == '['))
        ++depth;
      else if (!text && (c == '}' || c == ']'))
        --depth;
      if (depth > kMaxNesting)
        fail_file(file_, "its JSON is nested deeper than " + std::to_string(kMaxNesting) + " levels");
    }
  }

  // Of the library: buffers, and pictures, which are not wanted.
  static bool read_file(std::vector<unsigned char>* out, std::string* error, const std::string& name, void* self) {
    auto& reader = *static_cast<GltfReader*>(self);
    for (const char* picture : {".png", ".jpg", ".jpeg", ".webp", ".ktx2", ".dds"})
      if (name.ends_with(picture)) return false;
    try {
      if (!reader.file_.read_beside) throw SceneError("names the file '" + name + "'; this host reads no others");
      const std::string bytes = reader.file_.read_beside(name);
      out->assign(bytes.begin(), bytes.end());
      return true;
    } catch (const std::exception& e) {
      reader.file_error_ = *error = e.what();
      return false;
    }
  }

  template <class T>
  const T& item(const std::vector<T>& all, int index, const char* kind, const std::string& where) const {
    if (index < 0 || static_cast<std::size_t>(index) >= all.size())
      fail_file(file_, where + ": expected the number of " + kind + " below " + std::to_string(all.size()) + ", got " +
                           std::to_string(index));
    return all[static_cast<std::size_t>(index)];
  }

  std::vector<int> roots() const {
    if (!model_.scenes.empty()) return item(model_.scenes, std::max(model_.defaultScene, 0), "a scene", "scene").nodes;
    std::vector<bool> child(model_.nodes.size(), false);
    for (const tinygltf::Node& node : model_.nodes)
      for (const int c : node.children)
        if (c >= 0 && static_cast<std::size_t>(c) < child.size()) child[static_cast<std::size_t>(c)] = true;
    std::vector<int> out;
    for (std::size_t i = 0; i < child.size(); ++i)
      if (!child[i]) out.push_back(static_cast<int>(i));
    return out;
  }

  // Depth first, in the order of the file. A node is in one place: what comes twice is a circle, or no tree.
  void add_tree(int root) {
    struct Place {
      int node;
      Matrix above;
    };
    std::vector<Place> open = {{root, kIdentity}};
    while (!open.empty()) {
      const Place place = open.back();
      open.pop_back();
      const tinygltf::Node& node = item(model_.nodes, place.node, "a node", "scene");
      const auto number = static_cast<std::size_t>(place.node);
      const std::string where = named("node ", number, node.name);
      if (visited_[number]) fail_file(file_, where + ": expected one parent, got two, or a circle of nodes");
      visited_[number] = true;
      const Matrix at = product(place.above, matrix_of(node, where));
      if (node.mesh >= 0) {
        item(model_.meshes, node.mesh, "a mesh", where);
        add_mesh(static_cast<std::size_t>(node.mesh), at);
      }
      for (auto child = node.children.rbegin(); child != node.children.rend(); ++child) {
        item(model_.nodes, *child, "a node", where);
        open.push_back({*child, at});
      }
    }
  }

  void check_numbers(const std::vector<double>& all, std::size_t wanted, const std::string& where) const {
    if (!all.empty() && all.size() != wanted)
      fail_file(file_, where + ": expected " + std::to_string(wanted) + " numbers, got " + std::to_string(all.size()));
    for (const double x : all)
      if (!std::isfinite(x)) fail_file(file_, where + ": expected finite numbers");
  }

  Matrix matrix_of(const tinygltf::Node& node, const std::string& where) const {
    check_numbers(node.matrix, 16, where + ", matrix");
    check_numbers(node.translation, 3, where + ", translation");
    check_numbers(node.rotation, 4, where + ", rotation");
    check_numbers(node.scale, 3, where + ", scale");
    Matrix m = kIdentity;
    if (!node.matrix.empty()) {
      std::copy(node.matrix.begin(), node.matrix.end(), m.begin());
      return m;
    }
    if (!node.rotation.empty()) {
      double x = node.rotation[0], y = node.rotation[1], z = node.rotation[2], w = node.rotation[3];
      const double length = std::sqrt(x * x + y * y + z * z + w * w);
      if (!(length > 0) || !std::isfinite(length))
        fail_file(file_, where + ", rotation: expected a quaternion of length 1");
      x /= length, y /= length, z /= length, w /= length;
      m = {1 - 2 * (y * y + z * z),
           2 * (x * y + z * w),
           2 * (x * z - y * w),
           0,
           2 * (x * y - z * w),
           1 - 2 * (x * x + z * z),
           2 * (y * z + x * w),
           0,
           2 * (x * z + y * w),
           2 * (y * z - x * w),
           1 - 2 * (x * x + y * y),
           0,
           0,
           0,
           0,
           1};
    }
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t row = 0; row < 3; ++row) m[4 * k + row] *= node.scale.empty() ? 1 : node.scale[k];
      m[12 + k] = node.translation.empty() ? 0 : node.translation[k];
    }
    return m;
  }

  Elements elements(int index, int type, const std::string& where) const {
    const tinygltf::Accessor& a = item(model_.accessors, index, "an accessor", where);
    const std::string self = where + ": " + named("accessor ", static_cast<std::size_t>(index), a.name);
    if (a.sparse.isSparse) fail_file(file_, self + " is sparse, which is not read");
    if (a.type != type)
      fail_file(file_, self + ": expected " + (type == TINYGLTF_TYPE_VEC3 ? "three numbers" : "one number") + " each");
    const tinygltf::BufferView& view = item(model_.bufferViews, a.bufferView, "a bufferView", self);
    const auto& bytes = item(model_.buffers, view.buffer, "a buffer", self).data;
    const int component = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(a.componentType));
    if (component <= 0) fail_file(file_, self + ": unknown componentType " + std::to_string(a.componentType));
    const std::size_t size = static_cast<std::size_t>(component) * (type == TINYGLTF_TYPE_VEC3 ? 3 : 1);
    Elements out{nullptr, a.count, view.byteStride > 0 ? view.byteStride : size, a.componentType};
    // no sum here may wrap: each part is compared with what is left
    bool inside = view.byteOffset <= bytes.size() && view.byteLength <= bytes.size() - view.byteOffset &&
                  a.byteOffset <= view.byteLength && out.stride >= size;
    if (inside && a.count > 0) {
      const std::size_t left = view.byteLength - a.byteOffset;
      inside = size <= left && (a.count - 1) <= (left - size) / out.stride;
    }
    if (!inside) fail_file(file_, self + ": its " + std::to_string(a.count) + " elements lie outside of their buffer");
    out.data = bytes.data() + view.byteOffset + a.byteOffset;
    return out;
  }

  static std::uint32_t index_at(const Elements& e, std::size_t i) {
    const unsigned char* from = e.data + i * e.stride;
    if (e.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return *from;
    if (e.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) {
      std::uint16_t x = 0;
      std::memcpy(&x, from, sizeof x);
      return x;
    }
    std::uint32_t x = 0;
    std::memcpy(&x, from, sizeof x);
    return x;
  }

  void add_mesh(std::size_t number, const Matrix& at) {
    const tinygltf::Mesh& mesh = model_.meshes[number];
    for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
      const tinygltf::Primitive& p = mesh.primitives[i];
      const std::string where = named("mesh ", number, mesh.name) + ", primitive " + std::to_string(i);
      if (p.mode >= TINYGLTF_MODE_POINTS && p.mode < TINYGLTF_MODE_TRIANGLES) continue;  // points and lines
      if (p.mode < 0 || p.mode > TINYGLTF_MODE_TRIANGLE_FAN)
        fail_file(file_, where + ": unknown mode " + std::to_string(p.mode));
      add_primitive(p, at, where);
    }
  }

  void add_primitive(const tinygltf::Primitive& p, const Matrix& at, const std::string& where) {
    const auto found = p.attributes.find("POSITION");
    if (found == p.attributes.end()) fail_file(file_, where + ": has no POSITION");
    const Elements points = elements(found->second, TINYGLTF_TYPE_VEC3, where);
    if (points.component != TINYGLTF_COMPONENT_TYPE_FLOAT) fail_file(file_, where + ": expected positions as floats");
    const std::size_t base = builder_.vertex_count();
    for (std::size_t i = 0; i < points.count; ++i) {
      std::array<float, 3> from = {};
      std::memcpy(from.data(), points.data + i * points.stride, sizeof from);
      const std::array<double, 3> placed = transformed(at, from);
      const Vec3 v(static_cast<Real>(placed[0]), static_cast<Real>(placed[1]), static_cast<Real>(placed[2]));
      if (!v.allFinite()) fail_file(file_, where + ": position " + std::to_string(i) + " is not finite");
      builder_.add_vertex(v);
    }
    // the vertices in the order of the triangles, then three at a time as the mode says
    Elements indices;
    if (p.indices >= 0) {
      indices = elements(p.indices, TINYGLTF_TYPE_SCALAR, where);
      if (indices.component != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
          indices.component != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
          indices.component != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
        fail_file(file_, where + ": expected indices as whole numbers without a sign");
    }
    const auto corner = [&](std::size_t i) {
      const std::size_t v = p.indices >= 0 ? index_at(indices, i) : i;
      if (v >= points.count)
        fail_file(file_, where + ": names vertex " + std::to_string(v) + "; there are " + std::to_string(points.count));
      return static_cast<std::uint32_t>(base + v);
    };
    const std::size_t corners = p.indices >= 0 ? indices.count : points.count;
    const bool list = p.mode == TINYGLTF_MODE_TRIANGLES, fan = p.mode == TINYGLTF_MODE_TRIANGLE_FAN;
    if (list && corners % 3 != 0)
      fail_file(file_,
                where + ": expected three corners for each triangle, got " + std::to_string(corners) + " in all");
    const bool flip = mirrors(at);
    for (std::size_t i = 0; i + 2 < corners; i += list ? 3 : 1) {
      const std::uint32_t a = corner(fan ? 0 : i), b = corner(i + 1), c = corner(i + 2);
      // each second one of a strip is wound the other way
      const bool swap = flip != (!list && !fan && i % 2 == 1);
      builder_.add_triangle(a, swap ? c : b, swap ? b : c);
    }
  }

  const lua::MeshFile& file_;
  Builder& builder_;
  tinygltf::Model model_;
  std::string file_error_;     // of one that it names
  std::vector<bool> visited_;  // by node
};

}  // namespace

void read_gltf(const lua::MeshFile& file, bool binary, Builder& builder) {
  GltfReader reader(file, builder);
  reader.load(binary);
  reader.build();
}

}  // namespace feder::meshes
