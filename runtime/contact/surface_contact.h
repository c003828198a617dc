// Contact of surfaces (state/surface.h) with each other and with themselves: candidate pairs, groups that share their
// solver substeps, contact rows, non-penetration projection, and reports to the contact book. Knows neither cloth nor
// nets. Rows of couplings are solved here as well, in the loop of the group, between its members' own sweeps.
#pragma once
#include <memory>

#include "feder/system.h"
#include "state/surface.h"

namespace feder {

class SurfaceContact final : public System {
 public:
  static constexpr const char* kName = "contact";
  static const SystemDescriptor& descriptor();
  explicit SurfaceContact(SystemSetup& setup);
  ~SurfaceContact() override;

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override;  // pairs of objects in contact now
  void hash(Hash& h) const override;
  void save(Writer& w) const override;
  void load(Reader& r) override;
  void validate() const override;
  void residuals(std::vector<Residual>& out) const override;  // contact.impulse_mismatch, .impulse_ns, .pairs ...

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace feder
