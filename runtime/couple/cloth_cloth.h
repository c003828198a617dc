// Two or more cloths in one world: who may touch whom, and what they did to each other.
#pragma once
#include "bounds/aabb.h"
#include "cloth/cloth.h"
#include "couple/event_balance.h"
#include "step/system.h"

namespace feder {

class ClothCloth final : public System {
 public:
  static constexpr const char* kName = "cloth_cloth";
  static const SystemDescriptor& descriptor();
  explicit ClothCloth(SystemSetup& setup);

  void add_passes(StepPlan& plan) override;  // none with fewer than two cloths
  std::size_t count() const override;        // pairs that touch now
  void hash(Hash& h) const override;
  void save(Writer& w) const override { w.list(touches_); }
  void load(Reader& r) override { r.list(touches_), open_.set(touches_.size()); }
  void validate() const override;
  void residuals(std::vector<Residual>& out) const override;  // cloth_cloth.impulse_mismatch, .impulse_ns, .pairs

 private:
  // Two cloths in contact, over steps.
  struct Touch {
    ObjectId a, b;            // a < b
    std::uint32_t seen = 0;   // in this step
    std::uint32_t begun = 0;  // reported
    Cloth::Between what;      // of this step
  };

  // Rows.
  void list_pairs(StepContext& c);
  void finish(StepContext& c);

  void sync();
  Aabb reach(std::size_t n, StepContext& c) const;
  void gather(const Cloth::Between& k);
  void report(Touch& t, StepContext& c);
  Event event(EventKind kind, const Touch& t);

  Cloth& cloth_;
  Objects& objects_;
  Events& events_;
  Array<Aabb> box_;                  // by cloth
  Array<Touch> touches_;             // in the order of the objects
  double mismatch_ = 0, given_ = 0;  // N s, of the last step
  std::size_t pairs_ = 0;            // that might touch in the last step
  EventBalance open_;
};

}  // namespace feder
