// A force around another: asks it, and logs what it adds. It is asked on the stepping thread alone, so that the answers
// have an order; results do not depend on threads. A replay plays them in that order (record/played_force.cpp).
// Weak spot: potential energies are not kept; a replay has none of such forces.
#include "world/recorded_force.h"

namespace feder {
namespace {

class RecordedForce final : public Force {
 public:
  RecordedForce(std::shared_ptr<const Force> force, CommandLog& log) : force_(std::move(force)), log_(log) {}

  void add(const MassPoint* points, std::size_t count, double time, Vec3* out) const override {
    sum_.assign(count, Vec3::Zero());
    force_->add(points, count, time, sum_.data());
    numbers_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      out[i] += sum_[i];
      for (int k = 0; k < 3; ++k) numbers_.push_back(static_cast<double>(sum_[i][k]));
    }
    log();
  }
  double potential(const MassPoint* points, std::size_t count) const override {
    return force_->potential(points, count);
  }
  bool depends_on_velocity() const override { return force_->depends_on_velocity(); }
  bool derivative(const MassPoint* points, std::size_t count, double time, bool by_velocity, Mat3* out) const override {
    if (count == 0) {
      const bool known = force_->derivative(points, 0, time, by_velocity, out);
      numbers_.assign(1, known);
      log();
      return known;
    }
    slopes_.assign(count, Mat3::Zero());
    numbers_.assign(1, force_->derivative(points, count, time, by_velocity, slopes_.data()));
    for (std::size_t i = 0; numbers_[0] != 0 && i < count; ++i) {
      out[i] += slopes_[i];
      for (int k = 0; k < 9; ++k) numbers_.push_back(static_cast<double>(slopes_[i](k / 3, k % 3)));
    }
    log();
    return numbers_[0] != 0;
  }
  std::uint64_t faults() const override { return force_->faults(); }
  bool on_stepping_thread() const override { return true; }
  bool on_area() const override { return force_->on_area(); }

 private:
  void log() const {
    if (log_.stepping()) log_.add_forces(numbers_.data(), numbers_.size());
  }

  std::shared_ptr<const Force> force_;
  CommandLog& log_;
  // work memory; asked by one thread
  mutable std::vector<Vec3> sum_;
  mutable std::vector<Mat3> slopes_;
  mutable std::vector<double> numbers_;
};

}  // namespace

std::shared_ptr<const Force> recorded_force(std::shared_ptr<const Force> force, CommandLog& log) {
  return std::make_shared<RecordedForce>(std::move(force), log);
}

}  // namespace feder
