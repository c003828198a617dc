// How often a thin viscous sheet that is pressed on a plate folds: the reference of scenes/study/honey_fold.lua. Pieces
// between points in the plane resist stretching by 4 mu h and bending by mu h^3 / 3 (Trouton 1906; Ribe, J. Fluid Mech.
// 457, 2002), as in Bergou et al., Discrete Viscous Threads, 2010. Velocities solve those and inertia, in each step;
// points above the slot come down with its speed, those that reach the plate stay. Lengths by the height of the slot,
// speeds by that of the sheet.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "support/catch.h"

namespace {

struct Point {
  double x = 0, y = 0;
};

struct Sheet {
  double thickness, viscosity, gravity;  // by height, by height times speed, by squared speed over height
  int pieces;                            // over the height
};

// Symmetric, positive: entries that far from the diagonal.
class Band {
 public:
  explicit Band(std::size_t size) : rows_(size), right_(size) {}
  // weight / 2 (terms . v)^2 of a dissipation, `known` of the dot product: at[k] is where the pair of term k is, -1 if
  // known.
  void add(std::size_t count, const int* at, const Point* terms, double known, double weight) {
    for (std::size_t a = 0; a < 2 * count; ++a) {
      const int i = place(at, a);
      if (i < 0) continue;
      right_[static_cast<std::size_t>(i)] -= weight * known * term(terms, a);
      for (std::size_t b = 0; b < 2 * count; ++b) {
        const int j = place(at, b);
        if (j >= 0 && j <= i) entry(i, j) += weight * term(terms, a) * term(terms, b);
      }
    }
  }
  void add(int i, double diagonal, double right) {
    entry(i, i) += diagonal;
    right_[static_cast<std::size_t>(i)] += right;
  }
  // Cholesky.
  std::vector<double> solve() {
    const int n = static_cast<int>(rows_.size());
    for (int i = 0; i < n; ++i)
      for (int j = std::max(0, i - kWidth); j <= i; ++j) {
        for (int k = std::max(0, i - kWidth); k < j; ++k) entry(i, j) -= entry(i, k) * entry(j, k);
        entry(i, j) = i == j ? std::sqrt(entry(i, i)) : entry(i, j) / entry(j, j);
      }
    std::vector<double> x = right_;
    const auto at = [&](int i) -> double& { return x[static_cast<std::size_t>(i)]; };
    for (int i = 0; i < n; ++i) {
      for (int k = std::max(0, i - kWidth); k < i; ++k) at(i) -= entry(i, k) * at(k);
      at(i) /= entry(i, i);
    }
    for (int i = n - 1; i >= 0; --i) {
      for (int k = i + 1; k <= std::min(n - 1, i + kWidth); ++k) at(i) -= entry(k, i) * at(k);
      at(i) /= entry(i, i);
    }
    return x;
  }

 private:
  static constexpr int kWidth = 5;  // three points that follow each other
  static int place(const int* at, std::size_t a) {
    return at[a / 2] < 0 ? -1 : 2 * at[a / 2] + static_cast<int>(a % 2);
  }
  static double term(const Point* terms, std::size_t a) { return a % 2 ? terms[a / 2].y : terms[a / 2].x; }
  double& entry(int i, int j) { return rows_[static_cast<std::size_t>(i)][static_cast<std::size_t>(kWidth - (i - j))]; }
  std::vector<std::array<double, kWidth + 1>> rows_;
  std::vector<double> right_;
};

struct State {
  std::vector<Point> x, v;
  std::size_t laid = 0, last = 0;  // the last point that lies, and the last one below the slot
};

// Turn of the piece from one point to the next, by a motion of that.
Point turn(const Point& from, const Point& to) {
  const double dx = to.x - from.x, dy = to.y - from.y, squared = dx * dx + dy * dy;
  return {-dy / squared, dx / squared};
}

// For the velocities of what is between the slot and the plate.
Band equations(const Sheet& s, const State& now, double step) {
  const auto& [x, v, laid, last] = now;
  Band m(2 * (last - laid));
  // of points that follow each other
  const auto dissipate = [&, laid = laid, last = last](std::size_t first, std::size_t count, const Point* terms,
                                                       double weight) {
    int at[3];
    double known = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = first + k;
      at[k] = i > laid && i <= last ? static_cast<int>(i - laid - 1) : -1;
      if (i > last) known -= terms[k].y;
    }
    m.add(count, at, terms, known, weight);
  };
  const double piece = 1.0 / s.pieces, mass = s.thickness * piece;
  for (std::size_t i = laid; i <= last; ++i) {
    const double dx = x[i + 1].x - x[i].x, dy = x[i + 1].y - x[i].y, squared = dx * dx + dy * dy;
    const Point along[2] = {{-dx / squared, -dy / squared}, {dx / squared, dy / squared}};
    dissipate(i, 2, along, 4 * s.viscosity * s.thickness * std::sqrt(squared));
  }
  for (std::size_t i = std::max<std::size_t>(laid, 1); i <= last + 1; ++i) {
    const Point a = turn(x[i - 1], x[i]), b = turn(x[i], x[i + 1]), bend[3] = {a, {-a.x - b.x, -a.y - b.y}, b};
    dissipate(i - 1, 3, bend, s.viscosity * std::pow(s.thickness, 3) / (3 * piece));
  }
  for (std::size_t i = laid + 1; i <= last; ++i) {
    const int at = 2 * static_cast<int>(i - laid - 1);
    m.add(at, mass / step, mass / step * v[i].x);
    m.add(at + 1, mass / step, mass * (v[i].y / step - s.gravity));
  }
  return m;
}

// Mean time between passages of half the height after the second one, by height over speed.
double time_of_passage(const Sheet& s, double until) {
  const double piece = 1.0 / s.pieces, step = 0.2 * piece;
  State now;
  auto& [x, v, laid, last] = now;
  for (int i = 0; i <= s.pieces; ++i) x.push_back({0.02 * std::sin(3.14159265358979 * i * piece), i * piece});
  std::vector<double> passages;
  double side = 0, h = step;
  for (double t = 0; t < until; t += h) {
    while (x.back().y < 1 + 2.5 * piece) x.push_back({0, x.back().y + piece});
    v.resize(x.size(), Point{0, -1});
    last = x.size() - 1;
    while (x[last].y > 1) --last;
    const std::vector<double> solved = equations(s, now, step).solve();
    double fastest = 1;
    for (std::size_t i = laid + 1; i <= last; ++i) {
      v[i] = {solved[2 * (i - laid - 1)], solved[2 * (i - laid - 1) + 1]};
      fastest = std::max(fastest, std::hypot(v[i].x, v[i].y));
    }
    h = step / fastest;
    for (std::size_t i = laid + 1; i < x.size(); ++i) x[i] = {x[i].x + h * v[i].x, x[i].y + h * v[i].y};
    std::size_t middle = last;
    while (middle > laid + 1 && x[middle].y > 0.5) --middle;
    if (side * x[middle].x < 0) passages.push_back(t);
    if (x[middle].x != 0) side = x[middle].x;
    for (std::size_t i = laid + 1; i <= last; ++i)
      if (x[i].y <= 0) laid = i;
    for (std::size_t i = 0; i <= laid; ++i) x[i].y = std::max(x[i].y, 0.0);
  }
  REQUIRE(passages.size() > 6);
  return (passages.back() - passages[2]) / static_cast<double>(passages.size() - 3);
}

}  // namespace

TEST_CASE("a thin viscous sheet folds as often as the study of it says", "[fluid][fold]") {
  // without weight and with hardly any inertia, whatever its thickness
  CHECK(time_of_passage({0.02, 1e6, 0, 60}, 8) == Approx(0.625).epsilon(0.02));
  CHECK(time_of_passage({0.05, 1e6, 0, 60}, 8) == Approx(0.625).epsilon(0.03));
  // as in the study
  CHECK(time_of_passage({0.05, 50, 9.81, 60}, 8) == Approx(0.659).epsilon(0.01));
  CHECK(time_of_passage({0.04, 50, 9.81, 120}, 6) == Approx(0.659).epsilon(0.01));
}
