// Bullet, as Debian packages it: single precision, one thread, 10 iterations.
#include <LinearMath/btConvexHullComputer.h>
#include <btBulletCollisionCommon.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>

#include "engine.h"

namespace rivals {
namespace {

btVector3 to(Vec v) { return {v.x, v.y, v.z}; }
Vec from(const btVector3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}
btTransform at(Vec position) { return btTransform(btQuaternion::getIdentity(), to(position)); }

// Pairs multiply these two coefficients, where the other engines take the geometric mean or the larger: the square root
// gives pairs of equal bodies what the scene says.
btScalar of_pair(float coefficient) { return std::sqrt(coefficient); }

// Bullet wants masses, and has no volumes: by tetrahedra from the origin to the triangles of each face.
btScalar hull_volume(const Shape& s) {
  btConvexHullComputer hull;
  hull.compute(&s.points[0].x, sizeof(Vec), static_cast<int>(s.points.size()), 0, 0);
  btScalar six = 0;
  for (int face = 0; face < hull.faces.size(); ++face) {
    const auto* first = &hull.edges[hull.faces[face]];
    const btVector3 a = hull.vertices[first->getSourceVertex()];
    for (const auto* e = first->getNextEdgeOfFace(); e->getTargetVertex() != first->getSourceVertex();
         e = e->getNextEdgeOfFace())
      six += a.dot(hull.vertices[e->getSourceVertex()].cross(hull.vertices[e->getTargetVertex()]));
  }
  return std::fabs(six) / 6;
}

btScalar volume(const Shape& s) {
  const btScalar r = s.radius;
  switch (s.kind) {
    case ShapeKind::box: return 8 * s.half.x * s.half.y * s.half.z;
    case ShapeKind::sphere: return 4 * SIMD_PI / 3 * r * r * r;
    case ShapeKind::capsule: return SIMD_PI * r * r * (4 * r / 3 + 2 * s.half_segment);
    case ShapeKind::hull: return hull_volume(s);
    case ShapeKind::mesh: return 0;
  }
  return 0;
}

class Bullet final : public Engine {
 public:
  explicit Bullet(const Scene& scene) : dt_(scene.dt), sleeping_(scene.sleeping) {
    world_.setGravity({0, scene.gravity, 0});
  }
  ~Bullet() override {
    for (const auto& j : joints_) world_.removeConstraint(j.get());
    for (const auto& b : bodies_) world_.removeRigidBody(b.get());
  }

  void build(const Scene& scene) override {
    for (const Shape& s : scene.shapes) shapes_.push_back(make(s)), volumes_.push_back(volume(s));
    for (const Body& b : scene.bodies) add(b);
    for (const Joint& j : scene.joints) {
      const Vec a = j.anchor - scene.bodies[j.a].position, b = j.anchor - scene.bodies[j.b].position;
      joints_.push_back(std::make_unique<btPoint2PointConstraint>(*bodies_[j.a], *bodies_[j.b], to(a), to(b)));
      world_.addConstraint(joints_.back().get(), true);
    }
  }

  void step() override {
    // kinematic bodies are placed by the host, which gives them their velocity
    for (const auto& [body, angular_velocity] : kinematic_) {
      const btQuaternion turn(angular_velocity.normalized(), angular_velocity.length() * dt_);
      btTransform pose = body->getWorldTransform();
      pose.setRotation(turn * pose.getRotation());
      body->setWorldTransform(pose);
    }
    world_.stepSimulation(dt_, 0);
  }

  BodyState state(std::size_t body) const override {
    const btRigidBody& b = *bodies_[body];
    const btQuaternion q = b.getWorldTransform().getRotation();
    return {
        from(b.getWorldTransform().getOrigin()),
        {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()), static_cast<float>(q.w())},
        from(b.getLinearVelocity()),
        b.getActivationState() == ISLAND_SLEEPING};
  }

 private:
  std::unique_ptr<btCollisionShape> make(const Shape& s) {
    switch (s.kind) {
      case ShapeKind::box: return std::make_unique<btBoxShape>(to(s.half));
      case ShapeKind::sphere: return std::make_unique<btSphereShape>(s.radius);
      case ShapeKind::capsule: return std::make_unique<btCapsuleShape>(s.radius, 2 * s.half_segment);
      case ShapeKind::hull: {
        auto hull = std::make_unique<btConvexHullShape>();
        for (const Vec p : s.points) hull->addPoint(to(p), false);
        hull->recalcLocalAabb();
        return hull;
      }
      case ShapeKind::mesh: {
        auto mesh = std::make_unique<btTriangleMesh>();
        for (std::size_t k = 0; k < s.triangles.size(); k += 3)
          mesh->addTriangle(to(s.points[s.triangles[k]]), to(s.points[s.triangles[k + 1]]),
                            to(s.points[s.triangles[k + 2]]));
        meshes_.push_back(std::move(mesh));
        return std::make_unique<btBvhTriangleMeshShape>(meshes_.back().get(), true);
      }
    }
    return nullptr;
  }

  btCollisionShape* shape_of(const Body& b) {
    if (b.shape_count == 1) return shapes_[b.shape].get();
    auto compound = std::make_unique<btCompoundShape>();
    for (std::uint32_t k = 0; k < b.shape_count; ++k)
      compound->addChildShape(btTransform::getIdentity(), shapes_[b.shape + k].get());
    compounds_.push_back(std::move(compound));
    return compounds_.back().get();
  }

  void add(const Body& b) {
    btCollisionShape* shape = shape_of(b);
    btScalar mass = 0;
    btVector3 inertia(0, 0, 0);
    if (b.motion == Motion::dynamic) {
      mass = b.density * volumes_[b.shape];
      shape->calculateLocalInertia(mass, inertia);
    }
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, inertia);
    info.m_startWorldTransform = at(b.position);
    info.m_friction = of_pair(b.friction), info.m_restitution = of_pair(b.restitution);
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody& body = *bodies_.back();
    if (b.motion == Motion::kinematic) {
      body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
      kinematic_.push_back({&body, to(b.angular_velocity)});
    }
    if (b.motion == Motion::kinematic || !sleeping_) body.setActivationState(DISABLE_DEACTIVATION);
    if (b.collides)
      world_.addRigidBody(&body);
    else
      world_.addRigidBody(&body, 0, 0);
  }

  btScalar dt_;
  bool sleeping_;
  std::vector<std::unique_ptr<btTriangleMesh>> meshes_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btCompoundShape>> compounds_;
  std::vector<btScalar> volumes_;  // of shapes, m^3
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btPoint2PointConstraint>> joints_;
  std::vector<std::pair<btRigidBody*, btVector3>> kinematic_;  // with angular velocities, rad/s
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
};

}  // namespace

const char* const kEngineName = "bullet";
const bool kEngineHasThreads = false;

std::unique_ptr<Engine> make_engine(const Scene& scene, int) { return std::make_unique<Bullet>(scene); }

}  // namespace rivals
