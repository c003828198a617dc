// Dispatch by shape kinds. A row may name "convex" for every convex kind; a row that names the kinds themselves wins.
// Pairs without any row (plane and plane, a 2D section and a solid, compounds as wholes) never touch.
#include "narrow/narrow_phase.h"

#include <cstring>

#include "feder/error.h"

namespace feder {
namespace {

bool family(const char* word) { return !std::strcmp(word, "convex"); }

bool matches(const char* word, const ShapeKind& kind) {
  return family(word) ? kind.traits.convex : !std::strcmp(word, kind.name);
}

// How exactly a row names its pair: 0 by families only, 2 by both kinds.
int precision(const PairRow& row) { return int(!family(row.kind_a)) + int(!family(row.kind_b)); }

bool should_touch(const ShapeTraits& a, const ShapeTraits& b) {
  if (!a.whole || !b.whole) return false;
  if (a.convex && b.convex) return a.planar == b.planar;
  return a.convex || b.convex;
}

}  // namespace

NarrowPhase::NarrowPhase(const std::string& algorithm, std::span<const PairRow> tests) {
  for (const NarrowMethod& method : narrow_methods())
    if (algorithm == method.name) method_ = &method;
  if (algorithm != "auto" && algorithm != "gjk" && !method_)
    throw SceneError("unknown narrow phase '" + algorithm + "'; known: " + narrow_phase_names());
  const std::span<const ShapeKind> kinds = shape_kinds();
  kinds_ = static_cast<int>(kinds.size());
  table_.resize(kinds.size() * kinds.size());
  for (int wanted = 0; wanted <= 2; ++wanted)
    for (const PairRow& row : tests) take(row, algorithm == "gjk", wanted);
  if (method_)
    for (const PairRow& row : method_->pairs) take(row, false, precision(row));
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    for (std::size_t j = 0; j < kinds.size(); ++j) {
      Entry& entry = table_[i * kinds.size() + j];
      entry.lacking = !entry.test && should_touch(kinds[i].traits, kinds[j].traits);
      complete_ = complete_ && !entry.lacking;
    }
  }
}

// Fills in the row where it names its pair so exactly. `generic`: not in place of the test of all convex shapes.
void NarrowPhase::take(const PairRow& row, bool generic, int wanted) {
  if (precision(row) != wanted) return;
  const std::span<const ShapeKind> kinds = shape_kinds();
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    for (std::size_t j = 0; j < kinds.size(); ++j) {
      const ShapeTraits &a = kinds[i].traits, &b = kinds[j].traits;
      const bool both_convex = a.convex && b.convex;
      if (!matches(row.kind_a, kinds[i]) || !matches(row.kind_b, kinds[j])) continue;
      if (both_convex && a.planar != b.planar) continue;
      // flat sections have no volume for EPA: they keep their own tests
      if (generic && wanted == 2 && both_convex && !a.planar) continue;
      table_[i * kinds.size() + j] = {row.test, false, false};
      const bool same_family = matches(row.kind_a, kinds[j]) && matches(row.kind_b, kinds[i]);
      if (i != j && !same_family) table_[j * kinds.size() + i] = {row.test, true, false};
    }
  }
}

std::string narrow_phase_names() {
  std::string all = "auto, gjk";
  for (const NarrowMethod& method : narrow_methods()) all += std::string(", ") + method.name;
  return all;
}

bool NarrowPhase::lacks(const Shape& a, const Shape& b) const {
  return table_[static_cast<std::size_t>(a.kind_id() * kinds_ + b.kind_id())].lacking;
}

int NarrowPhase::collide(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Real margin,
                         PairCache& cache, Manifold* out) const {
  const Entry& entry = table_[static_cast<std::size_t>(a.kind_id() * kinds_ + b.kind_id())];
  if (!entry.test) return 0;
  if (!entry.swapped) return entry.test(a, pose_a, b, pose_b, margin, cache, out);
  const int count = entry.test(b, pose_b, a, pose_a, margin, cache, out);
  for (int i = 0; i < count; ++i) out[i].normal = -out[i].normal;
  return count;
}

}  // namespace feder
