// Jolt with its default settings: 10 velocity and 2 position iterations, one collision step.
#include <Jolt/Jolt.h>
// Jolt.h comes first
#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemThreadPool.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/Collision/Shape/CapsuleShape.h>
#include <Jolt/Physics/Collision/Shape/ConvexHullShape.h>
#include <Jolt/Physics/Collision/Shape/MeshShape.h>
#include <Jolt/Physics/Collision/Shape/SphereShape.h>
#include <Jolt/Physics/Collision/Shape/StaticCompoundShape.h>
#include <Jolt/Physics/Constraints/PointConstraint.h>
#include <Jolt/Physics/PhysicsSettings.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>

#include <cstdio>
#include <cstdlib>

#include "engine.h"

namespace rivals {
namespace {

// Object layers, which are also those of the broad phase but for the last.
enum Layer : JPH::ObjectLayer { kStill, kMoving, kApart };  // apart: collides with nothing

class BroadPhaseLayers final : public JPH::BroadPhaseLayerInterface {
 public:
  JPH::uint GetNumBroadPhaseLayers() const override { return 2; }
  JPH::BroadPhaseLayer GetBroadPhaseLayer(JPH::ObjectLayer layer) const override {
    return JPH::BroadPhaseLayer(layer == kStill ? 0 : 1);
  }
};

class LayerVsBroadPhase final : public JPH::ObjectVsBroadPhaseLayerFilter {
 public:
  bool ShouldCollide(JPH::ObjectLayer layer, JPH::BroadPhaseLayer other) const override {
    return layer == kMoving || (layer == kStill && other == JPH::BroadPhaseLayer(1));
  }
};

class LayerPairs final : public JPH::ObjectLayerPairFilter {
 public:
  bool ShouldCollide(JPH::ObjectLayer a, JPH::ObjectLayer b) const override {
    return a != kApart && b != kApart && (a == kMoving || b == kMoving);
  }
};

// Types are registered before, and unregistered after, anything else of Jolt exists.
struct Registered {
  Registered() {
    JPH::RegisterDefaultAllocator();
    JPH::Factory::sInstance = new JPH::Factory();
    JPH::RegisterTypes();
  }
  ~Registered() {
    JPH::UnregisterTypes();
    delete JPH::Factory::sInstance;
    JPH::Factory::sInstance = nullptr;
  }
};

JPH::Vec3 to(Vec v) { return {v.x, v.y, v.z}; }

JPH::RefConst<JPH::Shape> made(const JPH::ShapeSettings& settings) {
  const JPH::ShapeSettings::ShapeResult result = settings.Create();
  if (result.HasError()) std::fprintf(stderr, "jolt: %s\n", result.GetError().c_str()), std::exit(1);
  return result.Get();
}

JPH::RefConst<JPH::Shape> make(const Shape& s) {
  switch (s.kind) {
    case ShapeKind::box: return new JPH::BoxShape(to(s.half));
    case ShapeKind::sphere: return new JPH::SphereShape(s.radius);
    case ShapeKind::capsule: return new JPH::CapsuleShape(s.half_segment, s.radius);
    case ShapeKind::hull: {
      JPH::Array<JPH::Vec3> points;
      for (const Vec p : s.points) points.push_back(to(p));
      return made(JPH::ConvexHullShapeSettings(points));
    }
    case ShapeKind::mesh: {
      JPH::VertexList points;
      for (const Vec p : s.points) points.push_back({p.x, p.y, p.z});
      JPH::IndexedTriangleList triangles;
      for (std::size_t k = 0; k < s.triangles.size(); k += 3)
        triangles.push_back({s.triangles[k], s.triangles[k + 1], s.triangles[k + 2]});
      return made(JPH::MeshShapeSettings(points, triangles));
    }
  }
  return nullptr;
}

class Jolt final : public Engine {
 public:
  Jolt(const Scene& scene, int threads)
      : sleeping_(scene.sleeping), dt_(scene.dt), jobs_(JPH::cMaxPhysicsJobs, JPH::cMaxPhysicsBarriers, threads - 1),
        temporary_(kTemporaryBytes) {
    const auto bodies = static_cast<JPH::uint>(scene.bodies.size());
    system_.Init(bodies, 0, kMaxPairs, kMaxContacts, layers_, layer_vs_broad_phase_, layer_pairs_);
    system_.SetGravity({0, scene.gravity, 0});
  }

  void build(const Scene& scene) override {
    std::vector<JPH::RefConst<JPH::Shape>> shapes;
    for (const Shape& s : scene.shapes) shapes.push_back(make(s));
    for (const Body& b : scene.bodies) add(b, shapes);
    for (const Joint& j : scene.joints) {
      JPH::PointConstraintSettings settings;
      settings.mPoint1 = settings.mPoint2 = JPH::RVec3(to(j.anchor));
      system_.AddConstraint(settings.Create(*bodies_[j.a], *bodies_[j.b]));
    }
    system_.OptimizeBroadPhase();
  }

  void step() override {
    if (system_.Update(dt_, 1, &temporary_, &jobs_) != JPH::EPhysicsUpdateError::None)
      std::fprintf(stderr, "jolt: more contacts than it was given room for\n"), std::exit(1);
  }

  BodyState state(std::size_t body) const override {
    const JPH::Body& b = *bodies_[body];
    const JPH::RVec3 p = b.GetPosition();
    const JPH::Quat q = b.GetRotation();
    const JPH::Vec3 v = b.IsStatic() ? JPH::Vec3::sZero() : b.GetLinearVelocity();
    return {{static_cast<float>(p.GetX()), static_cast<float>(p.GetY()), static_cast<float>(p.GetZ())},
            {q.GetX(), q.GetY(), q.GetZ(), q.GetW()},
            {v.GetX(), v.GetY(), v.GetZ()},
            !b.IsActive()};
  }

 private:
  // Room for the largest scene.
  static constexpr JPH::uint kTemporaryBytes = 256u << 20, kMaxPairs = 1u << 18, kMaxContacts = 1u << 17;

  void add(const Body& b, const std::vector<JPH::RefConst<JPH::Shape>>& shapes) {
    JPH::RefConst<JPH::Shape> shape = shapes[b.shape];
    if (b.shape_count > 1) {
      JPH::StaticCompoundShapeSettings parts;
      for (std::uint32_t k = 0; k < b.shape_count; ++k)
        parts.AddShape(JPH::Vec3::sZero(), JPH::Quat::sIdentity(), shapes[b.shape + k]);
      shape = made(parts);
    }
    const bool still = b.motion == Motion::fixed;
    JPH::BodyCreationSettings settings(shape, JPH::RVec3(to(b.position)), JPH::Quat::sIdentity(), motion(b.motion),
                                       !b.collides ? kApart
                                       : still     ? kStill
                                                   : kMoving);
    settings.mFriction = b.friction, settings.mRestitution = b.restitution;
    settings.mAngularVelocity = to(b.angular_velocity);
    settings.mAllowSleeping = sleeping_;
    if (b.motion == Motion::dynamic) {
      settings.mOverrideMassProperties = JPH::EOverrideMassProperties::CalculateInertia;
      // shapes are made with Jolt's density of 1000 kg/m^3
      settings.mMassPropertiesOverride.mMass = shape->GetMassProperties().mMass * b.density / 1000;
    }
    JPH::BodyInterface& bodies = system_.GetBodyInterfaceNoLock();
    JPH::Body* body = bodies.CreateBody(settings);
    bodies.AddBody(body->GetID(), still ? JPH::EActivation::DontActivate : JPH::EActivation::Activate);
    bodies_.push_back(body);
  }

  static JPH::EMotionType motion(Motion m) {
    return m == Motion::fixed       ? JPH::EMotionType::Static
           : m == Motion::kinematic ? JPH::EMotionType::Kinematic
                                    : JPH::EMotionType::Dynamic;
  }

  Registered registered_;
  bool sleeping_;
  float dt_;
  JPH::JobSystemThreadPool jobs_;
  JPH::TempAllocatorImpl temporary_;
  BroadPhaseLayers layers_;
  LayerVsBroadPhase layer_vs_broad_phase_;
  LayerPairs layer_pairs_;
  JPH::PhysicsSystem system_;
  std::vector<JPH::Body*> bodies_;
};

}  // namespace

const char* const kEngineName = "jolt";
const bool kEngineHasThreads = true;

std::unique_ptr<Engine> make_engine(const Scene& scene, int threads) { return std::make_unique<Jolt>(scene, threads); }

}  // namespace rivals
