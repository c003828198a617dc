// One picture's worth of a world as plain arrays: what every renderer, recording and export reads. World units and
// axes (m, y up), floats in every build. Arrays are reused from frame to frame: nothing allocates once warm.
// Filled by Collector (view/collector.h), one source per system.
#pragma once
#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "feder/events.h"
#include "view/geometry.h"

namespace feder::view {

struct Color {
  std::uint8_t r = 255, g = 255, b = 255, a = 255;  // sRGB
  friend bool operator==(const Color&, const Color&) = default;
};

// A shape in the world: vertex v of the geometry stands at position + rotation * (v * scale + (0, side * stretch, 0)).
// Uploaded as it is.
struct Instance {
  Float3 position;                   // m
  float rotation[4] = {0, 0, 0, 1};  // x y z w
  Float3 scale{1, 1, 1};
  float stretch = 0;  // m; capsules: half the length of the straight part
  Color color;
  std::uint32_t object = kNone;  // slot of the object
  std::uint32_t flags = 0;       // InstanceFlags
};
enum InstanceFlags : std::uint32_t { kAsleep = 1, kSensor = 2, kFixed = 4 };

// A run of Frame::instances with one geometry.
struct Batch {
  std::uint32_t geometry = 0;  // in Frame::geometries
  std::uint32_t first = 0, count = 0;
  bool translucent = false;
};

// A half-space: n.x <= distance is solid. Renderers draw a large patch of it with a fading grid.
struct Ground {
  Float3 normal{0, 1, 0};
  float distance = 0;  // m
  Color color;
  ObjectId object;
};

// Vertices that move each frame: faces of nets, cloth, fluid surfaces. A run of Frame::vertices and Frame::indices.
struct DynamicMesh {
  std::uint32_t first_vertex = 0, vertex_count = 0;
  std::uint32_t first_index = 0, index_count = 0;  // indices count from first_vertex
  Color color;
  ObjectId object;
  std::uint32_t liquid = kNone;  // in Frame::liquids: it is drawn as that
};
struct MeshVertex {
  Float3 position, normal;
};

struct Point {
  Float3 position;
  float radius;  // m
  float value;   // of the group's scalar
};

// A run of Frame::points. With `scalar` set, colours go by value from `low` to `high`.
struct PointGroup {
  std::uint32_t first = 0, count = 0;
  Color color;
  const char* scalar = nullptr;  // "speed", "density", "pressure"; null: `color` for all
  float low = 0, high = 1;
  ObjectId object;
  std::uint32_t liquid = kNone;  // in Frame::liquids: they are drawn as that
  bool casts_shadow = true;
};

// A liquid that one sees through: the body that a closed mesh bounds, or that the points of a group make up.
struct Liquid {
  std::uint32_t mesh = kNone, group = kNone;  // in Frame::meshes or Frame::point_groups
  std::uint32_t first_foam = kNone;           // in Frame::foam, of the mesh's first vertex; kNone: no foam
  Color color;
  float transparency = 1;  // 0: opaque, 1: as clear as can be
  float depth = 1;         // m; so much of it has its full colour
};

// What the picture does not show as it was asked for, and why.
struct Note {
  ObjectId object;
  char text[240];
};

struct Line {
  Float3 a, b;
  Color color_a, color_b;
  float width = 1.5f;  // pixels
};

struct Label {
  Float3 position;
  Color color;
  char text[48];
};

// A value of this frame; who keeps a history draws a curve.
struct PlotValue {
  char name[32];
  double value;
};

struct Bounds {
  Float3 low{1e30f, 1e30f, 1e30f}, high{-1e30f, -1e30f, -1e30f};
  bool empty() const { return !(low.x <= high.x); }
  Float3 center() const { return (low + high) / 2; }
  float longest_side() const { return std::max({0.0f, high.x - low.x, high.y - low.y, high.z - low.z}); }
  void include(const Bounds& b) { low = min(low, b.low), high = max(high, b.high); }
  void include(Float3 p, float radius = 0) {
    const Float3 r{radius, radius, radius};
    include(Bounds{p - r, p + r});
  }
};

struct Frame {
  double time = 0;  // s, simulated
  std::uint64_t step = 0;
  int dimension = 3;

  std::vector<std::shared_ptr<const Geometry>> geometries;  // ids of one Collector only ever grow
  std::vector<Instance> instances;                          // grouped by geometry
  std::vector<Batch> batches;
  std::vector<Ground> grounds;
  std::vector<MeshVertex> vertices;
  std::vector<std::uint32_t> indices;
  std::vector<DynamicMesh> meshes;
  std::vector<Point> points;
  std::vector<PointGroup> point_groups;
  std::vector<Liquid> liquids;
  std::vector<float> foam;          // 0 .. 1, by vertex of a liquid
  std::vector<Line> lines;          // hidden by what is in front
  std::vector<Line> outlines;       // of volumes and cells: the same, but the camera is not fitted to them
  std::vector<Line> overlay_lines;  // seen through everything: joints, contacts
  std::vector<Label> labels;
  std::vector<PlotValue> plots;
  std::vector<Note> notes;
  bool deeper_volumes = false, deeper_cells = false;  // below the level that is drawn

  Bounds moving;  // of what is not fixed
  Bounds bounds;  // of everything finite

  void clear();  // keeps the memory
};

}  // namespace feder::view
