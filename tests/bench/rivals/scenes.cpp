// The scenes, one function each. Most are benchmarks of Box2D, Box3D, Jolt and PEEL, defined anew by their measures.
#include "scene.h"

namespace rivals {
namespace {

constexpr float kPi = 3.14159265f;

Shape box(float x, float y, float z) { return {.kind = ShapeKind::box, .half = {x / 2, y / 2, z / 2}}; }
Shape sphere(float radius) { return {.kind = ShapeKind::sphere, .radius = radius}; }
Shape hull(std::vector<Vec> points) { return {.kind = ShapeKind::hull, .points = std::move(points)}; }

// A floor of that side, its top at y = 0.
void add_floor(Scene& scene, float side, float friction = .6f) {
  const auto shape = scene.add(box(side, 2, side));
  scene.add(Body{.motion = Motion::fixed, .shape = shape, .position = {0, -1, 0}, .friction = friction});
}

// A wall of unit cubes in the shape of a triangle, `base` of them in the lowest row.
void add_pyramid(Scene& scene, std::uint32_t cube, int base, float x, float z) {
  for (int i = 0; i < base; ++i)
    for (int j = i; j < base; ++j) {
      const Vec at{x + .5f * static_cast<float>(i + 1) + static_cast<float>(j - i) - .5f * static_cast<float>(base),
                   static_cast<float>(i) + .5f, z};
      scene.add(Body{.shape = cube, .position = at, .density = 100});
    }
}

template <int kBase>
void pyramid(Scene& scene) {
  add_floor(scene, 400);
  add_pyramid(scene, scene.add(box(1, 1, 1)), kBase, 0, 0);
}

void many_pyramids(Scene& scene) {
  add_floor(scene, 400);
  const auto cube = scene.add(box(1, 1, 1));
  for (int row = 0; row < 14; ++row)
    for (int column = 0; column < 14; ++column)
      add_pyramid(scene, cube, 10, 11 * (static_cast<float>(column) - 6.5f), 152.f * static_cast<float>(row) / 13 - 76);
}

void square_pyramid(Scene& scene) {
  scene.gravity = -9.81f;
  add_floor(scene, 100, .2f);
  const auto cube = scene.add(box(2, 2, 2));
  constexpr int kLayers = 15;
  for (int i = 0; i < kLayers; ++i)
    for (int j = i / 2; j < kLayers - (i + 1) / 2; ++j)
      for (int k = i / 2; k < kLayers - (i + 1) / 2; ++k) {
        const Vec at{static_cast<float>(-kLayers + 2 * j + i % 2), 1 + 2.5f * static_cast<float>(i),
                     static_cast<float>(-kLayers + 2 * k + i % 2)};
        scene.add(Body{.shape = cube, .position = at, .friction = .2f});
      }
}

void wall(Scene& scene) {
  add_floor(scene, 200);
  const auto cube = scene.add(box(1, 1, 1)), half = scene.add(box(.5f, 1, 1));
  for (int row = 0; row < 20; ++row) {
    const float y = static_cast<float>(row) + .5f;
    const int odd = row % 2;
    for (int k = 0; k < 40 - odd; ++k)
      scene.add(
          Body{.shape = cube, .position = {static_cast<float>(k + odd) - 19.5f - .5f * odd, y, 0}, .density = 100});
    // an odd row begins and ends with half a cube
    for (const float x : {-19.75f, 19.75f})
      if (odd) scene.add(Body{.shape = half, .position = {x, y, 0}, .density = 100});
  }
}

void columns(Scene& scene) {
  add_floor(scene, 100);
  const auto cube = scene.add(box(1, 1, 1));
  for (int x = -2; x <= 2; ++x)
    for (int z = -2; z <= 2; ++z)
      for (int k = 0; k < 20; ++k)
        scene.add(Body{.shape = cube,
                       .position = {3 * static_cast<float>(x), static_cast<float>(k) + .5f, 3 * static_cast<float>(z)},
                       .density = 100});
}

// A drum of 36 hulls with four paddles, around z.
void add_drum(Scene& scene) {
  constexpr int kSegments = 36;
  constexpr float kPaddle = 14, kInner = 16, kOuter = 18, kHalfLength = 10;
  // an edge of the drum at that angle, between two radii
  const auto edge = [](std::vector<Vec>& points, float angle, float r0, float r1) {
    for (const float r : {r0, r1})
      for (const float z : {-kHalfLength, kHalfLength}) points.push_back({r * std::cos(angle), r * std::sin(angle), z});
  };
  const auto segment = [&](float begin, float end, float r0, float r1) {
    std::vector<Vec> points;
    edge(points, begin, r0, r1), edge(points, end, r0, r1);
    return scene.add(hull(std::move(points)));
  };
  const auto first = static_cast<std::uint32_t>(scene.shapes.size());
  const float width = 2 * kPi / kSegments;
  for (int i = 0; i < kSegments; ++i) {
    const float angle = width * static_cast<float>(i);
    // neighbours overlap by a tenth on either side, so that there is no gap
    segment(angle - .1f * width, angle + 1.1f * width, kInner, kOuter);
    if (i % 9 == 0) segment(angle, angle + width, kPaddle, kInner);
  }
  scene.add(Body{.motion = Motion::kinematic,
                 .shape = first,
                 .shape_count = static_cast<std::uint32_t>(scene.shapes.size()) - first,
                 .position = {0, 21, 0},
                 .angular_velocity = {0, 0, 25 * kPi / 180}});
}

void washer(Scene& scene) {
  scene.sleeping = true;
  add_floor(scene, 120);
  add_drum(scene);
  const auto cube = scene.add(box(.4f, .4f, .4f));
  for (int x = 0; x < 20; ++x)
    for (int y = 0; y < 20; ++y)
      for (int z = 0; z < 20; ++z) {
        const Vec at{.8f * (static_cast<float>(x) - 9.5f), 21 + .8f * (static_cast<float>(y) - 9.5f),
                     .8f * (static_cast<float>(z) - 9.5f)};
        scene.add(Body{.shape = cube, .position = at});
      }
}

// Numerical Recipes' quick generator: the same numbers everywhere.
struct Random {
  std::uint32_t state = 42;
  float next() {  // -1 .. 1
    state = state * 1664525u + 1013904223u;
    return static_cast<float>(state >> 8) / 8388608.f - 1;
  }
};

// Directions evenly over the sphere: in pairs of opposites, so that the centre of mass is the origin.
std::vector<Vec> points_on_sphere(int count, float radius) {
  std::vector<Vec> points;
  Random random;
  while (static_cast<int>(points.size()) < count) {
    const Vec p{random.next(), random.next(), random.next()};
    const float r = length(p);
    if (r > 1 || r < .1f) continue;
    points.push_back(radius / r * p), points.push_back(-radius / r * p);
  }
  return points;
}

void convex_pile(Scene& scene) {
  scene.sleeping = true;
  add_floor(scene, 500);
  const auto rock = scene.add(hull(points_on_sphere(32, 2)));
  for (int layer = 0; layer < 80; ++layer)
    for (int z = 0; z < 8; ++z)
      for (int x = 0; x < 8; ++x)
        scene.add(Body{.shape = rock,
                       .position = {4 * static_cast<float>(x) - 16, 2 + 4 * static_cast<float>(layer),
                                    4 * static_cast<float>(z) - 16}});
}

Shape terrain() {
  constexpr int kCells = 100;
  constexpr float kCell = 3, kHeight = 5;
  Shape mesh{.kind = ShapeKind::mesh};
  for (int z = 0; z <= kCells; ++z)
    for (int x = 0; x <= kCells; ++x)
      mesh.points.push_back({kCell * static_cast<float>(x - kCells / 2),
                             kHeight * std::sin(static_cast<float>(x) / 2) * std::cos(static_cast<float>(z) / 2),
                             kCell * static_cast<float>(z - kCells / 2)});
  const auto point = [](int x, int z) { return static_cast<std::uint32_t>(z * (kCells + 1) + x); };
  for (int z = 0; z < kCells; ++z)
    for (int x = 0; x < kCells; ++x)
      for (const auto p : {point(x, z), point(x, z + 1), point(x + 1, z),  // lower left
                           point(x + 1, z), point(x, z + 1), point(x + 1, z + 1)})
        mesh.triangles.push_back(p);
  return mesh;
}

void convex_vs_mesh(Scene& scene) {
  scene.gravity = -9.81f;
  scene.sleeping = true;
  const Body material{.friction = .5f, .restitution = .6f};
  Body ground = material;
  ground.motion = Motion::fixed, ground.shape = scene.add(terrain());
  scene.add(ground);
  // the square pyramid's centre of mass is a quarter of its height above its base
  const std::uint32_t shapes[] = {
      scene.add(box(1, 1.5f, 2)), scene.add(sphere(.5f)),
      scene.add(Shape{.kind = ShapeKind::capsule, .radius = .5f, .half_segment = .75f}),
      scene.add(hull({{0, .75f, 0}, {1, -.25f, 0}, {-1, -.25f, 0}, {0, -.25f, 1}, {0, -.25f, -1}}))};
  for (int x = -10; x <= 10; ++x)
    for (int y = 0; y < 4; ++y)
      for (int z = -10; z <= 10; ++z) {
        Body body = material;
        body.shape = shapes[y];
        body.position = {7.5f * static_cast<float>(x), 15 + 2 * static_cast<float>(y), 7.5f * static_cast<float>(z)};
        scene.add(body);
      }
}

void joint_grid(Scene& scene) {
  constexpr int kSide = 100;
  const auto ball = scene.add(sphere(.4f));
  for (int row = 0; row < kSide; ++row)
    for (int column = 0; column < kSide; ++column) {
      const Vec at{static_cast<float>(column), static_cast<float>(-row), 0};
      const auto body = scene.add(
          Body{.motion = row == 0 ? Motion::fixed : Motion::dynamic, .shape = ball, .position = at, .collides = false});
      // the top row is static: it needs no joints within itself
      if (row > 0) scene.joints.push_back({body - kSide, body, at + Vec{0, .5f, 0}});
      if (row > 0 && column > 0) scene.joints.push_back({body - 1, body, at - Vec{.5f, 0, 0}});
    }
}

void heavy_chains(Scene& scene) {
  const auto link = scene.add(sphere(.25f)), load = scene.add(sphere(2));
  for (int chain = 0; chain < 20; ++chain)
    for (int k = 0; k <= 20; ++k) {
      const Vec at{.5f * static_cast<float>(k), 0, 6 * static_cast<float>(chain)};
      const auto body = scene.add(Body{.motion = k == 0 ? Motion::fixed : Motion::dynamic,
                                       .shape = k == 20 ? load : link,
                                       .position = at,
                                       .collides = false});
      if (k > 0) scene.joints.push_back({body - 1, body, at - Vec{.25f, 0, 0}});
    }
}

constexpr SceneRow kScenes[] = {{"large_pyramid", 200, pyramid<100>},
                                {"pyramid_50", 100, pyramid<50>},  // how time grows with size
                                {"pyramid_200", 50, pyramid<200>},
                                {"many_pyramids", 100, many_pyramids},
                                {"square_pyramid", 500, square_pyramid},
                                {"wall", 600, wall},
                                {"columns", 600, columns},
                                {"washer", 1000, washer},
                                {"convex_fall", 120, convex_pile},  // the first steps of the next
                                {"convex_pile", 400, convex_pile},
                                {"convex_vs_mesh", 500, convex_vs_mesh},
                                {"joint_grid", 100, joint_grid},
                                {"heavy_chains", 600, heavy_chains}};

}  // namespace

std::span<const SceneRow> scene_rows() { return kScenes; }

const SceneRow* find_scene(std::string_view name) {
  for (const SceneRow& row : kScenes)
    if (row.name == name) return &row;
  return nullptr;
}

}  // namespace rivals
