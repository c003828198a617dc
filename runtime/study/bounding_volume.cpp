// Volumes by themselves: made anew around every item in every step, each tested against each. The share of false pairs
// against the time of n^2 tests.
// Source: Gottschalk, Lin & Manocha, "OBBTree", SIGGRAPH 1996 (cost = tests x their cost). Does not show: hierarchies.
#include "study/volume_problem.h"

namespace feder {
namespace {

class VolumesRun final : public VolumeRun {
 public:
  VolumesRun(const VolumeProblem& problem, const RunSpec& spec, const VolumeKind& kind)
      : VolumeRun(problem, spec.steps), kind_(kind) {}

 private:
  void find(ItemPoints items, ItemPairs& out, std::int64_t& tests) override {
    volumes_.clear();
    for (std::uint32_t i = 0; i < items.count(); ++i) volumes_.push_back(kind_.around({items.of(i), items.each}));
    for (std::uint32_t a = 0; a < volumes_.size(); ++a)
      for (std::uint32_t b = a + 1; b < volumes_.size(); ++b)
        if (++tests, volumes_[a]->overlaps(*volumes_[b])) out.emplace_back(a, b);
  }
  const VolumeKind& kind_;
  std::vector<std::unique_ptr<BoundingVolume>> volumes_;
};

class BoundingVolumes final : public VolumeProblem {
 public:
  explicit BoundingVolumes(const Params& given) {
    ProblemOptions o(given, info_);
    set_items(o);
    rung_name_ = "pairs", rungs_ = {"all"};
  }
  std::vector<MethodInfo> methods() const override {
    std::vector<MethodInfo> all;
    for (const VolumeKind& kind : bounding_volumes()) all.push_back({kind.name, kind.summary});
    return all;
  }
  std::unique_ptr<StudyRun> start(const RunSpec& spec) const override {
    return std::make_unique<VolumesRun>(*this, spec, bounding_volume(spec.method));
  }
};

}  // namespace

Variant<StudyProblem> study_bounding_volume() {
  return variant_of<StudyProblem, BoundingVolumes>("bounding_volume", "thin boxes, all pairs: false ones by volume");
}

}  // namespace feder
