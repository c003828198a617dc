// Box3D with 4 substeps, which its samples and benchmarks take.
#include <box3d/box3d.h>

#include "engine.h"

namespace rivals {
namespace {

constexpr int kSubsteps = 4;

b3Vec3 to(Vec v) { return {v.x, v.y, v.z}; }

class Box3d final : public Engine {
 public:
  Box3d(const Scene& scene, int threads) : dt_(scene.dt) {
    b3WorldDef desc = b3DefaultWorldDef();
    desc.gravity = {0, scene.gravity, 0};
    desc.enableSleep = scene.sleeping;
    desc.workerCount = static_cast<std::uint32_t>(threads);
    world_ = b3CreateWorld(&desc);
  }
  ~Box3d() override {
    b3DestroyWorld(world_);
    for (b3MeshData* mesh : meshes_) b3DestroyMesh(mesh);
  }

  void build(const Scene& scene) override {
    for (const Body& b : scene.bodies) add(b, scene);
    for (const Joint& j : scene.joints) {
      b3SphericalJointDef desc = b3DefaultSphericalJointDef();
      desc.base.bodyIdA = bodies_[j.a], desc.base.bodyIdB = bodies_[j.b];
      desc.base.localFrameA.p = to(j.anchor - scene.bodies[j.a].position);
      desc.base.localFrameB.p = to(j.anchor - scene.bodies[j.b].position);
      b3CreateSphericalJoint(world_, &desc);
    }
  }

  void step() override { b3World_Step(world_, dt_, kSubsteps); }

  BodyState state(std::size_t body) const override {
    const b3BodyId id = bodies_[body];
    const b3Pos p = b3Body_GetPosition(id);
    const b3Quat q = b3Body_GetRotation(id);
    const b3Vec3 v = b3Body_GetLinearVelocity(id);
    return {{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)},
            {q.v.x, q.v.y, q.v.z, q.s},
            {v.x, v.y, v.z},
            !b3Body_IsAwake(id)};
  }

 private:
  void add(const Body& b, const Scene& scene) {
    b3BodyDef desc = b3DefaultBodyDef();
    desc.type = b.motion == Motion::fixed       ? b3_staticBody
                : b.motion == Motion::kinematic ? b3_kinematicBody
                                                : b3_dynamicBody;
    desc.position = {b.position.x, b.position.y, b.position.z};
    desc.angularVelocity = to(b.angular_velocity);
    const b3BodyId body = b3CreateBody(world_, &desc);
    b3ShapeDef shape = b3DefaultShapeDef();
    shape.density = b.density;
    shape.baseMaterial.friction = b.friction, shape.baseMaterial.restitution = b.restitution;
    if (!b.collides) shape.filter.maskBits = 0;
    for (std::uint32_t k = 0; k < b.shape_count; ++k) add_shape(body, shape, scene.shapes[b.shape + k]);
    bodies_.push_back(body);
  }

  void add_shape(b3BodyId body, const b3ShapeDef& desc, const Shape& s) {
    switch (s.kind) {
      case ShapeKind::box: {
        const b3BoxHull box = b3MakeBoxHull(s.half.x, s.half.y, s.half.z);
        b3CreateHullShape(body, &desc, &box.base);
        break;
      }
      case ShapeKind::sphere: {
        const b3Sphere sphere{{0, 0, 0}, s.radius};
        b3CreateSphereShape(body, &desc, &sphere);
        break;
      }
      case ShapeKind::capsule: {
        const b3Capsule capsule{{0, -s.half_segment, 0}, {0, s.half_segment, 0}, s.radius};
        b3CreateCapsuleShape(body, &desc, &capsule);
        break;
      }
      case ShapeKind::hull: {
        std::vector<b3Vec3> points;
        for (const Vec p : s.points) points.push_back(to(p));
        const int count = static_cast<int>(points.size());
        b3HullData* hull = b3CreateHull(points.data(), count, count);
        b3CreateHullShape(body, &desc, hull);
        b3DestroyHull(hull);
        break;
      }
      case ShapeKind::mesh: add_mesh(body, desc, s); break;
    }
  }

  void add_mesh(b3BodyId body, const b3ShapeDef& desc, const Shape& s) {
    std::vector<b3Vec3> points;
    for (const Vec p : s.points) points.push_back(to(p));
    std::vector<std::int32_t> triangles(s.triangles.begin(), s.triangles.end());
    b3MeshDef mesh{};
    mesh.vertices = points.data(), mesh.vertexCount = static_cast<int>(points.size());
    mesh.indices = triangles.data(), mesh.triangleCount = static_cast<int>(triangles.size() / 3);
    mesh.identifyEdges = true;
    meshes_.push_back(b3CreateMesh(&mesh, nullptr, 0));
    b3CreateMeshShape(body, &desc, meshes_.back(), {1, 1, 1});
  }

  float dt_;
  b3WorldId world_;
  std::vector<b3MeshData*> meshes_;  // which shapes refer to
  std::vector<b3BodyId> bodies_;
};

}  // namespace

const char* const kEngineName = "box3d";
const bool kEngineHasThreads = true;

std::unique_ptr<Engine> make_engine(const Scene& scene, int threads) { return std::make_unique<Box3d>(scene, threads); }

}  // namespace rivals
