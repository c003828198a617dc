// Sparse L D L^T of 3x3 blocks, left-looking (George & Liu 1981), ordered by minimum degree (Rose 1972): the next point
// is one with the fewest neighbours left, the first of them. Chains and trees get no fill, a chain of n links costs n
// block products where conjugate gradient needs n iterations.
// Kept between calls: the order and the layout of L per pattern. Weak spot: fill of solid lattices grows as n^(4/3);
// analyze() then says no and the caller iterates.
#include "linear/block_ldl.h"

#include <algorithm>

#include "feder/error.h"

namespace feder {
namespace {

// L D L^T of a symmetric positive definite block, D on the diagonal of `out` and L below it; false when it is not. The
// inverse itself would lose as many digits as the block's stiffness stands above its mass.
bool factor_block(const Mat3d& m, Mat3d& out) {
  const double a = m(0, 0);
  if (!(a > 0)) return false;
  const double l10 = m(1, 0) / a, l20 = m(2, 0) / a, d1 = m(1, 1) - l10 * m(1, 0);
  if (!(d1 > 0)) return false;
  const double e = m(2, 1) - l20 * m(1, 0), l21 = e / d1, d2 = m(2, 2) - l20 * m(2, 0) - l21 * e;
  if (!(d2 > 0)) return false;
  out << a, 0, 0, l10, d1, 0, l20, l21, d2;
  return true;
}

Vec3d solve_block(const Mat3d& f, const Vec3d& b) {
  const double y1 = b[1] - f(1, 0) * b[0], y2 = b[2] - f(2, 0) * b[0] - f(2, 1) * y1;
  const double x2 = y2 / f(2, 2), x1 = y1 / f(1, 1) - f(2, 1) * x2;
  return Vec3d(b[0] / f(0, 0) - f(1, 0) * x1 - f(2, 0) * x2, x1, x2);
}

// Points by their number of neighbours left; the one asked for is the first of the smallest degree.
class DegreeOrder {
 public:
  explicit DegreeOrder(const std::vector<std::vector<std::uint32_t>>& neighbors) : degree_(neighbors.size()) {
    for (std::uint32_t i = 0; i < degree_.size(); ++i) degree_[i] = static_cast<std::uint32_t>(neighbors[i].size());
    for (std::uint32_t i = 0; i < degree_.size(); ++i) heap_.push_back({degree_[i], i});
    std::make_heap(heap_.begin(), heap_.end(), later);
  }
  void update(std::uint32_t i, std::size_t degree) {
    degree_[i] = static_cast<std::uint32_t>(degree);
    heap_.push_back({degree_[i], i});
    std::push_heap(heap_.begin(), heap_.end(), later);
  }
  std::uint32_t take() {
    for (;;) {
      std::pop_heap(heap_.begin(), heap_.end(), later);
      const Entry e = heap_.back();
      heap_.pop_back();
      if (degree_[e.point] != e.degree) continue;  // out of date
      degree_[e.point] = kNone;
      return e.point;
    }
  }

 private:
  struct Entry {
    std::uint32_t degree, point;
  };
  static bool later(const Entry& a, const Entry& b) {
    return a.degree != b.degree ? a.degree > b.degree : a.point > b.point;
  }
  std::vector<std::uint32_t> degree_;
  std::vector<Entry> heap_;
};

}  // namespace

bool BlockLdl::eliminate(std::size_t count, std::span<const BlockIndex> index, std::uint64_t max_operations) {
  std::vector<std::vector<std::uint32_t>> neighbors(count);
  for (const BlockIndex& b : index) neighbors[b.i].push_back(b.j), neighbors[b.j].push_back(b.i);
  for (auto& n : neighbors) {
    std::sort(n.begin(), n.end());
    n.erase(std::unique(n.begin(), n.end()), n.end());
  }
  DegreeOrder order(neighbors);
  position_.assign(count, kNone), point_.resize(count);
  column_.assign(1, 0), row_.clear();
  operations_ = 0;
  std::vector<std::uint32_t> merged;
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint32_t p = order.take();
    position_[p] = k, point_[k] = p;
    const std::vector<std::uint32_t> clique = std::move(neighbors[p]);
    operations_ += clique.size() * (clique.size() + 3) / 2 + 1;
    if (operations_ > max_operations) return false;
    row_.insert(row_.end(), clique.begin(), clique.end());
    column_.push_back(static_cast<std::uint32_t>(row_.size()));
    // what touched p is now coupled through it
    for (const std::uint32_t i : clique) {
      merged.clear();
      std::set_union(neighbors[i].begin(), neighbors[i].end(), clique.begin(), clique.end(),
                     std::back_inserter(merged));
      std::erase_if(merged, [&](std::uint32_t q) { return q == i || q == p; });
      neighbors[i].swap(merged);
      order.update(i, neighbors[i].size());
    }
  }
  return true;
}

std::uint32_t BlockLdl::find(std::uint32_t column, std::uint32_t row) const {
  const auto begin = row_.begin() + column_[column], end = row_.begin() + column_[column + 1];
  return static_cast<std::uint32_t>(std::lower_bound(begin, end, row) - row_.begin());
}

void BlockLdl::lay_out(std::span<const BlockIndex> index) {
  const std::size_t n = point_.size();
  row_start_.assign(n + 1, 0);
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t q = column_[j]; q < column_[j + 1]; ++q) row_[q] = position_[row_[q]];
    std::sort(row_.begin() + column_[j], row_.begin() + column_[j + 1]);
    for (std::uint32_t q = column_[j]; q < column_[j + 1]; ++q) ++row_start_[row_[q] + 1];
  }
  for (std::size_t j = 0; j < n; ++j) row_start_[j + 1] += row_start_[j];
  row_column_.resize(row_.size()), row_at_.resize(row_.size());
  std::vector<std::uint32_t> next(row_start_.begin(), row_start_.end() - 1);
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t q = column_[j]; q < column_[j + 1]; ++q) {
      const std::uint32_t at = next[row_[q]]++;
      row_column_[at] = j, row_at_[at] = q;
    }
  slot_.resize(index.size()), input_at_.resize(index.size());
  for (std::size_t k = 0; k < index.size(); ++k) {
    const std::uint32_t a = position_[index[k].i], b = position_[index[k].j];
    slot_[k] = find(std::min(a, b), std::max(a, b));
    input_at_[k] = a > b;
  }
  block_.resize(row_.size()), factor_.resize(n), pivot_.resize(n), work_.resize(n), work_at_.assign(n, 0);
}

bool BlockLdl::analyze(std::size_t count, std::span<const BlockIndex> index, std::uint64_t max_operations) {
  if (!eliminate(count, index, max_operations)) return false;
  lay_out(index);
  return true;
}

bool BlockLdl::factor(const BlockSparse& a, std::span<const Real> free) {
  const std::size_t n = point_.size();
  FEDER_ASSERT(a.diagonal.size() == n && a.index.size() == slot_.size());
  for (Mat3d& m : block_) m.setZero();
  for (std::size_t k = 0; k < slot_.size(); ++k) {
    if (free[a.index[k].i] == 0 || free[a.index[k].j] == 0) continue;
    if (input_at_[k])
      block_[slot_[k]] += a.off[k];
    else
      block_[slot_[k]] += a.off[k].transpose();
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    const std::uint32_t point = point_[j];
    Mat3d pivot = free[point] != 0 ? a.diagonal[point] : Mat3d(Mat3d::Identity());
    for (std::uint32_t q = column_[j]; q < column_[j + 1]; ++q) work_at_[row_[q]] = q;
    // columns k < j that reach row j: L_ij D_j = A_ij - sum L_ik D_k L_jk^T
    for (std::uint32_t r = row_start_[j]; r < row_start_[j + 1]; ++r) {
      const std::uint32_t k = row_column_[r], at = row_at_[r];
      const Mat3d scaled = pivot_[k] * block_[at].transpose();
      pivot.noalias() -= block_[at] * scaled;
      for (std::uint32_t q = at + 1; q < column_[k + 1]; ++q) block_[work_at_[row_[q]]].noalias() -= block_[q] * scaled;
    }
    if (!factor_block(pivot, factor_[j])) return false;
    pivot_[j] = pivot;
    for (std::uint32_t q = column_[j]; q < column_[j + 1]; ++q) {
      for (int row = 0; row < 3; ++row)
        block_[q].row(row) = solve_block(factor_[j], block_[q].row(row).transpose()).transpose();
    }
  }
  return true;
}

void BlockLdl::solve(std::span<const Vec3> b, std::span<const Real> free, std::span<Vec3> x) {
  const auto n = static_cast<std::uint32_t>(point_.size());
  for (std::uint32_t j = 0; j < n; ++j)
    work_[j] = free[point_[j]] != 0 ? Vec3d(b[point_[j]].cast<double>()) : Vec3d(0, 0, 0);
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t q = column_[j]; q < column_[j + 1]; ++q) work_[row_[q]].noalias() -= block_[q] * work_[j];
  for (std::uint32_t j = n; j-- > 0;) {
    Vec3d sum = solve_block(factor_[j], work_[j]);
    for (std::uint32_t q = column_[j]; q < column_[j + 1]; ++q) sum.noalias() -= block_[q].transpose() * work_[row_[q]];
    work_[j] = sum;
    x[point_[j]] = sum.cast<Real>();
  }
}

}  // namespace feder
