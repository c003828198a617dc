// Implicit Euler step of a chain of points (Baraff and Witkin 1998) by Newton's method, each step of which solves the
// linear system along the chain directly: neighbours alone interact, so it is block tridiagonal, with bending block
// pentadiagonal (Golub and Van Loan 2013, 4.3). Stretch acts along segments, bending by the change of direction at
// points (E I/l per radian), both with Kelvin-Voigt damping of the strain rate. Contact rows of the step are part of
// the system, by the augmented Lagrangian of normal and Coulomb friction forces (Alart and Curnier 1991) with
// semismooth Newton steps: forces go on from those of the solver substep before, so that at rest nothing penetrates and
// nothing creeps, and a load that hangs from friction is carried whatever its mass. One update of the forces per solver
// substep. Kept between calls: work memory; the forces of contacts by the caller. Weak spot: contacts between surfaces
// are not in the system; where many contacts start to press or slip at once, Newton's method takes about eight steps.
#pragma once
#include "base/double3.h"
#include "feder/memory.h"

namespace feder {

inline constexpr double kPushSpeed = 1;  // m/s, at which penetration from before is undone

struct Block3 {  // 3 x 3, by rows
  double m[9];
};

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
  void add_segments(const ChainStep& s);
  void add_hinges(const ChainStep& s);
  void add_hinge(const ChainStep& s, std::uint32_t middle);
  void add_clamp(const ChainStep& s, bool last);
  void add_contact(const ChainStep& s, ChainContact& c, bool finish);
  double correct(const ChainStep& s, double longest);
  bool held(const ChainStep& s, std::uint32_t i) const;

  Array<Double3> end_{&arena_}, residual_{&arena_};
  // blocks of row i: with points i, i + 1, i + 2, and with points i - 1, i - 2
  Array<Block3> diagonal_{&arena_}, upper_{&arena_}, upper2_{&arena_}, lower_{&arena_}, lower2_{&arena_};
  double last_ = 0, share_ = 1;  // the last correction, m; the share of it that was taken
  bool wide_ = false;            // it bends: five blocks a row
};

}  // namespace feder
