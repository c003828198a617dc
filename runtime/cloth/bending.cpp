#include "cloth/bending.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "cloth/dihedral.h"

namespace feder {
namespace {
constexpr JobGrain kForceGrain{32, 8'000};  // blocks per job
constexpr Real kFlat = Real(1e-4);          // rad, largest angle at rest of a hinge that counts as flat

// Off-diagonal number of the matrix: what vertex `row` gets for each metre that `column` is off.
struct Coupling {
  std::uint32_t row, column;
  double stiffness;  // N/m
  bool operator<(const Coupling& o) const { return row != o.row ? row < o.row : column < o.column; }
};

// a_i of the hinge at rest, 1/m.
void weights(const ClothView& v, const ClothHinge& h, double (&a)[4]) {
  const Double3 x0 = wide(v.rest[h.v[0]]), e = wide(v.rest[h.v[1]]) - x0;
  const Dihedral<Double3> d = dihedral(e, wide(v.rest[h.v[2]]) - x0, wide(v.rest[h.v[3]]) - x0, HingeFloor());
  const double size = length(d.gradient[2]);
  for (int i = 0; i < 4; ++i) a[i] = size > 0 ? dot(d.gradient[i], d.gradient[2]) / size : 0;
}
}  // namespace

void QuadraticBending::build(const ClothView& v) {
  blocks_.clear(), entries_.clear();
  const auto& hinges = v.mesh->hinges;
  exists_ = !v.flows && !hinges.empty() &&
            std::all_of(hinges.begin(), hinges.end(), [](const ClothHinge& h) { return std::fabs(h.angle) <= kFlat; });
  if (!exists_) return;
  std::vector<Coupling> all;
  all.reserve(hinges.size() * 12);
  for (const ClothHinge& h : hinges) {
    double a[4];
    weights(v, h, a);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        if (i != j) all.push_back({h.v[i], h.v[j], double(h.stiffness) * a[i] * a[j]});
  }
  // sums of equal pairs, in the order of the hinges for both directions
  std::stable_sort(all.begin(), all.end());
  std::size_t count = 0;
  for (const Coupling& k : all) {
    if (count > 0 && all[count - 1].row == k.row && all[count - 1].column == k.column)
      all[count - 1].stiffness += k.stiffness;
    else
      all[count++] = k;
  }
  all.resize(count);
  // rows of eight vertices side by side; lanes with fewer numbers point to themselves
  std::size_t next = 0;
  for (std::uint32_t first = 0; first < v.total; first += kLanes) {
    BendBlock b{};
    b.first = b.last = static_cast<unsigned>(entries_.size());
    for (std::uint32_t i = 0; i < kLanes; ++i) b.vertex[i] = std::min(first + i, v.total - 1);
    for (unsigned lane = 0; lane < kLanes; ++lane) {
      unsigned at = b.first;
      for (; next < all.size() && all[next].row == first + lane; ++next) {
        const auto stiffness = static_cast<Real>(all[next].stiffness);
        if (stiffness == 0) continue;
        if (at == b.last) {
          BendEntry empty{};
          std::copy(b.vertex, b.vertex + kLanes, empty.other);
          entries_.push_back(empty), ++b.last;
        }
        entries_[at].other[lane] = all[next].column, entries_[at].stiffness.v[lane] = stiffness;
        ++at;
      }
    }
    blocks_.push_back(b);
  }
  FEDER_ASSERT(next == all.size());
}

// Summed in double: it is a small difference of large numbers.
void QuadraticBending::current_position(const ClothView& v, JobPool& jobs) {
  jobs.for_blocks(blocks(), kForceGrain, [&](std::uint32_t first, std::uint32_t last, int) {
    for (std::uint32_t n = first; n < last; ++n) {
      BendBlock& b = blocks_[n];
      double f[3][kLanes] = {};
      for (unsigned e = b.first; e < b.last; ++e)
        for (int i = 0; i < kLanes; ++i) {
          const Vec3 &x = v.position[entries_[e].other[i]], &own = v.position[b.vertex[i]];
          const auto k = static_cast<double>(entries_[e].stiffness.v[i]);
          for (int d = 0; d < 3; ++d) f[d][i] -= k * (static_cast<double>(x[d]) - static_cast<double>(own[d]));
        }
      for (int i = 0; i < kLanes; ++i) {
        b.force.x.v[i] = static_cast<Real>(f[0][i]);
        b.force.y.v[i] = static_cast<Real>(f[1][i]);
        b.force.z.v[i] = static_cast<Real>(f[2][i]);
      }
    }
  });
}

}  // namespace feder
