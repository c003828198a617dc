// Hierarchies of every volume by every build, refitted in every step, with 1 to 8 items in a leaf.
// Source: Klosowski et al., "Efficient Collision Detection Using Bounding Volume Hierarchies of k-DOPs", TVCG 1998.
// Does not show: queries by boxes and rays (mesh_index).
#include <charconv>

#include "study/volume_problem.h"

namespace feder {
namespace {

class HierarchyRun final : public VolumeRun {
 public:
  HierarchyRun(const VolumeProblem& problem, const RunSpec& spec, const VolumeKind& volume, const TreeBuild& build,
               std::uint32_t leaf)
      : VolumeRun(problem, spec.steps), tree_(volume.hierarchy()) {
    std::vector<Vec3> points;
    problem.place(0, points);
    tree_->build({points, 8}, build, leaf);
  }
  std::size_t bytes() const override { return tree_->bytes(); }

 private:
  void find(ItemPoints items, ItemPairs& out, std::int64_t& tests) override {
    tree_->refit(items);
    HierarchyCost cost;
    tree_->pairs(
        {[](void* to, std::uint32_t a, std::uint32_t b) { static_cast<ItemPairs*>(to)->emplace_back(a, b); }, &out},
        &cost);
    tests += static_cast<std::int64_t>(cost.nodes + cost.items);
  }
  std::unique_ptr<Hierarchy> tree_;
};

class Hierarchies final : public VolumeProblem {
 public:
  explicit Hierarchies(const Params& given) {
    ProblemOptions o(given, info_);
    set_items(o);
    rung_name_ = "leaf", rungs_ = {"8", "4", "2", "1"};
  }
  std::vector<MethodInfo> methods() const override {
    std::vector<MethodInfo> all;
    for (const VolumeKind& kind : bounding_volumes())
      for (const TreeBuild& build : tree_builds())
        all.push_back({std::string(kind.name) + "." + build.name, std::string(kind.summary) + "; " + build.summary});
    return all;
  }
  std::unique_ptr<StudyRun> start(const RunSpec& spec) const override {
    const std::size_t dot = spec.method.find('.');
    std::uint32_t leaf = 2;
    for (const auto& [name, value] : spec.settings)
      if (name == rung_name_) std::from_chars(value.data(), value.data() + value.size(), leaf);
    const std::string_view method = spec.method;
    return std::make_unique<HierarchyRun>(*this, spec, bounding_volume(method.substr(0, dot)),
                                          tree_build(dot == method.npos ? "" : method.substr(dot + 1)),
                                          std::max(leaf, 1u));
  }
};

}  // namespace

Variant<StudyProblem> study_hierarchy() {
  return variant_of<StudyProblem, Hierarchies>("hierarchy", "thin boxes, their pairs by every volume and build");
}

}  // namespace feder
