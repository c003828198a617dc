// Any two convex shapes: GJK, EPA when the cores overlap, then the patch where their faces look at each other.
// Kept between calls: the last normal in the frame of a, from which GJK starts.
// Sources: gjk.cpp, epa.cpp, patch.cpp. Weak spot: round faces meet as the polygons that Shape::face gives, and one
// normal serves the whole pair.
#include "narrow/narrow_phase.h"
#include "narrow/patch.h"

namespace feder {
namespace {

constexpr double kSteps = 1 << 20;  // the cached normal: 21 bits per component

void store(const Double3& n, PairCache& cache) {
  const auto bits = [](double x) { return static_cast<std::uint64_t>((x + 1) * (kSteps - 1) + 0.5); };
  const std::uint64_t all = bits(n.x) | bits(n.y) << 21 | bits(n.z) << 42 | std::uint64_t(1) << 63;
  cache.word[0] = static_cast<std::uint32_t>(all);
  cache.word[1] = static_cast<std::uint32_t>(all >> 32);
}

Double3 load(const PairCache& cache, const Double3& otherwise) {
  const std::uint64_t all = std::uint64_t(cache.word[1]) << 32 | cache.word[0];
  if (!(all >> 63)) return otherwise;
  const auto value = [&](int shift) { return double(all >> shift & 0x1fffff) / (kSteps - 1) - 1; };
  return {value(0), value(21), value(42)};
}

int convex_convex(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin, PairCache& cache,
                  Manifold* out) {
  const ConvexPair pair(Convex(a), pose_a, Convex(b), pose_b);
  const double enough = double(margin) + a.radius() + b.radius();
  Gap gap;
  const bool near = core_gap(pair, -load(cache, pair.offset), enough, gap);
  store(gap.normal, cache);
  if (!near) return 0;
  return gap_manifold(pair, gap, margin, pose_a, *out);
}

}  // namespace

PairRow narrow_convex_convex() { return {"convex", "convex", convex_convex}; }

}  // namespace feder
