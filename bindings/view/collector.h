// Fills a Frame from a world. Reads only: the world's hash is the same with and without it. One FrameSource per system
// (frame_rigid.cpp ...), one feder_variant(view <system> FILE frame_<system>.cpp) line each; a system that a world does
// not have costs one null check.
#pragma once
#include <memory>
#include <optional>
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
  const lua::Appearance& appearance;  // colours and faces that the script gave
  const Toggles& toggles;
  GeometryCache& geometry;
  Frame& frame;

  std::optional<Color> own_color(ObjectId object) const;  // that the script gave it
  // Its own, else that of the stem of its name, else that of the group.
  Color color(ObjectId object, std::string_view group) const;
  // The object's name, when names are drawn and it has one.
  void label(ObjectId object, const Vec3& at, Color color) const;
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
template <class Source>
std::unique_ptr<FrameSource> make_source() {
  return std::make_unique<Source>();
}
std::span<const Row> frame_sources();

class Collector {
 public:
  explicit Collector(std::span<const Row> sources = frame_sources());
  // `appearance` may be null.
  void collect(World& world, const lua::Appearance* appearance, const Toggles& toggles, Frame& frame);

 private:
  GeometryCache geometry_;
  std::vector<std::unique_ptr<FrameSource>> sources_;
  const lua::Appearance no_appearance_;
};

// For sources.
void add_line(std::vector<Line>& lines, const Vec3& a, const Vec3& b, Color color, float width = 1.5f);
void add_arrow(std::vector<Line>& lines, const Vec3& from, const Vec3& along, Color color, float width = 1.5f);
void add_box(std::vector<Line>& lines, const Aabb& box, Color color);
// Triangles between points, with smooth normals: those of the faces, weighted by area.
void add_mesh(Frame& frame, ObjectId object, Color color, std::span<const Vec3> points,
              std::span<const std::uint32_t> faces);
// A group of the points that are added to the frame from now on; it is left out when none came.
PointGroup begin_points(const Frame& frame, ObjectId object, Color color);
void end_points(Frame& frame, PointGroup group);
void add_bounds(Frame& frame, const Bounds& moving);

}  // namespace feder::view
