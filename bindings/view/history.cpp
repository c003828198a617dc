#include "view/history.h"

#include <algorithm>

namespace feder::view {
namespace {
bool by_step(const Moment& m, std::uint64_t step) { return m.step < step; }
}  // namespace

void History::add(Moment moment) {
  bytes_ += moment.image.size();
  moments_.push_back(std::move(moment));
  const double oldest = moments_.back().time - seconds_;
  // the moment at the border stays, so that the whole of the seconds can be shown
  while (moments_.size() > 2 && moments_[1].time <= oldest) {
    bytes_ -= moments_.front().image.size();
    moments_.pop_front();
  }
  while (!marks_.empty() && marks_.front().step < moments_.front().step) marks_.pop_front();
  if (bytes_ > limit_) thin_out();
}

void History::thin_out() {
  if (moments_.size() <= kDense + 2) {
    // nothing to thin: the oldest goes
    if (moments_.size() > kDense) bytes_ -= moments_.front().image.size(), moments_.pop_front();
    return;
  }
  std::deque<Moment> kept;
  const std::size_t dense = moments_.size() - kDense;
  for (std::size_t i = 0; i < moments_.size(); ++i) {
    if (i >= dense || i % 2 == 0)
      kept.push_back(std::move(moments_[i]));
    else
      bytes_ -= moments_[i].image.size();
  }
  moments_.swap(kept);
}

void History::mark(std::uint64_t step, double time, const std::string& kind, const std::string& label) {
  for (auto m = marks_.rbegin(); m != marks_.rend() && m->step == step; ++m) {
    if (m->kind != kind) continue;
    ++m->count;
    return;
  }
  marks_.push_back({step, time, kind, label, 1});
  if (marks_.size() > kMarks) marks_.pop_front();
}

void History::cut_after(std::uint64_t step) {
  while (!moments_.empty() && moments_.back().step > step) {
    bytes_ -= moments_.back().image.size();
    moments_.pop_back();
  }
  while (!marks_.empty() && marks_.back().step > step) marks_.pop_back();
}

void History::clear() {
  moments_.clear();
  marks_.clear();
  bytes_ = 0;
}

const Moment& History::at(std::uint64_t step) const {
  const auto above = std::lower_bound(moments_.begin(), moments_.end(), step + 1, by_step);
  return above == moments_.begin() ? moments_.front() : *(above - 1);
}

const Moment* History::before(std::uint64_t step) const {
  const auto found = std::lower_bound(moments_.begin(), moments_.end(), step, by_step);
  return found == moments_.begin() ? nullptr : &*(found - 1);
}

const Moment* History::after(std::uint64_t step) const {
  const auto found = std::lower_bound(moments_.begin(), moments_.end(), step + 1, by_step);
  return found == moments_.end() ? nullptr : &*found;
}

}  // namespace feder::view
