// Contacts of a distance field with whatever else has distances: candidates are collected, told apart by normal,
// thinned out, led to where the two surfaces are nearest, and reduced. All in the frame of the field. Internal to
// narrow.
#pragma once
#include <algorithm>
#include <span>

#include "geom/sdf.h"
#include "narrow/gjk.h"
#include "narrow/manifold.h"

namespace feder {

// The other shape, in the frame of the field: distance of a place there, and the direction in which it grows.
class PlacedShape {
 public:
  PlacedShape(const Shape& shape, const Pose& place)
      : shape_(shape), field_(is_sdf(shape) ? &static_cast<const Sdf&>(shape).field() : nullptr), place_(place) {}
  Real distance(const Vec3& p) const {
    Vec3 normal;
    const Vec3 local = to_local(place_, p);
    return field_ ? field_->at(local) : shape_.distance(local, kInfinity, normal);
  }
  Real at_least(const Vec3& p) const {  // no more than the distance, and sooner known
    return field_ ? field_->at_least(to_local(place_, p)) : distance(p);
  }
  Real within(const Vec3& p, Real limit) const {  // the distance, or something between limit and that
    return field_ ? field_->within(to_local(place_, p), limit) : distance(p);
  }
  Real distance(const Vec3& p, Vec3& normal) const {
    const Vec3 local = to_local(place_, p);
    const Real d = field_ ? field_->smooth_at(local, normal) : shape_.distance(local, kInfinity, normal);
    if (field_) normal = normalized_or(normal, Vec3(0, 1, 0));
    normal = rotate(place_.rotation, normal);
    return d;
  }

 private:
  const Shape& shape_;
  const DistanceField* field_;  // of a shape that is one
  const Pose& place_;
};

// Samples near a surface by their distances alone, in the order in which they are found. Where there are many, every
// other one goes until kEnough are left, first of those that are not nearly as deep as the deepest, which stays.
class NearSamples {
 public:
  static constexpr int kEnough = 64;
  struct One {
    std::uint32_t number;
    Real distance;  // m
  };

  explicit NearSamples(Real margin) : margin_(margin) {}
  void add(std::uint32_t number, Real distance) {
    if (count_ == kMost) thin(kMost / 2);
    all_[count_++] = {number, distance};
    if (distance < deepest_) deepest_ = distance, deepest_number_ = number;
  }
  std::span<const One> enough() {
    thin(kEnough);
    return {all_, static_cast<std::size_t>(count_)};
  }

 private:
  static constexpr int kMost = 512;
  void thin(int most);

  Real margin_, deepest_ = kInfinity;
  std::uint32_t deepest_number_ = 0;
  int count_ = 0;
  One all_[kMost];
};

// Calls visit(number, sample) for the samples that are within `margin` by distance(place), at most kEnough;
// at_least(place) is no more than that, and as good beyond the margin.
template <class AtLeast, class Distance, class F>
void each_sample_near(const Sdf& field, Real margin, AtLeast&& at_least, Distance&& distance, F&& visit) {
  const auto near = [&](const Aabb& box) {
    const Vec3 half = (box.hi - box.lo) / 2;
    return at_least(Vec3(box.lo + half)) <= length(half) + margin;
  };
  const std::span<const Sdf::Sample> samples = field.samples();
  NearSamples found(margin);
  field.sample_tree().query_if(near, [&](std::uint32_t i) {
    const Real d = distance(samples[i].at);
    if (d <= margin) found.add(i, d);
  });
  for (const NearSamples::One& s : found.enough()) visit(s.number, samples[s.number]);
}

inline constexpr Real kOpposed = Real(-0.3);  // cosine of the two normals of a contact, at most

struct FieldCandidate {
  Vec3 at;          // midway between the surfaces
  Vec3 normal;      // unit, from the field to the other
  Real separation;  // m
  std::uint32_t feature;
};

class FieldContacts {
 public:
  FieldContacts(const Sdf& field, Real margin) : field_(field), margin_(margin) {}

  void add(const FieldCandidate& c);
  // Samples of the field that are within the margin of the other.
  void add_samples(const PlacedShape& other);
  // Led to where both are nearest: only where both are smooth it moves.
  void refine(const PlacedShape& other);
  // Returns how many manifolds; normals from the field to the other, times `sign`.
  int finish(const Pose& pose, Real sign, Manifold* out);

  Real margin() const { return margin_; }
  const Sdf& field() const { return field_; }
  // The deepest of what was added so far, at most `most`, no two near each other.
  int deepest(FieldCandidate* out, int most) const;

 private:
  static constexpr int kMost = 128, kKeptNormals = 8, kKept = kKeptNormals * kMaxManifoldPoints;
  // The candidates by depth, those with about one normal in a group: groups by their deepest.
  struct Groups {
    int count = 0;
    int of[kMost];     // by candidate
    int first[kMost];  // by group
  };
  void group(Groups& groups);
  void drop_beside(Groups& groups);
  int spread(const Groups& groups, int most, int* chosen) const;
  int four_of(const Groups& groups, int group, int* chosen) const;
  void thin_out();

  const Sdf& field_;
  Real margin_;
  int count_ = 0;
  FieldCandidate candidates_[kMost];
};

// Point of a convex core, in the frame of the field, where the field is least near `start` (in the core): Frank and
// Wolfe 1956 with a line search. Returns the distance there.
Real least_over_convex(const DistanceField& field, const Convex& core, const Pose& place, const Vec3& start, Vec3& at,
                       Vec3& normal);

}  // namespace feder
