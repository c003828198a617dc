// Greedy colouring in element order: a colour holds elements that share no vertex, so its lanes and batches may run
// in any order and on any thread. A vertex in more than 64 elements of a kind overflows into the last colour's
// successors: those run alone, one lane each.
#include "cloth/batches.h"

#include <algorithm>

namespace feder {
namespace {
constexpr JobGrain kGrain{32, 3'000};  // batches per job
constexpr std::uint32_t kColors = 64;

std::uint32_t direction(const ClothLink& l) { return l.b - l.a; }
std::uint32_t direction(const ClothHinge& h) { return h.v[1] > h.v[0] ? h.v[1] - h.v[0] : h.v[0] - h.v[1]; }
}  // namespace

void ClothBatches::pick(const std::string& width) {
#if defined(__x86_64__) || defined(__i386__)
  if (width != "plain" && __builtin_cpu_supports("avx2")) kernels_ = &kClothKernelsAvx2;
#endif
  (void)width;
}

template <class Elements, class Points>
std::uint32_t ClothBatches::color(const Elements& elements, std::uint32_t total, Points&& points) {
  used_.assign(total, 0);
  color_.resize(elements.size());
  // by direction first: the rows of a sheet then alternate between two colours, which leaves the least strain
  order_.resize(elements.size());
  for (std::uint32_t e = 0; e < order_.size(); ++e) order_[e] = e;
  std::stable_sort(order_.begin(), order_.end(), [&](std::uint32_t x, std::uint32_t y) {
    return direction(elements[x]) < direction(elements[y]);
  });
  std::uint32_t count = 0, alone = 0;
  for (const std::uint32_t e : order_) {
    std::uint64_t taken = 0;
    points(elements[e], [&](std::uint32_t v) { taken |= used_[v]; });
    if (taken == ~std::uint64_t(0)) {
      color_[e] = kColors + alone++;
      continue;
    }
    const auto free = static_cast<std::uint32_t>(__builtin_ctzll(~taken));
    points(elements[e], [&](std::uint32_t v) { used_[v] |= std::uint64_t(1) << free; });
    color_[e] = free;
    count = std::max(count, free + 1);
  }
  // those without a colour follow the last one, each for itself
  for (std::uint32_t& c : color_)
    if (c >= kColors) c = count + (c - kColors);
  return count + alone;
}

void ClothBatches::build(const ClothView& v) {
  if (version_ == v.version) return;
  version_ = v.version;
  const std::uint32_t spare = v.total - 1;
  const auto fill = [&](auto& batches, auto& colors, std::uint32_t count, const auto& elements, auto&& empty,
                        auto&& put) {
    batches.clear(), colors.clear();
    for (std::uint32_t c = 0; c < count; ++c) {
      const auto first = static_cast<unsigned>(batches.size());
      int lane = kLanes;
      for (std::size_t e = 0; e < elements.size(); ++e) {
        if (color_[e] != c) continue;
        if (lane == kLanes) batches.push_back(empty), lane = 0;
        put(batches.back(), lane++, elements[e]);
      }
      colors.push_back({first, static_cast<unsigned>(batches.size())});
    }
  };
  const auto compliance = [](Real k) { return k > 0 ? 1 / k : Real(1e30); };

  LinkBatch no_link{};
  for (int i = 0; i < kLanes; ++i) no_link.a[i] = no_link.b[i] = spare, no_link.compliance.v[i] = 1;
  std::uint32_t count = color(v.mesh->links, v.total, [](const ClothLink& l, auto&& f) { f(l.a), f(l.b); });
  fill(links_, link_colors_, count, v.mesh->links, no_link, [&](LinkBatch& b, int i, const ClothLink& l) {
    b.a[i] = l.a, b.b[i] = l.b, b.rest.v[i] = l.rest, b.compliance.v[i] = compliance(l.stiffness);
  });

  HingeBatch no_hinge{};
  for (int i = 0; i < kLanes; ++i) {
    for (auto& row : no_hinge.v) row[i] = spare;
    no_hinge.cosine.v[i] = no_hinge.compliance.v[i] = 1;
  }
  count = color(v.mesh->hinges, v.total, [](const ClothHinge& h, auto&& f) { for (std::uint32_t k : h.v) f(k); });
  fill(hinges_, hinge_colors_, count, v.mesh->hinges, no_hinge, [&](HingeBatch& b, int i, const ClothHinge& h) {
    for (int k = 0; k < 4; ++k) b.v[k][i] = h.v[k];
    sin_cos(h.angle, b.sine.v[i], b.cosine.v[i]);
    b.compliance.v[i] = compliance(h.stiffness);
  });
}

void ClothBatches::place(const ClothView& v) {
  const auto put = [](Lane8x3& to, int i, const Vec3& d) { to.x.v[i] = d[0], to.y.v[i] = d[1], to.z.v[i] = d[2]; };
  for (LinkBatch& b : links_)
    for (int i = 0; i < kLanes; ++i) put(b.base, i, v.position[b.b[i]] - v.position[b.a[i]]);
  for (HingeBatch& b : hinges_)
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < kLanes; ++i) put(b.base[k], i, v.position[b.v[k + 1][i]] - v.position[b.v[0][i]]);
}

void ClothBatches::run(Kernel kernel, const Array<Color>& colors, ClothPass pass, StepContext& c) {
  if (colors.empty()) return;
  if (c.jobs->threads() == 1) {  // batches lie in the order of their colours
    pass.first = colors.front().first, pass.last = colors.back().last;
    kernel(pass);
    return;
  }
  const auto sweep = [&](std::uint32_t first, std::uint32_t last, int) {
    ClothPass part = pass;
    part.first = first, part.last = last;
    kernel(part);
  };
  // colour after colour is one loop; those beyond kStages follow in loops of their own
  std::size_t count = 0;
  for (const Color& color : colors) {
    stages_[count++] = JobPool::stage(color.first, color.last, kGrain, sweep);
    if (count < kStages && &color != &colors.back()) continue;
    c.jobs->run_stages({stages_, count});
    count = 0;
  }
}

void ClothBatches::solve(const ClothView& v, Real h, bool hinges, bool again, StepContext& c) {
  const ClothPass pass{links_.data(), hinges_.data(), 0, 0, &v.moved->x, &v.speed->x, 1 / (h * h), h, 0, again};
  run(kernels_->links, link_colors_, pass, c);
  if (hinges) run(kernels_->hinges, hinge_colors_, pass, c);
}

void ClothBatches::bend(const ClothView& v, Real h, StepContext& c) {
  const ClothPass pass{links_.data(), hinges_.data(), 0, 0, &v.moved->x, &v.speed->x, 1 / (h * h), h, 0, false};
  run(kernels_->bend_hinges, hinge_colors_, pass, c);
}

void ClothBatches::damp(const ClothView& v, Real h, StepContext& c) {
  const ClothPass pass{links_.data(), hinges_.data(), 0, 0, &v.moved->x, &v.speed->x, 0, h, v.damping * h, false};
  run(kernels_->damp_links, link_colors_, pass, c);
  run(kernels_->damp_hinges, hinge_colors_, pass, c);
}

}  // namespace feder
