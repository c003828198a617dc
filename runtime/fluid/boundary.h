// Boundary of fluids: solids as shapes with poses and velocities. A coupling (or a test) fills it before the fluid's
// passes of a substep; the fluid adds its impulses to the bodies' velocities as it goes, so that each next iteration
// meets the solid where it is by then.
#pragma once
#include "base/checks.h"
#include "feder/memory.h"
#include "feder/object.h"
#include "feder/shape.h"

namespace feder {

struct BoundaryBody {
  ObjectId object;
  Vec3 center = Vec3::Zero();            // centre of mass, world, m
  Vec3 start = Vec3::Zero();             // center at the start of the substep, m
  Vec3 velocity = Vec3::Zero();          // m/s
  Vec3 angular_velocity = Vec3::Zero();  // rad/s
  Vec3 inv_mass = Vec3::Zero();          // by world axis, 1/kg; zero: the fluid does not move it
  Mat3 inv_inertia = Mat3::Zero();       // world, 1/(kg m^2)
  std::uint32_t solver_index = 0;        // in SolverBodies, for the coupling
  bool dynamic = false;
  Real contact_weight = 0;      // sum over its contacts of the slope of their density term, 1/m
  Vec3 impulse = Vec3::Zero();  // of the fluid since the boundary was filled, N s; of bodies that the fluid does not
                                // move only where Boundary::weighed
  Real pressed = 0;             // sum of the magnitudes of the impulses in this step, N s

  Vec3 velocity_at(const Vec3& x) const { return velocity + cross(angular_velocity, x - center); }
  void push(const Vec3& at, const Vec3& p) {
    push_by(p, cross(at - center, p));  // bodies that do not move only count impulses, where Boundary::weighed
  }
  // An impulse given as its parts.
  void push_by(const Vec3& linear, const Vec3& about_center) {
    FEDER_ASSERT(dynamic);
    velocity += inv_mass.cwiseProduct(linear);
    angular_velocity += inv_inertia * about_center;
    impulse += linear;
    pressed += length(linear);
  }
  // Change of velocity along n at x per impulse along n there, 1/kg.
  Real response(const Vec3& x, const Vec3& n) const {
    const Vec3 arm = cross(x - center, n);
    return dot(n, inv_mass.cwiseProduct(n)) + dot(arm, inv_inertia * arm);
  }
};

struct BoundaryShape {
  const Shape* shape = nullptr;
  std::uint32_t body = 0;  // in Boundary::bodies
  std::uint32_t group = 1, mask = 0xffffffffu;
  Pose local;         // in the centre-of-mass frame of the body
  Pose pose;          // now, world
  Pose start;         // at the start of the substep
  bool away = false;  // pose is not start
  Aabb box;           // of the pose, world

  // Largest speed of its points by the rotation of its body, m/s.
  Real rim_speed(const BoundaryBody& b) const {
    return b.angular_velocity.isZero(0) ? Real(0) : length(b.angular_velocity) * shape->extent(Vec3::Zero());
  }
};

// Upper bound of the way of any point of a shape from one pose to another, m.
Real largest_motion(const Shape& shape, const Pose& a, const Pose& b);

// Contact state of a fluid and a body in a step.
struct FluidContactState {
  ObjectId fluid, body;
  std::uint32_t count = 0;     // particles in contact when contacts were last found
  Real speed = 0;              // largest closing speed of a particle, m/s
  Vec3 point = Vec3::Zero();   // mean of their positions, m
  Vec3 normal = Vec3::Zero();  // mean, out of the body
};

// Contact of a particle: the tangent plane at the nearest point of the boundary when the contact was made.
struct BoundaryContact {
  std::uint32_t shape = 0, particle = 0;
  Vec3 normal = Vec3::Zero();        // out of the solid, world
  Real offset = 0;                   // normal . x on the plane, m
  Vec3 from = Vec3::Zero();          // the particle's position then, in the frame of the shape
  Vec3 local_normal = Vec3::Zero();  // likewise
  Real local_offset = 0;             // m
  Real impulse = 0;                  // along the normal on the particle, of the running iteration, N s

  Real distance(const Vec3& x) const { return dot(normal, x) - offset; }
};

// Shapes and bodies in the order in which the coupling adds them, which is always the same.
struct Boundary {
  explicit Boundary(Arena& a) : shapes(&a), bodies(&a) {}
  // Takes the present poses as those of the start of the substep.
  void start();
  // Poses at an inner time of the substep, s since its start: from the pose there and the velocity now, so that a
  // loop finds them where it began however often it runs.
  void move_to(Real seconds);
  Array<BoundaryShape> shapes;
  Array<BoundaryBody> bodies;
  BoundaryBody& body_of(const BoundaryContact& c) { return bodies[shapes[c.shape].body]; }
  const BoundaryBody& body_of(const BoundaryContact& c) const { return bodies[shapes[c.shape].body]; }
  bool away = false;     // a pose is not that of the start
  bool weighed = false;  // impulses on bodies that do not move are counted as well
};

}  // namespace feder
