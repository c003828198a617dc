// Cloth at rest whose vertices' equilibrium is known: a hanging sheet (fluid-cloth.md 3.4: what small steps leave of
// strain), a strip hung at both ends (catenary), a clamped strip under its own weight (Romero et al. 2021).
#include <algorithm>

#include "study/cloth_problem.h"

namespace feder {
namespace {

// n rows under the first, each link carries what is below it; with `load` on the last row.
class HangingSheet final : public ClothProblem {
 public:
  explicit HangingSheet(const Params& given) {
    ProblemOptions o(given, info_);
    const int n = o.integer("rows", 20, 2, 200, "links from the top to the bottom of 1 m");
    const double stretch = o.number("stiffness", 2000, 1, 1e8, "N/m, stretch");
    const double load = o.number("load", 0, 0, 1e4, "force at the lower border by the weight of the sheet");
    info_.t_end = o.number("t_end", 1, 0.1, 60, "s");
    constexpr int kColumns = 3;
    const double dy = 1.0 / n, width = dy * (kColumns - 1);
    desc_.nx = kColumns, desc_.ny = static_cast<std::uint32_t>(n + 1);
    desc_.size[0] = static_cast<Real>(width), desc_.size[1] = 1;
    desc_.stretch = static_cast<Real>(stretch), desc_.shear = 0, desc_.bend = 0;
    desc_.damping = Real(0.02), desc_.self_collision = false;
    desc_.pin_names = {"top"};
    desc_.max_strain = kInfinity;
    const double row = static_cast<double>(desc_.area_density) * dy * width * kGravity, hung = load * n * row;
    double y = 0;
    for (int j = 0; j <= n; ++j) {
      if (j > 0) y -= dy * (1 + (row * (n - j + 0.5) + hung) / (stretch * width));
      for (int i = 0; i < kColumns; ++i) {
        rest_.insert(rest_.end(), {(static_cast<double>(i) / (kColumns - 1) - 0.5) * width, y, 0});
        if (load > 0) pull_.push_back(j < n ? 0 : hung / (kColumns - 1) * (i == 0 || i + 1 == kColumns ? 0.5 : 1));
      }
    }
    substeps_ = {2, 4, 8, 16, 32, 64, 128};
    measure(-y, "each link carries the weight below it");
  }
};

// Both ends `span` 1 m apart; equal links with equal masses hang in a polygon of constant horizontal tension.
class Catenary final : public ClothProblem {
 public:
  explicit Catenary(const Params& given) {
    ProblemOptions o(given, info_);
    const int n = o.integer("links", 40, 4, 200, "along the strip, an even number");
    const double length = o.number("length", 1.5, 1.05, 10, "m, the ends are 1 m apart");
    const double stretch = o.number("stiffness", 2000, 1, 1e8, "N/m, stretch");
    info_.t_end = o.number("t_end", 1, 0.1, 60, "s");
    if (n % 2) throw SceneError("links: expected an even number, got " + std::to_string(n));
    const double link = length / n, width = 2 * link;
    const double weight = static_cast<double>(desc_.area_density) * link * width * kGravity, k = stretch * width / link;
    desc_.nx = static_cast<std::uint32_t>(n + 1), desc_.ny = 3;
    desc_.size[0] = static_cast<Real>(length), desc_.size[1] = static_cast<Real>(width);
    desc_.stretch = static_cast<Real>(stretch), desc_.shear = 0, desc_.bend = 0;
    desc_.damping = Real(0.02), desc_.self_collision = false;
    desc_.pin_names = {"left", "right"};
    desc_.max_strain = kInfinity;
    // links of half the strip from its middle: link i carries the weight of i + 1/2 masses (n even: one hangs in the
    // middle)
    const auto half = [&](double tension, std::vector<double>* xy) {
      double x = 0, y = 0;
      for (int i = 0; i < n / 2; ++i) {
        if (xy) xy->push_back(x), xy->push_back(y);
        const double down = (i + 0.5) * weight, pull = std::hypot(tension, down), size = link + pull / k;
        x += size * tension / pull, y += size * down / pull;
      }
      if (xy) xy->push_back(x), xy->push_back(y);
      return x;
    };
    double lo = 1e-9 * weight, hi = 1e9 * weight;
    for (int i = 0; i < 200; ++i) {
      const double mid = std::sqrt(lo * hi);
      (half(mid, nullptr) < 0.5 ? lo : hi) = mid;
    }
    std::vector<double> xy;
    half(std::sqrt(lo * hi), &xy);
    const double top = xy.back();
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i <= n; ++i) {
        const int from = std::abs(i - n / 2);
        const auto at = static_cast<std::size_t>(2 * from);
        rest_.insert(rest_.end(), {i < n / 2 ? -xy[at] : xy[at], xy[at + 1] - top, (j - 1) * link});
      }
    substeps_ = {2, 4, 8, 16, 32, 64, 128};
    measure(top, "polygon of links with one horizontal tension");
  }
};

// Angles of the segments from the free end to the clamp: the moment at each vertex bends its hinge.
class Cantilever final : public ClothProblem {
 public:
  explicit Cantilever(const Params& given) {
    ProblemOptions o(given, info_);
    const int n = o.integer("segments", 20, 4, 100, "of 1 m together");
    const double gamma = o.number("gamma", 10, 0.01, 100, "weight by bending stiffness, area_density g L^3/bend");
    info_.t_end = o.number("t_end", 1, 0.1, 60, "s");
    const double link = 1.0 / n, width = 2 * link, density = 1, weight = density * link * width * kGravity;
    const double hinge = density * kGravity / gamma * width / link;  // N m per rad
    desc_.nx = static_cast<std::uint32_t>(n + 1), desc_.ny = 3;
    desc_.size[0] = 1, desc_.size[1] = static_cast<Real>(width);
    desc_.area_density = static_cast<Real>(density);
    desc_.pose.position = Vec3(Real(0.5), 0, 0);  // the clamp at 0
    desc_.stretch = Real(1e5), desc_.bend = static_cast<Real>(density * kGravity / gamma);
    desc_.damping = Real(0.02), desc_.self_collision = false, desc_.max_strain = kInfinity;
    desc_.pin_names = {"left_clamped"};
    std::vector<double> angle(static_cast<std::size_t>(n));
    const auto shoot = [&](double tip) {
      double moment = 0, below = 0.5 * weight, now = tip;  // weight beyond the vertex; the last one is half
      for (int i = n - 1; i >= 0; --i) {
        angle[static_cast<std::size_t>(i)] = now;
        moment += below * link * std::cos(now);
        below += weight;
        now -= moment / (i > 0 ? hinge : 2 * hinge);
      }
      return now;  // slope behind the clamp: 0
    };
    double lo = 0, hi = 1.5707963267948966;
    for (int i = 0; i < 200; ++i) {
      const double mid = (lo + hi) / 2;
      (shoot(mid) < 0 ? lo : hi) = mid;
    }
    for (int j = 0; j < 3; ++j) {
      double x = 0, y = 0;
      for (int i = 0; i <= n; ++i) {
        rest_.insert(rest_.end(), {x, y, (j - 1) * link});
        if (i == n) break;
        x += link * std::cos(angle[static_cast<std::size_t>(i)]),
            y -= link * std::sin(angle[static_cast<std::size_t>(i)]);
      }
    }
    substeps_ = {4, 8, 16, 32, 64, 128, 256};
    measure(1, "moments at the vertices, inextensible");
    info_.reference.uncertainty = 1e-4;  // stretch is not in it
  }
};

template <class T>
std::unique_ptr<StudyProblem> make(Arena&, const Params& p) {
  return std::make_unique<T>(p);
}

}  // namespace

Variant<StudyProblem> study_hanging_sheet() {
  return {"hanging_sheet", "a sheet hung by its upper border: what small steps leave of strain", &make<HangingSheet>};
}
Variant<StudyProblem> study_catenary() { return {"catenary", "a strip of cloth hung at both ends", &make<Catenary>}; }
Variant<StudyProblem> study_cantilever() {
  return {"cantilever", "a clamped strip of cloth bends under its own weight", &make<Cantilever>};
}

}  // namespace feder
