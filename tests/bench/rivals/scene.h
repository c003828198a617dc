// A scene as every engine can build it: shapes, bodies and joints as plain data, written once for all of them.
// SI units, y up.
#pragma once
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace rivals {

struct Vec {
  float x = 0, y = 0, z = 0;
};
inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator*(float s, Vec a) { return {s * a.x, s * a.y, s * a.z}; }
inline float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(Vec a, Vec b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline float length(Vec a) { return std::sqrt(dot(a, a)); }

struct Rotation {  // unit quaternion, body to world
  float x = 0, y = 0, z = 0, w = 1;
};
inline Vec rotate(Rotation q, Vec v) {
  const Vec u{q.x, q.y, q.z}, t = 2 * cross(u, v);
  return v + q.w * t + cross(u, t);
}

enum class ShapeKind { box, sphere, capsule, hull, mesh };
struct Shape {
  ShapeKind kind = ShapeKind::box;
  Vec half = {};                              // box: half sizes, m
  float radius = 0;                           // sphere, capsule, m
  float half_segment = 0;                     // capsule: half the distance of its centres, along y, m
  std::vector<Vec> points = {};               // hull, mesh
  std::vector<std::uint32_t> triangles = {};  // mesh: three indices each, counter-clockwise from its outside
};

enum class Motion { fixed, kinematic, dynamic };
struct Body {
  Motion motion = Motion::dynamic;
  std::uint32_t shape = 0, shape_count = 1;  // a row of Scene::shapes, all in the body's frame
  Vec position = {};                         // of the body's frame, whose origin is its centre of mass
  Vec angular_velocity = {};                 // rad/s
  float density = 1000;                      // kg/m^3
  float friction = .6f, restitution = 0;     // of any pair of such bodies
  bool collides = true;
};

// A ball joint; its bodies do not collide.
struct Joint {
  std::uint32_t a = 0, b = 0;
  Vec anchor = {};  // world, at the start
};

struct Scene {
  float gravity = -10;    // m/s^2, along y
  float dt = 1.f / 60;    // s
  bool sleeping = false;  // bodies may fall asleep
  std::vector<Shape> shapes;
  std::vector<Body> bodies;
  std::vector<Joint> joints;

  std::uint32_t add(Shape shape) {
    shapes.push_back(std::move(shape));
    return static_cast<std::uint32_t>(shapes.size() - 1);
  }
  std::uint32_t add(const Body& body) {
    bodies.push_back(body);
    return static_cast<std::uint32_t>(bodies.size() - 1);
  }
};

struct SceneRow {
  const char* name;
  int steps;  // of a usual run
  void (*build)(Scene& scene);
};
std::span<const SceneRow> scene_rows();
const SceneRow* find_scene(std::string_view name);

}  // namespace rivals
