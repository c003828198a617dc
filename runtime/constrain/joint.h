// Joint kinds: each is one file that fills constraint rows (value, Jacobian, softness, bounds); it knows no solver, and
// solvers know no kinds. One feder_variant(constrain <kind>) line each. Contract, checked for every kind by
// tests/constrain/test_joint_contract.cpp: Jacobians match finite differences of the value, `bend` of stiff
// equalities between points matches what is left of a difference over h, the row count of given options never changes,
// equal and opposite impulses (momentum), both solvers hold the joint.
#pragma once
#include <span>

#include "base/registry.h"
#include "feder/joint.h"
#include "feder/object.h"
#include "feder/types.h"
#include "state/rows.h"

namespace feder {

inline constexpr int kMaxJointRows = 10;

// Geometry and options of a joint. Frames are in the centre-of-mass frames of the bodies; the x axis of a frame is the
// joint's axis.
struct JointShape {
  Pose frame_a, frame_b;
  JointOptions options;
};

// Motion of a body in the coming substep, for Row::bend.
struct BodyMotion {
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();  // m/s, rad/s
  Mat3 bend = Mat3::Zero();                                       // m/s of an anchor, by its arm in m: see bend_matrix
};

// Displacement of an arm rotated by h w, beyond its straight motion with angular velocity `start` for a time h, over h:
//   h (1 - cos x)/x^2 w x (w x arm) + (sin x / x - 1) w x arm + (w - start) x arm,  x = h |w|  (Rodrigues),
// with factors that are exact to x^2 and stay bounded.
Mat3 bend_matrix(const Vec3& start, const Vec3& w, Real h);

// Poses of the centres of mass now (world: identity), the solver indices, and motions where Row::bend is wanted.
struct JointInput {
  const JointShape* joint = nullptr;
  Pose a, b;
  std::uint32_t index_a = 0, index_b = 0;
  const BodyMotion *motion_a = nullptr, *motion_b = nullptr;  // both or none
  Real h = 0;                                                 // s, length of the substep
};

// Collects the rows of one joint. `block(n)` opens a block of n rows that are solved together.
class RowWriter {
 public:
  RowWriter(Array<Row>& rows, Array<RowBlock>& blocks) : rows_(rows), blocks_(blocks) {}
  void start(const JointInput& in, std::uint32_t joint);
  Row* block(int count);  // `count` default rows in sequence; valid until the next call
  int rows_written() const { return written_; }

 private:
  Array<Row>& rows_;
  Array<RowBlock>& blocks_;
  RowBlock open_;
  int written_ = 0;
};

// Rows that solvers may evaluate themselves, many joints at a time, in place of fill(): a promise about what fill()
// writes.
//  none:  nothing is promised;
//  point: one block of three stiff rows, those of fill_point_rows (frames.h): C = anchor b - anchor a by world axis.
enum class WideRows : std::uint8_t { none, point };

struct JointKind {
  const char* name;
  const char* summary;
  // Fills the rows for the poses in `in`. The number of rows and blocks, and which rows are stiff equalities, depend on
  // the options only.
  void (*fill)(const JointInput& in, RowWriter& out);
  // The joint's coordinate: hinge angle (rad), distance or slide (m); 0 where there is none.
  Real (*coordinate)(const JointInput& in);
  // Options of this kind: bits of JointUses.
  unsigned uses;
  WideRows wide = WideRows::none;  // whatever the options
};
enum JointUses : unsigned { kUsesLimits = 1, kUsesMotor = 2, kUsesSpring = 4, kUsesAxis = 8, kUsesTwoAnchors = 16 };

std::span<const JointKind> joint_kinds();

}  // namespace feder
