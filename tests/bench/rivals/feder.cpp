// feder, as a host sees it: the installed headers and libraries.
#include <feder/rigid.h>
#include <feder/systems.h>
#include <feder/world.h>

#include <cstdio>
#include <set>

#include "engine.h"

namespace rivals {
namespace {

feder::Vec3 to(Vec v) { return {v.x, v.y, v.z}; }
Vec from(const feder::Vec3& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

feder::ShapePtr make(const Shape& s) {
  std::vector<feder::Vec3> points;
  for (const Vec p : s.points) points.push_back(to(p));
  switch (s.kind) {
    case ShapeKind::box: return feder::make_box(2 * s.half.x, 2 * s.half.y, 2 * s.half.z);
    case ShapeKind::sphere: return feder::make_sphere(s.radius);
    case ShapeKind::capsule: return feder::make_capsule(s.radius, 2 * (s.half_segment + s.radius));
    case ShapeKind::hull: return feder::make_hull(points);
    case ShapeKind::mesh: return feder::make_mesh(points, s.triangles);
  }
  return nullptr;
}

const feder::SystemDescriptor* const kSystems[] = {&feder::collide_system(), &feder::rigid_system()};

feder::WorldDesc describe(const Scene& scene, int threads) {
  feder::WorldDesc desc;
  desc.gravity = feder::Vec3(0, scene.gravity, 0);
  desc.dt = scene.dt;
  desc.threads = threads;
  desc.sleeping = scene.sleeping;
  return desc;
}

class Feder final : public Engine {
 public:
  Feder(const Scene& scene, int threads)
      : world_(describe(scene, threads), kSystems), rigid_(world_.need<feder::Rigid>()) {}

  void build(const Scene& scene) override {
    std::vector<feder::ShapePtr> shapes;
    for (const Shape& s : scene.shapes) shapes.push_back(make(s));
    for (const Body& b : scene.bodies) bodies_.push_back(rigid_.add_body(describe_body(b, shapes)));
    for (const Joint& j : scene.joints) {
      feder::JointDesc desc;
      desc.type = "ball";
      desc.a = bodies_[j.a], desc.b = bodies_[j.b];
      desc.anchor_a = to(j.anchor);
      rigid_.add_joint(desc);
    }
  }

  void step() override {
    world_.step();
    // the reader of the figures should know that a limit was exceeded: the first of each kind
    const feder::Events& events = world_.events();
    for (const feder::Event& e : events.list())
      if (e.kind == feder::EventKind::warning && warned_.insert(events.warning_code(e)).second)
        std::fprintf(stderr, "feder, step %zu: %s\n", static_cast<std::size_t>(world_.step_count()),
                     events.warning_message(e).c_str());
  }

  BodyState state(std::size_t body) const override {
    const feder::ObjectId id = bodies_[body];
    const feder::Pose pose = rigid_.pose(id);
    const feder::Quat q = pose.rotation;
    return {from(pose.position),
            {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z), static_cast<float>(q.w)},
            from(rigid_.velocity(id)),
            rigid_.asleep(id)};
  }

 private:
  static feder::BodyDesc describe_body(const Body& b, const std::vector<feder::ShapePtr>& shapes) {
    feder::BodyDesc desc;
    desc.type = b.motion == Motion::fixed       ? feder::BodyType::fixed
                : b.motion == Motion::kinematic ? feder::BodyType::kinematic
                                                : feder::BodyType::dynamic;
    std::vector<feder::CompoundPart> parts;
    for (std::uint32_t k = 0; k < b.shape_count; ++k) parts.push_back({shapes[b.shape + k], {}});
    desc.shape = parts.size() == 1 ? parts[0].shape : feder::make_compound(parts);
    desc.position = to(b.position);
    desc.angular_velocity = to(b.angular_velocity);
    desc.density = b.density;
    desc.friction_static = desc.friction_dynamic = b.friction;
    desc.restitution = b.restitution;
    if (!b.collides) desc.mask = 0;
    return desc;
  }

  feder::World world_;
  feder::Rigid& rigid_;
  std::vector<feder::ObjectId> bodies_;
  std::set<std::string> warned_;
};

}  // namespace

const char* const kEngineName = "feder";
const bool kEngineHasThreads = true;

std::unique_ptr<Engine> make_engine(const Scene& scene, int threads) { return std::make_unique<Feder>(scene, threads); }

}  // namespace rivals
