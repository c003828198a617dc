// What holds a fluid: solids as shapes with poses and velocities. Filled by a coupling (or a test) before the fluid's
// passes of a substep; the fluid adds its impulses to the bodies' velocities as it goes, so that each next iteration
// meets the wall where it is by then.
#pragma once
#include "base/checks.h"
#include "feder/memory.h"
#include "feder/object.h"
#include "feder/shape.h"

namespace feder {

struct BoundaryBody {
  ObjectId object;
  Vec3 center = Vec3::Zero();            // centre of mass, world, m
  Vec3 start = Vec3::Zero();             // where it was at the start of the substep, m
  Vec3 velocity = Vec3::Zero();          // m/s
  Vec3 angular_velocity = Vec3::Zero();  // rad/s
  Vec3 inv_mass = Vec3::Zero();          // by world axis, 1/kg; zero: is not moved by the fluid
  Mat3 inv_inertia = Mat3::Zero();       // world, 1/(kg m^2)
  std::uint32_t solver_index = 0;        // in SolverBodies, for the coupling
  bool dynamic = false;
  Real contact_weight = 0;      // sum of the weights by which particles press on it, 1/m
  Vec3 impulse = Vec3::Zero();  // given by the fluid since the walls were filled, N s; of what the fluid does not move
                                // only where Walls::weighed
  Real pressed = 0;             // sum of the sizes of the impulses in this step, N s

  Vec3 velocity_at(const Vec3& x) const { return velocity + cross(angular_velocity, x - center); }
  void push(const Vec3& at, const Vec3& p) {
    FEDER_ASSERT(dynamic);  // the others take impulses only, where they are weighed
    const Vec3 t = cross(at - center, p);
    velocity += inv_mass.cwiseProduct(p);
    angular_velocity += inv_inertia * t;
    impulse += p;
    pressed += length(p);
  }
  // Change of velocity along n at x per impulse along n there, 1/kg.
  Real response(const Vec3& x, const Vec3& n) const {
    const Vec3 arm = cross(x - center, n);
    return dot(n, inv_mass.cwiseProduct(n)) + dot(arm, inv_inertia * arm);
  }
};

struct BoundaryShape {
  const Shape* shape = nullptr;
  std::uint32_t body = 0;  // in Walls::bodies
  std::uint32_t group = 1, mask = 0xffffffffu;
  Pose local;         // in the centre-of-mass frame of the body
  Pose pose;          // now, world
  Pose start;         // at the start of the substep
  bool away = false;  // from there
  Aabb box;           // of the pose, world
};

// What particles of a fluid did at a body in a step.
struct FluidContactState {
  ObjectId fluid, body;
  std::uint32_t count = 0;     // particles beside it when walls were last looked for
  Real speed = 0;              // largest at which one came towards it, m/s
  Vec3 point = Vec3::Zero();   // mean of their places, m
  Vec3 normal = Vec3::Zero();  // mean, out of the body
};

// Walls are sorted as the coupling adds them: always in the same order.
struct Boundary {
  explicit Boundary(Arena& a) : shapes(&a), bodies(&a) {}
  // The substep starts where they stand.
  void start();
  // Poses at an inner time of the substep, s since its start: from the pose there and the velocity now, so that a
  // loop finds them where it began however often it runs.
  void move_to(Real seconds);
  Array<BoundaryShape> shapes;
  Array<BoundaryBody> bodies;
  bool away = false;     // from the start
  bool weighed = false;  // the coupling wants to know what all walls took, also those that do not move
};

// A particle near a wall: the plane through the nearest point of the wall when the contact was made.
struct BoundaryContact {
  std::uint32_t shape = 0, particle = 0;
  Vec3 normal = Vec3::Zero();        // out of the wall, world
  Real offset = 0;                   // normal . x on the plane, m
  Vec3 from = Vec3::Zero();          // the particle's place then, in the frame of the shape
  Vec3 local_normal = Vec3::Zero();  // likewise
  Real local_offset = 0;             // m
  Real impulse = 0;                  // along the normal on the particle, of the running iteration, N s
};

}  // namespace feder
