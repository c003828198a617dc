// Bounding volumes and hierarchies of them over items of a few points each: one file per volume, one
// feder_variant(bounds <volume>) line. They know points and boxes only. Contract, checked for every volume and build by
// tests/bounds/test_volumes.cpp and test_hierarchy.cpp against brute force:
//  - a volume holds all points that it was made of, and what its parts hold where it was merged from two;
//  - the tests for overlap never miss; how often they find what does not touch is the tightness of the volume;
//  - a hierarchy visits each item whose own volume passes the test, once; refit keeps that for the same items in other
//    places; the same bits on every machine.
// Volumes are made a little too large, by what rounding can do to their tests.
#pragma once
#include <memory>
#include <span>

#include "bounds/edges.h"
#include "bounds/tree_build.h"
#include "feder/types.h"

namespace feder {

// Items that bring so many points each: points, segments, triangles, corners of boxes.
struct ItemPoints {
  std::span<const Vec3> points;
  std::uint32_t each = 3;
  std::uint32_t count() const { return static_cast<std::uint32_t>(points.size() / each); }
  std::span<const Vec3> of(std::uint32_t item) const { return points.subspan(std::size_t(item) * each, each); }
};

// One volume on its own: for studies, and for drawing.
class BoundingVolume {
 public:
  virtual ~BoundingVolume() = default;
  virtual bool contains(const Vec3& p) const = 0;
  virtual bool overlaps(const BoundingVolume& same_kind) const = 0;
  virtual bool meets(const Aabb& box) const = 0;  // may say so of a box that it just misses
  virtual std::unique_ptr<BoundingVolume> merged(const BoundingVolume& same_kind) const = 0;
  virtual double volume() const = 0;                // m^3
  virtual bool edges(EdgeVisitor visit) const = 0;  // false when the visitor wants no more
};

// Called for what a query finds.
struct ItemVisitor {
  void (*call)(void* context, std::uint32_t item);
  void* context;
  void operator()(std::uint32_t item) const { call(context, item); }
};
struct PairVisitor {
  void (*call)(void* context, std::uint32_t a, std::uint32_t b);  // a < b
  void* context;
  void operator()(std::uint32_t a, std::uint32_t b) const { a < b ? call(context, a, b) : call(context, b, a); }
};

// What queries cost: they add to it.
struct HierarchyCost {
  std::uint64_t nodes = 0, items = 0;  // tests of volumes of either
};

class Hierarchy {
 public:
  virtual ~Hierarchy() = default;
  // At most `leaf` items in a leaf. SceneError where a point is not finite; then it is as it was.
  virtual void build(ItemPoints items, const TreeBuild& how, std::uint32_t leaf) = 0;
  // The same items in other places. Subtrees whose cost has grown by half are built anew.
  virtual void refit(ItemPoints items) = 0;
  virtual void query(const Aabb& box, ItemVisitor visit, HierarchyCost* cost = nullptr) const = 0;
  // t in [0, 1]
  virtual void query_ray(const Vec3& origin, const Vec3& ray, ItemVisitor visit,
                         HierarchyCost* cost = nullptr) const = 0;
  // Of items whose volumes overlap.
  virtual void pairs(PairVisitor visit, HierarchyCost* cost = nullptr) const = 0;
  // Edges of the volumes so many levels below the root, and of the leaves above. True: there are deeper ones.
  virtual bool volumes_at(int level, EdgeVisitor visit) const = 0;
  virtual std::uint32_t size() const = 0;
  virtual std::size_t bytes() const = 0;
  virtual std::uint32_t rebuilt() const = 0;  // subtrees, by refits
};

struct VolumeKind {
  const char* name;
  const char* summary;
  std::unique_ptr<BoundingVolume> (*around)(ItemPoints items);  // of all of them; SceneError without any
  std::unique_ptr<Hierarchy> (*hierarchy)();
};
std::span<const VolumeKind> bounding_volumes();
const VolumeKind& bounding_volume(std::string_view name);  // SceneError

void check_finite(ItemPoints items);  // SceneError
[[noreturn]] void fail_empty_volume();

}  // namespace feder
