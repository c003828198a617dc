// Boxes in seven arrangements that move about, for what finds their pairs: of problems and tests. Private to both.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include "base/rng.h"
#include "feder/types.h"

namespace feder {

class MovingBoxes {
 public:
  static constexpr const char* kArrangements[] = {"gas",     "pile",    "city",     "huge_and_tiny",
                                                  "cluster", "line_up", "identical"};
  struct Options {
    double crowd = 0.25;  // boxes per m^3 of the gas; the others are wider and closer with it
    double ratio = 1;     // largest over smallest size
    double resting = 0;   // share of the boxes that lie still
    double origin = 0;    // m, of the room along each axis
    int teleports = 0;    // one of so many boxes is elsewhere in each step; 0: none
  };

  MovingBoxes(std::string_view arrangement, std::uint32_t count, const Options& o) : options_(o) {
    Rng rng(41);
    const double side = std::cbrt(count / o.crowd), near = std::cbrt(0.25 / o.crowd);  // m, of the room; of a box
    const auto across = std::max(1u, static_cast<std::uint32_t>(std::ceil(std::cbrt(count))));
    const auto streets = std::max(1u, static_cast<std::uint32_t>(std::ceil(std::sqrt(count))));
    for (std::uint32_t i = 0; i < count; ++i) {
      Three at = any(rng, side), size{1, 1, 1};
      const Three way = any(rng, 2);
      const double scale = std::pow(o.ratio, -rng.unit());
      bool moves = !(rng.unit() < o.resting);
      if (arrangement == "pile") {  // each touches those beside, above and below
        const std::uint32_t cell[3] = {i % across, i / across / across, i / across % across};
        for (std::size_t k = 0; k < 3; ++k) at[k] = near * (0.95 * cell[k] + 0.05 * at[k] / side);
      } else if (arrangement == "city") {  // houses, and one car for seven of them
        const bool house = i % 8 != 0;
        size = house ? Three{1, 0.5 + 8 * rng.unit(), 1} : Three{0.4, 0.3, 0.8};
        at = {near * 1.6 * (i % streets + (house ? 0 : 0.5)), size[1] / 2, near * 1.6 * (i / streets)};
        moves = moves && !house;
      } else if (arrangement == "huge_and_tiny") {
        size = i % 16 == 0 ? Three{8, 8, 8} : Three{0.05, 0.05, 0.05};
      } else if (arrangement == "cluster") {  // three quarters in a corner, the others far from it
        for (double& x : at) x = 0.3 * x + (i % 4 == 0 ? 10 * side : 0);
      } else if (arrangement == "line_up") {
        at = {0.5 * near * i, 0, 0};
      } else if (arrangement == "identical") {
        at = {1, 2, 3};
      }
      for (std::size_t k = 0; k < 3; ++k)
        size[k] *= scale, from_[k] = std::min(from_[k], at[k]), to_[k] = std::max(to_[k], at[k]);
      starts_.push_back(at), ways_.push_back({way[0] - 1, way[1] - 1, way[2] - 1}), sizes_.push_back(size);
      moves_.push_back(moves);
    }
  }

  std::uint32_t count() const { return static_cast<std::uint32_t>(starts_.size()); }
  bool moves(std::uint32_t i) const { return moves_[i]; }
  // After so many steps in which a box goes by up to `speed` of its size along each axis, and turns back where the
  // room ends.
  Aabb box(std::uint32_t i, double speed, int step) const {
    Vec3 at, half;
    Three start = starts_[i];
    const bool jumps = options_.teleports > 0 && step > 0 && moves_[i] &&
                       (i + static_cast<std::uint32_t>(step)) % static_cast<std::uint32_t>(options_.teleports) == 0;
    if (jumps) {
      Rng rng(1000003 * (i + 1u) + static_cast<std::uint32_t>(step));
      for (std::size_t k = 0; k < 3; ++k) start[k] = from_[k] + rng.unit() * (to_[k] - from_[k]);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const double go = moves_[i] ? speed * sizes_[i][k] * ways_[i][k] * step : 0, width = to_[k] - from_[k];
      const double x = width > 0 ? std::fabs(std::remainder(start[k] + go - from_[k], 2 * width)) : 0;
      at[static_cast<int>(k)] = static_cast<Real>(options_.origin + from_[k] + x);
      half[static_cast<int>(k)] = static_cast<Real>(0.5 * sizes_[i][k]);
    }
    return {at - half, at + half};
  }

 private:
  using Three = std::array<double, 3>;
  static Three any(Rng& rng, double below) {
    const double z = rng.unit(), y = rng.unit(), x = rng.unit();
    return {below * x, below * y, below * z};
  }
  Options options_;
  Three from_{1e300, 1e300, 1e300}, to_{-1e300, -1e300, -1e300};  // m, of the middles at the start
  std::vector<Three> starts_, ways_, sizes_;
  std::vector<bool> moves_;
};

}  // namespace feder
