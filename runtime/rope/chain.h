// Implicit Euler step of a chain of points (Baraff and Witkin 1998) by Newton's method, each step of which solves the
// linear system along the chain directly: neighbours alone interact, so it is block tridiagonal, with bending block
// pentadiagonal (Golub and Van Loan 2013, 4.3). Stretch acts along segments, bending by the change of direction at
// points (E I/l per radian), both with Kelvin-Voigt damping of the strain rate. Contact rows of the step are part of
// the system, by the augmented Lagrangian of normal and Coulomb friction forces (Alart and Curnier 1991) with
// semismooth Newton steps: forces go on from those of the solver substep before, so that at rest nothing penetrates and
// nothing creeps, and a load that hangs from friction is carried whatever its mass. One update of the forces per solver
// substep, which takes penalties that are not soft beside the rope round a post. Where steps go round in a circle,
// which they may as Coulomb's friction has no potential, friction limits are held for a while: then the step has one
// (chain_energy.cpp), which every correction lessens (Armijo 1966). Kept between calls: work memory; the forces of
// contacts by the caller. Weak spot: contacts between surfaces are not in the system, so a rope that lies on itself
// takes about twenty steps; so does one that starts folded and stiff.
#pragma once
#include "base/double3.h"
#include "feder/memory.h"

namespace feder {

inline constexpr double kPushSpeed = 1;  // m/s, at which penetration from before is undone

struct Block3 {  // 3 x 3, by rows
  double m[9];
};
inline Double3 times(const Block3& a, const Double3& x) {
  return {a.m[0] * x.x + a.m[1] * x.y + a.m[2] * x.z, a.m[3] * x.x + a.m[4] * x.y + a.m[5] * x.z,
          a.m[6] * x.x + a.m[7] * x.y + a.m[8] * x.z};
}

// Contact of a point of the chain, or of one between two.
struct ChainContact {
  std::uint32_t first = 0;  // the point, and the next where weight[1] is not 0
  double weight[2] = {1, 0};
  Double3 normal{0, 0, 0};  // unit, towards the rope
  double gap = 0;           // m, where the solver substep began, less the approach of the other side in it
  double start_gap = 0;     // m, where it began
  Double3 shift{0, 0, 0};   // m, of the other side's surface in the solver substep
  double friction = 0;
  double compliance[2] = {0, 0};  // m/N, of the other side: along the normal and across
  Double3 force{0, 0, 0};         // on the rope, N: that of the solver substep before, then of this one
  double pressed = 0;             // its part along the normal
  double limit = 0;               // of friction, where it is held, N
  std::uint32_t row = 0;          // for the caller
};

// A mass that moves with a point: of a body that hangs from it, as that answers to pushes there.
struct ChainLoad {
  std::uint32_t point = 0;
  Block3 mass{};                 // kg
  Double3 shift{0, 0, 0};        // m, its way in the solver substep without the rope
  std::uint32_t attachment = 0;  // for the caller
};

struct ChainStep {
  double h = 0;                                   // s
  double stretch = 0, bend = 0;                   // N, N m^2
  double damping = 0;                             // s
  std::uint32_t count = 0;                        // of points
  const Real* rest_length = nullptr;              // m, by segment
  const double* mass = nullptr;                   // kg, by point; infinite: does not move
  bool clamped[2] = {false, false};               // the first and the last segment keep a direction
  Double3 direction[2] = {{0, 0, 0}, {0, 0, 0}};  // unit
};

class Chain {
  Arena& arena_;

 public:
  explicit Chain(Arena& a) : arena_(a) {}
  // Points where the solver substep begins (m, any origin), where they would be without forces inside, and the first
  // guess of where they end.
  void resize(std::uint32_t count);
  Array<Double3> start{&arena_}, target{&arena_}, guess{&arena_};
  // Answers where the points end, and fills in the impulses of the contacts. Contacts come in any order.
  const Array<Double3>& solve(const ChainStep& s, Array<ChainContact>& contacts, const Array<ChainLoad>& loads);
  int iterations = 0;  // of the last solve
  double missed = 0;   // m, the last correction of Newton's method

 private:
  struct Press {              // of a contact, by the points
    double k[2] = {};         // N/m
    double normal = 0;        // force, N
    Double3 wanted{0, 0, 0};  // friction if it stuck, N
    double holding = 0;       // length of that
    double most = 0;          // it may have
  };
  bool press(const ChainStep& s, const ChainContact& c, const Array<Double3>& x, Press& out) const;
  void assemble(const ChainStep& s, const Array<ChainContact>& contacts, const Array<ChainLoad>& loads);
  void add_segments(const ChainStep& s);
  void add_hinges(const ChainStep& s);
  void add_hinge(const ChainStep& s, std::uint32_t middle);
  void add_clamp(const ChainStep& s, bool last);
  void add_contact(const ChainStep& s, const ChainContact& c);
  void finish(const ChainStep& s, ChainContact& c) const;
  bool renew_limits(const ChainStep& s, Array<ChainContact>& contacts);
  double eliminate(const ChainStep& s);
  double damped_share(double most);
  double descending_share(const ChainStep& s, const Array<ChainContact>& contacts, const Array<ChainLoad>& loads,
                          double share);
  bool held(const ChainStep& s, std::uint32_t i) const;
  // chain_energy.cpp
  double hinge_stiffness(const ChainStep& s, std::uint32_t middle) const;
  double clamp_stiffness(const ChainStep& s, bool last) const;
  double angle_at(const ChainStep& s, std::uint32_t i, const Array<Double3>& x) const;
  void remember_bends(const ChainStep& s);
  double potential(const ChainStep& s, const Array<ChainContact>& contacts, const Array<ChainLoad>& loads,
                   const Array<Double3>& x) const;

  Array<Double3> end_{&arena_}, residual_{&arena_}, pull_{&arena_}, trial_{&arena_};
  Array<double> bent_{&arena_};  // angles where the solver substep begins
  // blocks of row i: with points i, i + 1, i + 2, and with points i - 1, i - 2
  Array<Block3> diagonal_{&arena_}, upper_{&arena_}, upper2_{&arena_}, lower_{&arena_}, lower2_{&arena_};
  double last_ = 0, share_ = 1;  // the last correction, m; the share of it that was taken
  bool wide_ = false;            // it bends: five blocks a row
  bool hold_limits_ = false;     // of friction
};

}  // namespace feder
