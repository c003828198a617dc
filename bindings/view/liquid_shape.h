// What of a liquid's particles is spray, where it foams, and a smoother skin: for pictures alone.
#pragma once
#include <span>
#include <vector>

#include "feder/types.h"

namespace feder::view {

// Particles by cells of kCell spacings. Spray is what has few others near (less than kLoose of a full neighbourhood);
// it foams where velocities within a cell differ, as where a wave breaks (after Ihmsen et al., "Unified Spray, Foam and
// Air Bubbles", Vis. Comput. 2012, eq. 2, without its neighbour search). Kept between calls: memory. Weak spot: what is
// near counts by cells, so a particle beside a body of liquid may be taken for spray, or the other way round.
class LiquidShape {
 public:
  // `calm`: m/s; foam begins where velocities differ by so much. 0: no foam.
  void sort(std::span<const Vec3> positions, std::span<const Vec3> velocities, Real spacing, Real calm);
  std::span<const Vec3> bulk() const { return bulk_; }
  std::span<const Vec3> spray() const { return spray_; }
  bool foams() const { return foams_; }
  float foam(const Vec3& at) const;  // 0 .. 1

 private:
  struct Cell {
    std::uint64_t key = 0;
    std::uint32_t count = 0;
    float foam = 0;
    Vec3 sum = Vec3::Zero();  // of velocities
    Real squares = 0;         // of speeds
  };
  const Cell* find(std::uint64_t key) const;
  std::uint32_t make(std::uint64_t key);  // in cells_
  void grow();
  std::uint64_t key_of(const Vec3& x) const;
  bool is_spray(const Vec3& x) const;

  std::vector<Cell> cells_;
  std::vector<std::uint32_t> slots_;  // an open hash table of cells; kNone: empty
  std::vector<std::uint32_t> own_;    // cell, by particle; kNone: it is nowhere
  std::vector<Vec3> bulk_, spray_;
  Real size_ = 1;  // m
  bool foams_ = false;
};

// Moves the vertices of a closed mesh towards the mean of their neighbours and nearly as far back, `rounds` times
// (Taubin, "A Signal Processing Approach to Fair Surface Design", SIGGRAPH 1995): ripples go, volume stays. `scratch`
// is memory. The foam of the vertices, when there is any, is smoothed along.
void smooth_mesh(std::span<Vec3> vertices, std::span<const std::uint32_t> triangles, std::span<float> foam, int rounds,
                 std::vector<Vec3>& scratch, std::vector<float>& weights);

}  // namespace feder::view
