#include "geom/distance_field.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "feder/error.h"

namespace feder {
namespace {

constexpr int kMaxRoots = 8;  // along an axis, while levels are few
constexpr int kMaxLevels = 5;
constexpr int kOutsideSteps = 3;
constexpr std::uint64_t kMostCorners = std::uint64_t(1) << 30;

template <class T>
void put(std::string& out, const T* data, std::size_t count) {
  out.append(reinterpret_cast<const char*>(data), count * sizeof(T));
}

template <class T>
void take(std::string_view& in, T* data, std::size_t count) {
  if (in.size() < count * sizeof(T)) throw SceneError("sdf: its content is cut short");
  if (count > 0) std::memcpy(data, in.data(), count * sizeof(T));
  in.remove_prefix(count * sizeof(T));
}

template <class T>
void put_list(std::string& out, const std::vector<T>& list) {
  const std::uint64_t count = list.size();
  put(out, &count, 1), put(out, list.data(), list.size());
}

template <class T>
void take_list(std::string_view& in, std::vector<T>& list) {
  std::uint64_t count = 0;
  take(in, &count, 1);
  if (count > in.size() / sizeof(T)) throw SceneError("sdf: its content is cut short");
  list.resize(count);
  take(in, list.data(), list.size());
}

}  // namespace

void FieldLayout::range(const Aabb& box, Real reach, int (&lo)[3], int (&hi)[3]) const {
  for (int k = 0; k < 3; ++k) {
    const auto corner = [&](Real x) { return std::clamp((x - origin[k]) / spacing, Real(-1), Real(n[k])); };
    lo[k] = std::max(0, static_cast<int>(std::ceil(corner(box.lo[k] - reach))));
    hi[k] = std::min(n[k] - 1, static_cast<int>(std::floor(corner(box.hi[k] + reach))));
  }
}

DistanceField::DistanceField(const FieldLayout& layout, std::vector<float> values)
    : layout_(layout), inverse_(1 / layout.spacing), values_(std::move(values)) {
  FEDER_ASSERT(values_.size() == layout.corners() && layout.n[0] > 1 && layout.n[1] > 1 && layout.n[2] > 1);
}

// What a node is while the tree is built.
struct DistanceField::Builder {
  DistanceField& field;
  Real band, tolerance;
  Distance distance;
  const void* context;

  struct Brick {
    int level = 0, at[3] = {0, 0, 0};  // in bricks of that level
    std::uint32_t number = kNone;      // once kept
    Real v[kBrick];
  };

  Real cell(int level) const { return field.layout_.spacing * Real(1 << level); }
  Vec3 place(const Brick& b, Real x, Real y, Real z) const {  // in cells of the brick
    const Real size = cell(b.level);
    return field.layout_.origin +
           size * Vec3(Real(kCells * b.at[0]) + x, Real(kCells * b.at[1]) + y, Real(kCells * b.at[2]) + z);
  }
  Real ask(const Brick& b, Real x, Real y, Real z) const { return distance(context, place(b, x, y, z)); }
  void fill(Brick& b) const {
    Real* to = b.v;
    for (int z = 0; z < kCorners; ++z)
      for (int y = 0; y < kCorners; ++y)
        for (int x = 0; x < kCorners; ++x) *to++ = ask(b, Real(x), Real(y), Real(z));
  }
  // In the middle of a cell.
  static Real middle_of(const Brick& b, int x, int y, int z) {
    const Real* c = b.v + x + kCorners * (y + kCorners * z);
    Real sum = 0;
    for (const int dz : {0, kCorners * kCorners})
      for (const int dy : {0, kCorners}) sum += c[dz + dy] + c[dz + dy + 1];
    return sum / 8;
  }
  // At a place in half cells.
  static Real between(const Brick& b, int x, int y, int z) {
    const int i = std::min(x / 2, kCells - 1), j = std::min(y / 2, kCells - 1), k = std::min(z / 2, kCells - 1);
    const Real t[3] = {Real(x - 2 * i) / 2, Real(y - 2 * j) / 2, Real(z - 2 * k) / 2};
    const Real* c = b.v + i + kCorners * (j + kCorners * k);
    Real sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const int u = corner & 1, v = corner >> 1 & 1, w = corner >> 2;
      sum +=
          c[u + kCorners * (v + kCorners * w)] * (u ? t[0] : 1 - t[0]) * (v ? t[1] : 1 - t[1]) * (w ? t[2] : 1 - t[2]);
    }
    return sum;
  }
  bool close(Real got, Real exact) const { return std::abs(got - exact) <= std::max(tolerance, std::abs(exact) / 8); }
  // Do the brick's cells from `first`, `count` along each axis, hold what is in their middles?
  bool holds(const Brick& b, const int (&first)[3], int count) const {
    for (int z = first[2]; z < first[2] + count; ++z)
      for (int y = first[1]; y < first[1] + count; ++y)
        for (int x = first[0]; x < first[0] + count; ++x)
          if (!close(middle_of(b, x, y, z), ask(b, Real(x) + Real(0.5), Real(y) + Real(0.5), Real(z) + Real(0.5))))
            return false;
    return true;
  }
  std::uint32_t keep(Brick& b) const {
    if (b.number != kNone) return b.number;
    Real most = 0;
    for (const Real x : b.v) most = std::max(most, std::abs(x));
    const Real scale = most / 32767;
    b.number = static_cast<std::uint32_t>(field.scale_.size());
    field.scale_.push_back(static_cast<float>(scale));
    field.level_.push_back(static_cast<std::uint8_t>(b.level));
    for (const Real x : b.v) field.bricks_.push_back(static_cast<std::int16_t>(scale > 0 ? std::lround(x / scale) : 0));
    return b.number;
  }

  // Writes the node; `parent`: of the level above, null for roots.
  void build(std::uint32_t node, int level, const int (&at)[3], Brick* parent) {
    Brick own;
    own.level = level;
    for (int k = 0; k < 3; ++k) own.at[k] = at[k];
    constexpr Real kHalf = Real(kCells) / 2;
    const Real reach = Real(1.7320508) * kHalf * cell(level);
    const bool near = std::abs(ask(own, kHalf, kHalf, kHalf)) <= reach + band;
    if (!near && parent) {  // the parent's cells there may do
      const int first[3] = {2 * (at[0] & 1), 2 * (at[1] & 1), 2 * (at[2] & 1)};
      if (holds(*parent, first, 2)) {
        field.nodes_[node] = kLeaf | keep(*parent);
        return;
      }
    }
    fill(own);
    bool leaf = level == 0;
    if (level == 0 && parent && tolerance <= 0) {
      // no corner in the band: again the parent's may do, at every corner of this
      bool enough = true;
      for (int z = 0, i = 0; z < kCorners && enough; ++z)
        for (int y = 0; y < kCorners; ++y)
          for (int x = 0; x < kCorners; ++x, ++i)
            enough =
                enough && std::abs(own.v[i]) > band &&
                close(between(*parent, kCells * (at[0] & 1) + x, kCells * (at[1] & 1) + y, kCells * (at[2] & 1) + z),
                      own.v[i]);
      if (enough) {
        field.nodes_[node] = kLeaf | keep(*parent);
        return;
      }
    }
    const int all[3] = {0, 0, 0};
    if (!leaf && (!near || tolerance > 0)) leaf = holds_all(own, all, near);
    if (leaf) {
      field.nodes_[node] = kLeaf | keep(own);
      return;
    }
    const auto child = static_cast<std::uint32_t>(field.nodes_.size());
    field.nodes_[node] = child;
    field.nodes_.resize(field.nodes_.size() + 8);
    for (int k = 0; k < 8; ++k)
      build(child + static_cast<std::uint32_t>(k), level - 1,
            {2 * at[0] + (k & 1), 2 * at[1] + (k >> 1 & 1), 2 * at[2] + (k >> 2)}, &own);
  }
  // Near the surface only the tolerance counts.
  bool holds_all(const Brick& b, const int (&first)[3], bool near) const {
    if (!near) return holds(b, first, kCells);
    for (int z = 0; z < kCells; ++z)
      for (int y = 0; y < kCells; ++y)
        for (int x = 0; x < kCells; ++x)
          if (std::abs(middle_of(b, x, y, z) - ask(b, Real(x) + Real(0.5), Real(y) + Real(0.5), Real(z) + Real(0.5))) >
              tolerance)
            return false;
    return true;
  }
};

DistanceField DistanceField::adaptive(FieldLayout layout, Real band, Real tolerance, Distance distance,
                                      const void* context) {
  DistanceField f;
  const auto roots = [&](int axis, int levels) {
    const int cells = kCells << levels;
    return (layout.n[axis] - 2) / cells + 1;
  };
  f.levels_ = 0;
  while (f.levels_ < kMaxLevels &&
         std::max({roots(0, f.levels_), roots(1, f.levels_), roots(2, f.levels_)}) > kMaxRoots)
    ++f.levels_;
  for (int k = 0; k < 3; ++k) {
    f.roots_[k] = roots(k, f.levels_);
    layout.n[k] = f.roots_[k] * (kCells << f.levels_) + 1;
  }
  f.layout_ = layout, f.inverse_ = 1 / layout.spacing;
  f.nodes_.assign(std::size_t(f.roots_[0]) * std::size_t(f.roots_[1]) * std::size_t(f.roots_[2]), 0u);
  Builder builder{f, band, tolerance, distance, context};
  std::uint32_t node = 0;
  for (int z = 0; z < f.roots_[2]; ++z)
    for (int y = 0; y < f.roots_[1]; ++y)
      for (int x = 0; x < f.roots_[0]; ++x) builder.build(node++, f.levels_, {x, y, z}, nullptr);
  return f;
}

void DistanceField::brick_cell(const Vec3& u, Cell& cell) const {
  int b[3];  // finest brick
  for (int k = 0; k < 3; ++k) b[k] = std::min(static_cast<int>(u[k]), layout_.n[k] - 2) / kCells;
  int level = levels_;
  std::uint32_t node =
      nodes_[static_cast<std::size_t>((b[0] >> level) + roots_[0] * ((b[1] >> level) + roots_[1] * (b[2] >> level)))];
  while (!(node & kLeaf)) {
    --level;
    node = nodes_[node + static_cast<std::uint32_t>((b[0] >> level & 1) | (b[1] >> level & 1) << 1 |
                                                    (b[2] >> level & 1) << 2)];
  }
  const std::uint32_t brick = node & ~kLeaf;
  level = level_[brick];  // of the parent, where that was enough
  int at[3];
  const Real shrink = Real(1) / Real(1 << level);
  for (int k = 0; k < 3; ++k) {
    const Real local = u[k] * shrink - Real(kCells * (b[k] >> level));
    at[k] = std::min(static_cast<int>(local), kCells - 1);
    cell.at[k] = local - Real(at[k]);
  }
  const std::int16_t* c = &bricks_[std::size_t(brick) * kBrick] + at[0] + kCorners * (at[1] + kCorners * at[2]);
  const Real scale = Real(scale_[brick]);
  for (int k = 0; k < 8; ++k)
    cell.v[k] = scale * Real(c[(k & 1) + kCorners * (k >> 1 & 1) + kCorners * kCorners * (k >> 2)]);
  cell.size = layout_.spacing * Real(1 << level);
}

void DistanceField::cell_of(const Vec3& u, Cell& cell) const {
  if (is_adaptive()) return brick_cell(u, cell);
  int at[3];
  for (int k = 0; k < 3; ++k) {
    at[k] = std::min(static_cast<int>(u[k]), layout_.n[k] - 2);
    cell.at[k] = u[k] - Real(at[k]);
  }
  const std::ptrdiff_t row = layout_.n[0], layer = row * layout_.n[1];
  const float* c = values_.data() + at[0] + row * at[1] + layer * at[2];
  cell.v[0] = Real(c[0]), cell.v[1] = Real(c[1]), cell.v[2] = Real(c[row]), cell.v[3] = Real(c[row + 1]);
  c += layer;
  cell.v[4] = Real(c[0]), cell.v[5] = Real(c[1]), cell.v[6] = Real(c[row]), cell.v[7] = Real(c[row + 1]);
  cell.size = layout_.spacing;
}

Real DistanceField::inside(const Vec3& p, Vec3* slope) const {
  Cell c;
  cell_of(p, c);
  const Real x = c.at[0], y = c.at[1], z = c.at[2];
  const Real a0 = c.v[0] + x * (c.v[1] - c.v[0]), a1 = c.v[2] + x * (c.v[3] - c.v[2]);
  const Real a2 = c.v[4] + x * (c.v[5] - c.v[4]), a3 = c.v[6] + x * (c.v[7] - c.v[6]);
  const Real b0 = a0 + y * (a1 - a0), b1 = a2 + y * (a3 - a2);
  if (slope) {
    const Real e0 = c.v[1] - c.v[0], e1 = c.v[3] - c.v[2], e2 = c.v[5] - c.v[4], e3 = c.v[7] - c.v[6];
    const Real f0 = e0 + y * (e1 - e0), f1 = e2 + y * (e3 - e2);
    const Real inverse = 1 / c.size;
    *slope =
        Vec3(inverse * (f0 + z * (f1 - f0)), inverse * ((a1 - a0) + z * ((a3 - a2) - (a1 - a0))), inverse * (b1 - b0));
  }
  return b0 + z * (b1 - b0);
}

Real DistanceField::at(const Vec3& p) const {
  Vec3 u = inverse_ * (p - layout_.origin), in;
  for (int k = 0; k < 3; ++k) in[k] = std::min(std::max(Real(0), u[k]), Real(layout_.n[k] - 1));
  if (u == in) return inside(u, nullptr);
  Vec3 slope;
  return at(p, slope);
}

Real DistanceField::at_least(const Vec3& p) const {
  const Vec3 u = inverse_ * (p - layout_.origin);
  Vec3 in;
  for (int k = 0; k < 3; ++k) in[k] = std::min(std::max(Real(0), u[k]), Real(layout_.n[k] - 1));
  const Real d = inside(in, nullptr);
  if (u == in) return d;
  const Vec3 gap = layout_.spacing * (u - in);
  const Real on = std::max(is_adaptive() ? Real(0.875) * d : d, Real(0));  // adaptive: off by an eighth
  return std::sqrt(dot(gap, gap) + on * on);
}

Real DistanceField::at(const Vec3& p, Vec3& slope) const {
  const Vec3 u = inverse_ * (p - layout_.origin);
  Vec3 in;
  for (int k = 0; k < 3; ++k) in[k] = std::min(std::max(Real(0), u[k]), Real(layout_.n[k] - 1));  // NaN: 0
  const Real d = inside(in, &slope);
  if (u == in) return d;
  // the surface point nearest to where the way to it enters the box
  Vec3 away = u - in;
  for (int i = 0;; ++i) {
    const Real deep = inverse_ * inside(in, &slope);  // before the slope is read
    const Vec3 surface = in - deep * normalized_or(slope, Vec3(0, 1, 0));
    away = u - surface;
    if (i == kOutsideSteps) break;
    Real enter = 0;
    for (int k = 0; k < 3; ++k) {
      const Real limit = u[k] < 0 ? Real(0) : Real(layout_.n[k] - 1);
      if (u[k] < 0 || u[k] > limit) enter = std::max(enter, (limit - u[k]) / (surface[k] - u[k]));
    }
    if (!(enter >= 0 && enter <= 1)) break;
    for (int k = 0; k < 3; ++k)
      in[k] = std::min(std::max(Real(0), u[k] + enter * (surface[k] - u[k])), Real(layout_.n[k] - 1));
  }
  slope = normalized_or(away, Vec3(0, 1, 0));
  return layout_.spacing * length(away);
}

Real DistanceField::smooth_at(const Vec3& p, Vec3& slope) const {
  const Real half = layout_.spacing / 2;
  if (is_adaptive() || !dense_slope(inverse_ * (p - layout_.origin), slope)) {
    for (int k = 0; k < 3; ++k) {
      Vec3 to = p, from = p;
      to[k] += half, from[k] -= half;
      slope[k] = inverse_ * (at(to) - at(from));
    }
  }
  return at(p);
}

// The same differences from 12 corners each; false near the rim.
bool DistanceField::dense_slope(const Vec3& u, Vec3& slope) const {
  const std::ptrdiff_t stride[3] = {1, layout_.n[0], std::ptrdiff_t(layout_.n[0]) * layout_.n[1]};
  std::ptrdiff_t cell[3], shifted[3];  // of u, and of half a cell before it
  Real t[3], s[3];
  for (int k = 0; k < 3; ++k) {
    const Real v = u[k] - Real(0.5);
    if (!(v >= 0 && u[k] < Real(layout_.n[k] - 2))) return false;
    cell[k] = static_cast<std::ptrdiff_t>(u[k]), shifted[k] = static_cast<std::ptrdiff_t>(v);
    t[k] = u[k] - Real(cell[k]), s[k] = v - Real(shifted[k]);
  }
  const std::ptrdiff_t at = cell[0] + stride[1] * cell[1] + stride[2] * cell[2];
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const float* c = values_.data() + at + stride[k] * (shifted[k] - cell[k]);
    const auto difference = [&](const float* from) {
      const Real a = Real(from[0]), b = Real(from[stride[k]]), d = Real(from[2 * stride[k]]);
      return (b - a) + s[k] * ((d - b) - (b - a));
    };
    const Real d00 = difference(c), d10 = difference(c + stride[i]);
    const Real d01 = difference(c + stride[j]), d11 = difference(c + stride[i] + stride[j]);
    const Real low = d00 + t[i] * (d10 - d00), high = d01 + t[i] * (d11 - d01);
    slope[k] = inverse_ * (low + t[j] * (high - low));
  }
  return true;
}

std::size_t DistanceField::bytes() const {
  return sizeof(float) * (values_.size() + scale_.size()) + sizeof(std::uint32_t) * nodes_.size() +
         sizeof(std::int16_t) * bricks_.size() + level_.size();
}

std::string DistanceField::content() const {
  std::string out;
  const double head[4] = {layout_.origin[0], layout_.origin[1], layout_.origin[2], layout_.spacing};
  const std::int32_t whole[7] = {layout_.n[0], layout_.n[1], layout_.n[2], levels_, roots_[0], roots_[1], roots_[2]};
  put(out, head, 4), put(out, whole, 7);
  put_list(out, values_), put_list(out, nodes_), put_list(out, scale_), put_list(out, level_), put_list(out, bricks_);
  return out;
}

DistanceField DistanceField::from_content(std::string_view bytes) {
  DistanceField f;
  double head[4];
  std::int32_t whole[7];
  take(bytes, head, 4), take(bytes, whole, 7);
  f.layout_.origin = Vec3(Real(head[0]), Real(head[1]), Real(head[2])), f.layout_.spacing = Real(head[3]);
  for (int k = 0; k < 3; ++k) f.layout_.n[k] = whole[k], f.roots_[k] = whole[4 + k];
  f.levels_ = whole[3];
  take_list(bytes, f.values_), take_list(bytes, f.nodes_), take_list(bytes, f.scale_), take_list(bytes, f.level_),
      take_list(bytes, f.bricks_);
  f.check();
  f.inverse_ = 1 / f.layout_.spacing;
  return f;
}

// Nothing that is read later lies beside the lists, whatever the bytes were.
void DistanceField::check() const {
  const auto require = [](bool good) {
    if (!good) throw SceneError("sdf: its content is damaged");
  };
  require(is_finite(layout_.origin) && layout_.spacing > 0 && is_finite(layout_.spacing));
  std::uint64_t corners = 1;
  for (const int n : layout_.n) {
    require(n >= 2 && n <= 1 << 20);
    corners *= static_cast<std::uint64_t>(n);
    require(corners <= kMostCorners << 6);
  }
  if (!is_adaptive()) return require(values_.size() == corners);
  require(levels_ <= kMaxLevels && bricks_.size() == scale_.size() * kBrick && level_.size() == scale_.size());
  for (const std::uint8_t level : level_) require(level <= levels_);
  std::uint64_t roots = 1;
  for (int k = 0; k < 3; ++k) {
    require(roots_[k] >= 1 && roots_[k] * (kCells << levels_) + 1 == layout_.n[k]);
    roots *= static_cast<std::uint64_t>(roots_[k]);
  }
  require(nodes_.size() >= roots);
  // children lie behind their parent, and each level has its depth
  std::vector<std::int8_t> depth(nodes_.size(), -1);
  std::fill(depth.begin(), depth.begin() + static_cast<std::ptrdiff_t>(roots), std::int8_t(levels_));
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    require(depth[i] >= 0);
    if (nodes_[i] & kLeaf) {
      require((nodes_[i] & ~kLeaf) < scale_.size());
      continue;
    }
    require(nodes_[i] > i && nodes_[i] + std::size_t(8) <= nodes_.size() && depth[i] > 0);
    for (std::size_t k = 0; k < 8; ++k) {
      require(depth[nodes_[i] + k] < 0);
      depth[nodes_[i] + k] = std::int8_t(depth[i] - 1);
    }
  }
}

}  // namespace feder
