// Fills a Frame from a world. Reads only: the world's hash is the same with and without it. One FrameSource per system
// (frame_rigid.cpp ...), one feder_variant(view <system> FILE frame_<system>.cpp) line each; a system that a world does
// not have costs one null check.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "feder/lua.h"
#include "feder/world.h"
#include "view/frame.h"
#include "view/palette.h"
#include "view/toggles.h"

namespace feder::view {

// What a source works with.
struct Collecting {
  World& world;
  const lua::Look& appearance;  // colours and faces that the script gave
  const Toggles& toggles;
  GeometryCache& geometry;
  Frame& frame;
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual void collect(Collecting& c) = 0;
};

struct Row {
  const char* system;
  std::unique_ptr<FrameSource> (*make)();
};
std::span<const Row> frame_sources();

class Collector {
 public:
  explicit Collector(std::span<const Row> sources = frame_sources());
  // `appearance` may be null.
  void collect(World& world, const lua::Look* appearance, const Toggles& toggles, Frame& frame);

 private:
  GeometryCache geometry_;
  std::vector<std::unique_ptr<FrameSource>> sources_;
  const lua::Look no_appearance_;
};

// For sources.
inline void put(float out[3], const Vec3& v) {
  out[0] = static_cast<float>(v[0]), out[1] = static_cast<float>(v[1]), out[2] = static_cast<float>(v[2]);
}
void add_line(std::vector<Line>& lines, const Vec3& a, const Vec3& b, Color color, float width = 1.5f);
void add_arrow(std::vector<Line>& lines, const Vec3& from, const Vec3& along, Color color, float width = 1.5f);
void add_box(std::vector<Line>& lines, const Aabb& box, Color color);
// Normals of a mesh from its faces, weighted by area; those in the frame must be zero.
void smooth_normals(Frame& frame, const DynamicMesh& mesh);
void add_label(Frame& frame, const Vec3& at, std::string_view text, Color color);

}  // namespace feder::view
