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
  float position[3] = {0, 0, 0};     // m
  float rotation[4] = {0, 0, 0, 1};  // x y z w
  float scale[3] = {1, 1, 1};
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
  float normal[3] = {0, 1, 0};
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
};
struct MeshVertex {
  float position[3];
  float normal[3];
};

struct Point {
  float position[3];
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
};

struct Line {
  float a[3], b[3];
  Color color_a, color_b;
  float width = 1.5f;  // pixels
};

struct Label {
  float position[3];
  Color color;
  char text[48];
};

// A value of this frame; who keeps a history draws a curve.
struct PlotValue {
  char name[32];
  double value;
};

struct EventMark {
  EventKind kind;
  ObjectId a, b;
  float position[3];
  float size;  // strength: impulse in N s, 0 for kinds without one
};

struct Bounds {
  float low[3] = {1e30f, 1e30f, 1e30f}, high[3] = {-1e30f, -1e30f, -1e30f};
  bool empty() const { return !(low[0] <= high[0]); }
  void include(const float p[3], float radius = 0) {
    for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], p[i] - radius), high[i] = std::max(high[i], p[i] + radius);
  }
  void include(const Bounds& b) {
    for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], b.low[i]), high[i] = std::max(high[i], b.high[i]);
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
  std::vector<Line> lines;          // hidden by what is in front
  std::vector<Line> overlay_lines;  // seen through everything: joints, contacts
  std::vector<Label> labels;
  std::vector<PlotValue> plots;
  std::vector<EventMark> marks;

  Bounds moving;  // of what is not fixed
  Bounds bounds;  // of everything finite

  void clear();  // keeps the memory
};

}  // namespace feder::view
