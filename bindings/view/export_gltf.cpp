// Animated glTF 2.0 through tinygltf (https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html).
// A track is one instance through time, known by its object and its number among the object's instances. Poses are
// sampled linearly; a track that is not there at a sample has scale 0, switched in a step. Meshes that move by vertex
// are morph targets, sample k with weight 1 at time k: exact at the samples, linear between.
#include <tiny_gltf.h>

#include <cmath>
#include <map>
#include <numeric>

#include "feder/error.h"
#include "view/export.h"
#include "view/output_file.h"
#include "view/palette.h"
#include "view/solids.h"
#include "view/tessellate.h"

namespace feder::view {
namespace {

using Float4 = std::array<float, 4>;

struct TrackKey {
  std::uint32_t object = 0, number = 0;  // number: among the object's instances
  const Geometry* geometry = nullptr;
  friend auto operator<=>(const TrackKey&, const TrackKey&) = default;
};

struct Track {
  Instance first;
  std::shared_ptr<const Geometry> geometry;
  std::string name;
  std::size_t start = 0;         // sample it first appears in
  std::vector<Float3> position;  // one per sample from `start` on; repeated while it is away
  std::vector<Float4> rotation;
  std::vector<std::uint8_t> seen;
};

// Vertices of one thing through time: faces (triangles) or springs (lines).
struct Deforming {
  bool lines = false;
  Color color;
  std::string name;
  std::vector<std::uint32_t> indices;
  std::vector<std::vector<MeshVertex>> samples;  // [sample][vertex]
  std::size_t start = 0;
};

// Appends to the one buffer and describes what was appended.
class Package {
 public:
  explicit Package(tinygltf::Model& model) : model_(model) { model_.buffers.emplace_back(); }

  template <class T>
  int add(const std::vector<T>& data, int type, int component, int target, bool with_range) {
    auto& bytes = model_.buffers[0].data;
    while (bytes.size() % 4) bytes.push_back(0);
    tinygltf::BufferView view;
    view.buffer = 0, view.byteOffset = bytes.size(), view.byteLength = data.size() * sizeof(T), view.target = target;
    const auto* from = reinterpret_cast<const unsigned char*>(data.data());
    bytes.insert(bytes.end(), from, from + view.byteLength);
    model_.bufferViews.push_back(view);
    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model_.bufferViews.size() - 1);
    accessor.componentType = component, accessor.type = type, accessor.count = data.size();
    if (with_range) range(reinterpret_cast<const float*>(data.data()), data.size(), sizeof(T) / 4, accessor);
    model_.accessors.push_back(std::move(accessor));
    return static_cast<int>(model_.accessors.size() - 1);
  }
  int indices(const std::vector<std::uint32_t>& x) {
    return add(x, TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER,
               false);
  }
  int floats(const std::vector<float>& x, bool with_range) {
    return add(x, TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_FLOAT, 0, with_range);
  }
  int vectors(const std::vector<Float3>& x, int target, bool with_range) {
    return add(x, TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT, target, with_range);
  }

 private:
  static void range(const float* x, std::size_t count, std::size_t width, tinygltf::Accessor& a) {
    a.minValues.assign(width, 1e300), a.maxValues.assign(width, -1e300);
    for (std::size_t i = 0; i < count * width; ++i) {
      double &lo = a.minValues[i % width], &hi = a.maxValues[i % width];
      lo = std::min(lo, static_cast<double>(x[i])), hi = std::max(hi, static_cast<double>(x[i]));
    }
  }
  tinygltf::Model& model_;
};

}  // namespace

struct GltfWriter::Impl {
  void add_instance(const Instance& in, const std::shared_ptr<const Geometry>& geometry, std::string name) {
    const TrackKey key{in.object, numbers[in.object]++, geometry.get()};
    auto [found, fresh] = tracks.try_emplace(key);
    Track& t = found->second;
    if (fresh) {
      t.first = in, t.geometry = geometry, t.name = std::move(name), t.start = times.size() - 1;
      order.push_back(key);
    }
    t.position.push_back(in.position);
    Float4 q{in.rotation[0], in.rotation[1], in.rotation[2], in.rotation[3]};
    const float n = std::sqrt(std::inner_product(q.begin(), q.end(), q.begin(), 0.0f));
    for (float& x : q) x = n > 0 ? x / n : 0;
    if (!(n > 0)) q[3] = 1;
    // the nearer of the two quaternions of a rotation, so that what is between samples is the short way
    if (!t.rotation.empty() && std::inner_product(q.begin(), q.end(), t.rotation.back().begin(), 0.0f) < 0)
      for (float& x : q) x = -x;
    t.rotation.push_back(q);
    t.seen.push_back(1);
  }

  void pad_tracks() {
    for (auto& [key, t] : tracks)
      while (t.start + t.seen.size() < times.size()) {
        t.position.push_back(t.position.back()), t.rotation.push_back(t.rotation.back());
        t.seen.push_back(0);
      }
  }

  void add_soft(std::size_t number, bool lines, Color color, std::string name, std::vector<MeshVertex> vertices,
                std::vector<std::uint32_t> indices) {
    if (vertices.empty()) return;
    if (number >= softs.size()) softs.resize(number + 1);
    Deforming& s = softs[number];
    if (s.samples.empty()) {
      s.lines = lines, s.color = color, s.name = std::move(name), s.indices = std::move(indices),
      s.start = times.size() - 1;
    } else if (s.samples.back().size() != vertices.size()) {
      vertices = s.samples.back();  // springs broke: topology cannot change within a mesh
    }
    s.samples.push_back(std::move(vertices));
  }

  void add_points(const Frame& f, const Objects& objects) {
    if (f.points.size() > kMaxAnimatedPoints) {
      left_out = f.points.size();
      return;
    }
    for (const PointGroup& g : f.point_groups)
      for (std::uint32_t i = g.first; i < g.first + g.count; ++i)
        add_instance(ball_instance(f.points[i], point_color(g, f.points[i]), g.object.slot), ball,
                     objects.name(g.object) + " point");
  }

  int material(Color c) {
    const std::uint32_t key = std::uint32_t(c.r) << 24 | std::uint32_t(c.g) << 16 | std::uint32_t(c.b) << 8 | c.a;
    const auto [found, fresh] = materials.try_emplace(key, static_cast<int>(model.materials.size()));
    if (!fresh) return found->second;
    tinygltf::Material m;
    m.pbrMetallicRoughness.baseColorFactor = {to_linear(c.r / 255.0f), to_linear(c.g / 255.0f), to_linear(c.b / 255.0f),
                                              c.a / 255.0};
    m.pbrMetallicRoughness.metallicFactor = 0, m.pbrMetallicRoughness.roughnessFactor = 0.6;
    if (c.a < 255) m.alphaMode = "BLEND";
    m.doubleSided = true;
    model.materials.push_back(std::move(m));
    return found->second;
  }

  // A geometry stretched by `stretch` (in units of its scale along y), with a colour.
  int mesh(const Geometry& g, float stretch, Color color) {
    const auto [found, fresh] =
        meshes.try_emplace({&g, stretch, material(color)}, static_cast<int>(model.meshes.size()));
    if (!fresh) return found->second;
    const auto [shape, unknown] = shapes.try_emplace({&g, stretch});
    if (unknown) {
      std::vector<Float3> positions, normals;
      for (const Vertex& v : g.vertices) {
        positions.push_back(v.position);
        positions.back().y += v.side * stretch;
        normals.push_back(v.normal);
      }
      tinygltf::Primitive& p = shape->second;
      p.attributes["POSITION"] = package->vectors(positions, TINYGLTF_TARGET_ARRAY_BUFFER, true);
      p.attributes["NORMAL"] = package->vectors(normals, TINYGLTF_TARGET_ARRAY_BUFFER, false);
      p.indices = package->indices(g.indices), p.mode = TINYGLTF_MODE_TRIANGLES;
    }
    tinygltf::Mesh m;
    m.name = g.kind;
    m.primitives.push_back(shape->second);
    m.primitives[0].material = material(color);
    model.meshes.push_back(std::move(m));
    return found->second;
  }

  int add_node(tinygltf::Node node) {
    const auto id = static_cast<int>(model.nodes.size());
    model.nodes.push_back(std::move(node));
    model.scenes[0].nodes.push_back(id);
    return id;
  }

  void sampler(int node, const char* path, int output, const char* interpolation) {
    tinygltf::Animation& a = model.animations[0];
    tinygltf::AnimationSampler s;
    s.input = time_input, s.output = output, s.interpolation = interpolation;
    a.samplers.push_back(std::move(s));
    tinygltf::AnimationChannel c;
    c.sampler = static_cast<int>(a.samplers.size() - 1), c.target_node = node, c.target_path = path;
    a.channels.push_back(std::move(c));
  }

  void write_track(const Track& t) {
    const float sy = t.first.scale.y;
    tinygltf::Node node;
    node.name = t.name.empty() ? t.geometry->kind : t.name;
    node.mesh = mesh(*t.geometry, sy > 0 ? t.first.stretch / sy : 0, t.first.color);
    node.translation = {t.position[0].x, t.position[0].y, t.position[0].z};
    node.rotation.assign(t.rotation[0].begin(), t.rotation[0].end());
    node.scale = {t.first.scale.x, t.first.scale.y, t.first.scale.z};
    const int id = add_node(std::move(node));
    if (times.size() < 2) return;

    const auto varies = [](const auto& list) {
      return std::any_of(list.begin(), list.end(), [&](const auto& x) { return x != list[0]; });
    };
    // what comes later waits where it will appear
    const auto whole = [&](const auto& list) {
      auto all = list;
      all.insert(all.begin(), t.start, list.front());
      return all;
    };
    if (varies(t.position)) sampler(id, "translation", package->vectors(whole(t.position), 0, false), "LINEAR");
    if (varies(t.rotation))
      sampler(id, "rotation",
              package->add(whole(t.rotation), TINYGLTF_TYPE_VEC4, TINYGLTF_COMPONENT_TYPE_FLOAT, 0, false), "LINEAR");
    if (t.start == 0 && std::count(t.seen.begin(), t.seen.end(), 0) == 0) return;
    std::vector<Float3> scale(t.start);
    for (const std::uint8_t seen : t.seen) scale.push_back(seen ? t.first.scale : Float3{});
    sampler(id, "scale", package->vectors(scale, 0, false), "STEP");
  }

  void write_soft(const Deforming& s) {
    // one attribute of all vertices, itself or as its difference from the first sample
    const auto split = [](const std::vector<MeshVertex>& v, const std::vector<MeshVertex>* base,
                          Float3 MeshVertex::*field) {
      std::vector<Float3> out(v.size());
      for (std::size_t i = 0; i < v.size(); ++i) out[i] = base ? v[i].*field - (*base)[i].*field : v[i].*field;
      return out;
    };
    const auto attributes = [&](const std::vector<MeshVertex>& v, const std::vector<MeshVertex>* base) {
      std::map<std::string, int> all;
      all["POSITION"] = package->vectors(split(v, base, &MeshVertex::position), TINYGLTF_TARGET_ARRAY_BUFFER, true);
      if (!s.lines)
        all["NORMAL"] = package->vectors(split(v, base, &MeshVertex::normal), TINYGLTF_TARGET_ARRAY_BUFFER, false);
      return all;
    };
    tinygltf::Primitive p;
    p.attributes = attributes(s.samples[0], nullptr);
    p.indices = package->indices(s.indices);
    p.material = material(s.color), p.mode = s.lines ? TINYGLTF_MODE_LINE : TINYGLTF_MODE_TRIANGLES;
    tinygltf::Mesh m;
    m.name = s.name.empty() ? "net" : s.name;
    const std::size_t targets = s.samples.size() - 1;
    for (std::size_t k = 1; k <= targets; ++k) p.targets.push_back(attributes(s.samples[k], &s.samples[0]));
    m.weights.assign(targets, 0.0);
    m.primitives.push_back(std::move(p));
    tinygltf::Node node;
    node.name = m.name, node.mesh = static_cast<int>(model.meshes.size());
    model.meshes.push_back(std::move(m));
    const int id = add_node(std::move(node));
    if (targets == 0) return;
    // before its first sample it is there as it begins; sample k is target k alone
    std::vector<float> weights;
    for (std::size_t i = 0; i < times.size(); ++i)
      for (std::size_t k = 1; k <= targets; ++k)
        weights.push_back(std::min(i < s.start ? 0 : i - s.start, targets) == k ? 1.0f : 0.0f);
    sampler(id, "weights", package->floats(weights, false), "LINEAR");
  }

  void write_grounds() {
    for (const Solid& s : grounds) {
      Deforming still;
      still.color = s.color, still.name = "ground", still.indices = s.indices, still.samples = {s.vertices};
      write_soft(still);
    }
  }

  std::vector<float> times;
  std::vector<TrackKey> order;
  std::map<TrackKey, Track> tracks;
  std::map<std::uint32_t, std::uint32_t> numbers;  // instances of an object so far in this sample
  std::vector<Deforming> softs;
  std::vector<Solid> grounds;
  std::shared_ptr<const Geometry> ball;
  std::size_t left_out = 0;

  tinygltf::Model model;
  std::unique_ptr<Package> package;
  int time_input = -1;
  std::map<std::uint32_t, int> materials;
  std::map<std::pair<const Geometry*, float>, tinygltf::Primitive> shapes;  // without a material
  std::map<std::tuple<const Geometry*, float, int>, int> meshes;
};

GltfWriter::GltfWriter() : impl_(std::make_unique<Impl>()) { impl_->ball = std::make_shared<Geometry>(unit_ball()); }
GltfWriter::~GltfWriter() = default;
std::size_t GltfWriter::left_out() const { return impl_->left_out; }

void GltfWriter::add(const Frame& f, const Objects& objects) {
  Impl& w = *impl_;
  const auto time = static_cast<float>(f.time);
  if (!w.times.empty() && !(time > w.times.back())) return;  // keyframes must rise
  w.times.push_back(time);
  w.numbers.clear();
  for (const Batch& b : f.batches)
    for (std::uint32_t i = b.first; i < b.first + b.count; ++i)
      w.add_instance(f.instances[i], f.geometries[b.geometry], objects.name(objects.at(f.instances[i].object)));
  w.add_points(f, objects);
  w.pad_tracks();
  std::size_t number = 0;
  for (const DynamicMesh& m : f.meshes)
    w.add_soft(number++, false, m.color, objects.name(m.object),
               {f.vertices.begin() + m.first_vertex, f.vertices.begin() + m.first_vertex + m.vertex_count},
               {f.indices.begin() + m.first_index, f.indices.begin() + m.first_index + m.index_count});
  std::vector<MeshVertex> ends;
  std::vector<std::uint32_t> pairs;
  for (const Line& l : f.lines)
    for (const Float3 p : {l.a, l.b}) {
      pairs.push_back(static_cast<std::uint32_t>(ends.size()));
      ends.push_back({p, {0, 1, 0}});
    }
  w.add_soft(number, true, rgb(0x50555c), "springs", std::move(ends), std::move(pairs));
  if (w.times.size() == 1)
    for (const Ground& g : f.grounds) w.grounds.push_back(solid(g, f));
}

void GltfWriter::write(const std::filesystem::path& file) {
  Impl& w = *impl_;
  w.model = {};
  w.materials.clear(), w.shapes.clear(), w.meshes.clear();
  w.package = std::make_unique<Package>(w.model);
  w.model.asset.version = "2.0", w.model.asset.generator = "feder";
  w.model.scenes.emplace_back();
  w.model.defaultScene = 0;
  w.model.animations.emplace_back();
  w.model.animations[0].name = "run";
  if (w.times.size() > 1) w.time_input = w.package->floats(w.times, true);
  w.write_grounds();
  for (const TrackKey& key : w.order) w.write_track(w.tracks.at(key));
  for (const Deforming& s : w.softs)
    if (!s.samples.empty()) w.write_soft(s);
  if (w.model.animations[0].channels.empty()) w.model.animations.clear();
  if (w.model.nodes.empty()) throw SceneError(file.string() + ": the scene has nothing that can be exported");
  tinygltf::TinyGLTF writer;
  write_file(file, [&](std::ostream& out) {
    if (!writer.WriteGltfSceneToStream(&w.model, out, true, file.extension() == ".glb"))
      out.setstate(std::ios::failbit);
  });
}

}  // namespace feder::view
