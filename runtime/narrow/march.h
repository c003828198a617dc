// Closest features of two convex polytopes by marching from pair to pair of them (internal to narrow).
#pragma once
#include "geom/hull_features.h"
#include "narrow/gjk.h"

namespace feder {

class Polygon;

struct Feature {
  enum Kind : std::uint8_t { vertex, edge, face };
  Kind kind;
  std::uint16_t index;
};

struct FeaturePair {
  Feature a, b;
  std::uint32_t packed() const {  // 24 bits
    const auto bits = [](const Feature& f) { return static_cast<std::uint32_t>(f.kind) << 10 | f.index; };
    return bits(a) << 12 | bits(b);
  }
  static FeaturePair unpacked(std::uint32_t word) {
    const auto feature = [](std::uint32_t w) {
      return Feature{static_cast<Feature::Kind>(w >> 10 & 3), static_cast<std::uint16_t>(w & 0x3ff)};
    };
    return {feature(word >> 12), feature(word)};
  }
};

enum class MarchEnd : std::uint8_t {
  apart,    // `gap` is the answer
  overlap,  // or nearer than kTouching
  repeat,   // a feature pair came twice, or too many came: rounding leads in a circle
  bent      // faces that are not flat: support points say something else
};

struct March {
  MarchEnd end = MarchEnd::repeat;
  FeaturePair features;
  int steps = 0;  // feature pairs looked at
  Gap gap;        // when apart
};

// Neither visits a feature pair twice. `start`: any pair, the last answer at best. In the frame of a.
March march(const ConvexPair& pair, const Features& a, const Features& b, FeaturePair start);
March march(const ConvexPair& pair, const Polygon& a, const Polygon& b, FeaturePair start);

// A pair to start from, where nothing is known: the corners farthest towards the other one.
FeaturePair first_features(const ConvexPair& pair, const Features& a, const Features& b);
bool within(const Features& f, const Feature& feature);
bool within(const Polygon& p, const Feature& feature);

inline constexpr int kMaxMarch = 200;         // feature pairs
inline constexpr double kMarchTouch = 1e-9;   // of both sizes: nearer ones overlap
inline constexpr double kMarchSlack = 1e-13;  // of all lengths at play: what rounding may say

// The feature pairs seen so far.
class Trail {
 public:
  // False when it came before, or there is no room.
  bool add(const FeaturePair& pair) {
    const std::uint32_t word = pair.packed();
    for (int i = 0; i < count_; ++i)
      if (seen_[i] == word) return false;
    if (count_ == kMaxMarch) return false;
    seen_[count_++] = word;
    return true;
  }
  int count() const { return count_; }

 private:
  int count_ = 0;
  std::uint32_t seen_[kMaxMarch];
};

enum class MarchVerdict : std::uint8_t { moved, closest, inside };

// From pair to pair: step() looks at the features `at` and moves them, or says why not; fill(gap) gives the answer of
// the closest. Apart: farther than `touch`.
template <class Step, class Fill>
March march_on(Feature (&at)[2], FeaturePair start, double touch, Step&& step, Fill&& fill) {
  at[0] = start.a, at[1] = start.b;
  Trail trail;
  March result;
  for (;;) {
    result.features = {at[0], at[1]};
    if (!trail.add(result.features)) return result;
    ++result.steps;
    const MarchVerdict verdict = step();
    if (verdict == MarchVerdict::moved) continue;
    if (verdict == MarchVerdict::closest) fill(result.gap);
    const bool apart = verdict == MarchVerdict::closest && result.gap.distance > touch;
    result.end = apart ? MarchEnd::apart : MarchEnd::overlap;
    return result;
  }
}

}  // namespace feder
