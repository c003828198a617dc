// Which parts of a sheet cannot be in contact with each other. A map x of a convex flat domain with gradient F for
// which the symmetric part of R^T F is at least c > 0 everywhere, with one frame R of two orthonormal columns, keeps
// distances: |x(p) - x(q)| >= c |p - q| (Ortega and Rheinboldt 1970, 5.4: monotone maps). So where a window of the rest
// shape moves nearly as one piece, its points are no nearer to each other than a share of what they are at rest, and
// need no search for contact. F is constant in a triangle and linear in the positions, so both ends of a uniform motion
// speak for all of it, and an error of the positions by d takes at most d times the sum of the inverse heights from c.
// The rest shape is cut into square blocks; windows of two by two, four by four ... blocks are tested from those of
// their blocks. A window with a border, slit or hole inside, or covered twice, has no certificate: there, and where the
// rest shape is not flat, everything is searched. Private to the module.
#pragma once
#include <span>

#include "base/jobs.h"
#include "contact/flat_batch.h"
#include "feder/memory.h"
#include "feder/types.h"
#include "state/surface.h"

namespace feder {

class FlatParts {
 public:
  explicit FlatParts(Arena& a);
  // For a mesh and its rest shape; does nothing for the version that it has.
  void build(const Surface& s);
  bool flat() const { return blocks_ > 0; }
  // Points that move from x with v for `time`, off that motion by their deviation at most; the results of decide() and
  // find_pairs() are about these, which have to live as long.
  struct Motion {
    const Vec3 *x = nullptr, *v = nullptr;  // m, m/s
    const Real* deviation = nullptr;        // m
    Real time = 0;                          // s
    bool final = false;                     // decide() gets no smaller deviations: what these rule out is not measured
  };
  void measure(const Motion& m, JobPool& jobs);
  // Whether nothing of it can meet itself, with deviations of `most` at most.
  bool decide(Real most);
  Real sure_share() const;  // of the least windows, that have a certificate
  // Largest sum of inverse heights of a triangle at rest, 1/m: a deviation takes that much of a certificate.
  Real heights() const { return heights_; }
  // Where it is not whole: f(v, edges) for the pairs of a point v[0] and a triangle, or of two edges, that share no
  // point and may come within `margin`, m, of each other; each once.
  template <class F>
  void find_pairs(Real margin, F&& f) {
    find_pairs(
        margin, [](std::uint32_t, std::uint32_t) { return true; }, f);
  }
  // The same for the pairs of blocks, in an order that follows from the mesh, for which wanted(a, b) is true.
  template <class W, class F>
  void find_pairs(Real margin, W&& wanted, F&& f) {
    find_meeting(margin);
    for (const Meeting& m : meeting_)
      if (wanted(m.a, m.b)) each_in(m, margin, f);
  }
  std::uint32_t blocks() const { return blocks_; }
  // Points of the features of a block, from 0 within the sheet.
  std::span<const std::uint32_t> points_of(std::uint32_t block) const { return corners_.of(block); }

 private:
  static constexpr int kLevels = 8;
  static constexpr std::size_t kRun = 6;
  struct Frame {
    Vec3 e[2] = {Vec3::Zero(), Vec3::Zero()};
  };
  struct Block {
    // of the triangles that meet its grown square
    Frame frame;
    Real least = -1, largest = 0, heights = 0;  // symmetric part, gradient, sum of inverse heights (1/m)
    Real deviation = 0;                         // of their points, m
    bool covered = false;                       // its grown square at rest lies in the mesh, once
    // of its own features
    Vec3 drift = Vec3::Zero();  // mean velocity of its points, m/s
    bool boxed = false;         // boxes of its features are those of this search
  };
  struct Node {        // of blocks: bounds of their features
    Aabb box, motion;  // positions, m, and velocities, m/s
  };
  struct Meeting {
    std::uint32_t a, b;
  };
  struct Triangle {
    std::uint32_t v[3];
    Real inverse[4];     // of the edges at rest in the plane, by rows, 1/m
    Real area, heights;  // m^2; sum of the inverse heights, 1/m
  };
  // Points by block, each once: those of block b are point[first[b]] .. point[first[b + 1] - 1].
  struct Points {
    explicit Points(Arena& a) : first(&a), point(&a) {}
    Array<std::uint32_t> first, point;
    std::span<const std::uint32_t> of(std::uint32_t b) const {
      return {point.data() + first[b], first[b + 1] - first[b]};
    }
  };
  // Features by block, each in that of its first point.
  struct Features {
    explicit Features(Arena& a) : first(&a), v(&a), box(&a), all(&a) {}
    Array<std::uint32_t> first, v;  // `points` numbers each
    Array<Aabb> box;                // swept, beside the drift of the block, m
    Array<Aabb> all;                // of all of a block
    std::uint32_t points = 1;
  };
  void list_triangles(const Surface& s, const Vec3 (&axis)[2]);
  void check_covers(const Surface& s, Real reach);
  void list_batches();
  template <class Each>
  void list_points(Points& p, Each&& each);
  template <class Each>
  void list_features(Features& f, std::uint32_t points, Each&& each);
  void measure_block(std::uint32_t block, const Motion& m, int worker);
  Real window(int level, int i, int j, Real most) const;
  int wide(int level) const { return ((nx_ - 1) >> level) + 1; }
  int high(int level) const { return ((ny_ - 1) >> level) + 1; }
  std::size_t node(int level, int i, int j) const {
    return first_node_[level] + static_cast<std::size_t>(i + wide(level) * j);
  }
  bool apart(int level, int ax, int ay, int bx, int by) const;
  void find_meeting(Real margin);
  void descend(int level, int ax, int ay, int bx, int by, Real margin);
  void box_features(std::uint32_t block, Features& f, Real margin);
  // Features of a block.
  struct Some {
    explicit Some(Arena& a) : item(&a), box(&a), run(&a) {}
    Array<std::uint32_t> item;
    Array<Aabb> box, run;  // of each, and of each kRun of them
  };
  // Those that may meet `box`, which goes `apart` beside the block.
  static void pick(const Features& f, std::uint32_t block, const Aabb& box, const Vec3& apart, Some& out);
  // Indices in `hits_` of those from `from` on, of a block that goes `apart` beside that of `a`, which item k of `a`
  // may meet.
  std::span<const std::uint32_t> hits(const Some& a, std::size_t k, const Some& b, std::size_t from, const Vec3& apart);
  template <class F>
  void each_in(const Meeting& m, Real margin, F&& f);

  ObjectId object_;
  std::uint64_t version_ = ~std::uint64_t(0);
  std::uint32_t blocks_ = 0;
  int nx_ = 0, ny_ = 0, levels_ = 0;
  std::size_t first_node_[kLevels + 1] = {};
  Real heights_ = 0, lo_[2] = {0, 0}, hi_[2] = {0, 0};  // of the rest shape in its plane, m
  Motion motion_;
  Array<std::uint32_t> block_of_;  // by point
  Array<Real> flat_;               // by point: two coordinates at rest
  Array<Triangle> triangles_;
  Array<std::uint32_t> first_, own_;  // triangles that meet the square of a block, grown by the longest edge
  Points round_, corners_;            // points of those triangles, and of the features of a block
  // The same triangles in batches, those of block b from first_batch_[b] on; and of a measurement.
  const FlatKernels* kernels_ = &kFlatKernelsPlain;
  Array<FlatBatch> batches_;
  Array<std::uint32_t> first_batch_;
  std::uint32_t most_batches_ = 0;  // of a block
  Array<FlatGradients> gradients_;  // of the block that a thread is at
  Array<Row4> at_, way_;            // by point: positions and displacements, m
  Array<Block> list_;
  Features points_, edges_, faces_;
  Array<unsigned char> sure_;  // by window of all levels: it has a certificate
  Array<Node> nodes_;          // of all levels
  Array<Meeting> meeting_;
  Some some_[2];
  Array<std::uint32_t> hits_;
};

template <class F>
void FlatParts::each_in(const Meeting& m, Real margin, F&& f) {
  for (const std::uint32_t b : {m.a, m.b}) {
    if (list_[b].boxed) continue;
    list_[b].boxed = true;
    for (Features* of : {&points_, &edges_, &faces_}) box_features(b, *of, margin);
  }
  const auto point = [](const Features& of, std::uint32_t k, std::uint32_t i) { return of.v[of.points * k + i]; };
  const Vec3 apart = motion_.time * (list_[m.b].drift - list_[m.a].drift);  // way of b beside a
  Some &own = some_[0], &other = some_[1];
  const auto against = [&](const Features& p, std::uint32_t a, const Features& q, std::uint32_t b, const Vec3& way) {
    pick(p, a, q.all[b], way, own);
    if (!own.item.empty()) pick(q, b, p.all[a], -way, other);
    return !own.item.empty();
  };
  const auto points = [&](std::uint32_t a, std::uint32_t b, const Vec3& way) {  // points of a, triangles of b
    if (!against(points_, a, faces_, b, way)) return;
    for (std::size_t k = 0; k < own.item.size(); ++k)
      for (const std::uint32_t t : hits(own, k, other, 0, way)) {
        const std::uint32_t v[4] = {point(points_, own.item[k], 0), point(faces_, t, 0), point(faces_, t, 1),
                                    point(faces_, t, 2)};
        if (v[0] != v[1] && v[0] != v[2] && v[0] != v[3]) f(v, false);
      }
  };
  points(m.a, m.b, apart);
  if (m.a != m.b) points(m.b, m.a, -apart);
  if (!against(edges_, m.a, edges_, m.b, apart)) return;
  for (std::size_t k = 0; k < own.item.size(); ++k)
    for (const std::uint32_t e : hits(own, k, other, m.a == m.b ? k + 1 : 0, apart)) {
      const std::uint32_t i = own.item[k];
      const std::uint32_t v[4] = {point(edges_, i, 0), point(edges_, i, 1), point(edges_, e, 0), point(edges_, e, 1)};
      if (v[0] != v[2] && v[0] != v[3] && v[1] != v[2] && v[1] != v[3]) f(v, true);
    }
}

}  // namespace feder
