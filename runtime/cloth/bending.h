// Bending energy of flat cloth as a constant quadratic form (Bergou et al. 2006, "A Quadratic Bending Model for
// Inextensible Surfaces", eq. 4): E = sum over hinges k |c|^2/2, c = sum a_i x_i, with the a_i along the normal that
// the gradient of the angle has at rest. For motion without stretch c is the angle times the normal, so forces are
// those of the angle to second order; they are linear, f_i = -sum_j q_ij (x_j - x_i), and one product by vertex
// replaces the hinges. Differences of positions make rigid translation exact, and q_ij = q_ji keeps momentum and
// angular momentum. Private to the module.
#pragma once
#include "base/checks.h"
#include "base/jobs.h"
#include "cloth/solver.h"

namespace feder {

class QuadraticBending {
 public:
  explicit QuadraticBending(Arena& a) : blocks_(&a), entries_(&a) {}
  // The matrix of this mesh; none where a hinge is bent at rest, or flows (`exists`).
  void build(const ClothView& v);
  bool exists() const { return exists_; }
  // Forces at the start of the step.
  void current_position(const ClothView& v, JobPool& jobs);
  void write(ClothPass& p) { p.bend_blocks = blocks_.data(), p.bend_entries = entries_.data(); }
  unsigned blocks() const { return static_cast<unsigned>(blocks_.size()); }

 private:
  bool exists_ = false;
  Array<BendBlock> blocks_;
  Array<BendEntry> entries_;
};

}  // namespace feder
