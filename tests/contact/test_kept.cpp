// A search that is kept over steps: folded cloth at rest is seldom searched, does not cross itself, and goes on from a
// snapshot, with other threads and after an edit as it must; a damaged snapshot of it does no harm.
#include <cstring>
#include <limits>

#include "base/rng.h"
#include "cloth/crossings.h"
#include "cloth/sheets.h"

using namespace feder;
using namespace feder::test;

namespace {

// A sheet whose far half hangs over the near one, which is held.
struct Fold {
  explicit Fold(int threads) : w(desc(threads), kClothOnly), cloth(w.need<Cloth>()) {
    constexpr std::uint32_t n = 24;
    ClothDesc d = sheet(n, n, 1, 1);
    d.thickness = Real(0.01), d.bend = Real(1e-5), d.damping = Real(0.02);
    for (std::uint32_t j = 0; j < n; ++j)
      for (std::uint32_t i = 0; i < n / 2; ++i) d.pins.push_back(n * j + i);
    id = cloth.add_cloth(d);
    for (std::size_t i = 0; i < n * n; ++i) {
      const Vec3 x = cloth.point(id, i);
      if (x[0] > 0) cloth.set_point(id, i, Vec3(-x[0], Real(0.06), x[2]));
    }
  }
  static WorldDesc desc(int threads) {
    WorldDesc wd;
    wd.sleeping = false, wd.threads = threads;
    return wd;
  }
  // Searches of so many steps.
  double run(int steps) {
    double sum = 0;
    for (int k = 0; k < steps; ++k) {
      w.step();
      for (const Residual& r : w.residuals())
        if (r.name == "contact.searches") sum += r.value;
    }
    return sum;
  }
  std::size_t crossings() const {
    Soup s;
    s.add(cloth, id);
    return count_crossings(s);
  }
  World w;
  Cloth& cloth;
  ObjectId id;
};

}  // namespace

TEST_CASE("folded cloth at rest is searched less than once in a step", "[contact][cloth]") {
  Fold f(1);
  CHECK(f.run(20) > 0);
  std::size_t crossings = 0;
  for (int k = 0; k < 22; ++k) f.run(10), crossings += f.crossings();
  const double searches = f.run(60);
  CAPTURE(searches);
  CHECK(searches < 60);
  CHECK(crossings + f.crossings() == 0);
  // what was at rest is lifted: the kept candidates do not cover that
  const Vec3 up = f.cloth.point(f.id, 24 * 12 + 20) + Vec3(0, Real(0.03), 0);
  f.cloth.set_point(f.id, 24 * 12 + 20, up);
  CHECK(f.run(1) >= 1);
  f.run(30);
  CHECK(f.crossings() == 0);
}

TEST_CASE("a kept search goes on from a snapshot and with more threads as it was", "[contact][cloth][snapshot]") {
  Fold f(1);
  f.run(220);
  const std::string image = f.w.snapshot();
  const double searches = f.run(40);
  const std::uint64_t hash = f.w.hash();
  f.w.restore(image);
  CHECK(f.run(40) == searches);
  CHECK(f.w.hash() == hash);
  for (const int threads : {2, 4}) {
    Fold other(threads);
    other.run(220);
    CHECK(other.run(40) == searches);
    CHECK(other.w.hash() == hash);
  }
}

namespace {

// Where the image of contact has what is kept of its one search: how many there are, what it is of (40 bytes), its rows
// (4), how many points (8), and four numbers of each.
std::size_t kept_at(const std::string& image) {
  const std::string name("\7\0\0\0\0\0\0\0contact", 15);
  return image.find(name) + name.size() + 1;
}

constexpr std::size_t kOf = 8, kRows = kOf + 40, kCount = kRows + 4, kRest = kCount + 8;

template <class T>
std::string altered(std::string image, std::size_t at, T value) {
  std::memcpy(&image[kept_at(image) + at], &value, sizeof value);
  return image;
}

}  // namespace

TEST_CASE("a damaged kept search is refused or made anew", "[contact][cloth][snapshot]") {
  Fold f(1);
  f.run(220);
  const std::string image = f.w.snapshot();
  const auto number = [&](std::size_t at) {
    std::uint64_t n = 0;
    std::memcpy(&n, &image[kept_at(image) + at], sizeof n);
    return n;
  };
  REQUIRE(number(0) == 1);  // a search is kept
  REQUIRE(number(kCount) == 24 * 24);
  CHECK(f.run(1) == 0);
  f.run(19);
  const std::uint64_t hash = f.w.hash();
  f.w.restore(image);
  // what does not read as an image is an error, and the world stays as it is
  const std::uint64_t start = f.w.hash();
  const auto refused = [&](const std::string& bad) {
    CHECK_THROWS_AS(f.w.restore(bad), SceneError);
    CHECK(f.w.hash() == start);
  };
  for (const std::size_t at : {std::size_t(0), std::size_t(5), kOf + 3, kRows + 1, kCount + 7, kRest + 100})
    refused(image.substr(0, kept_at(image) + at));
  for (const std::uint64_t count : {std::uint64_t(0), std::uint64_t(2), std::uint64_t(1) << 62, ~std::uint64_t(0)})
    refused(altered(image, 0, count));
  for (const std::uint64_t count : {std::uint64_t(0), std::uint64_t(575), std::uint64_t(577), ~std::uint64_t(0)})
    refused(altered(image, kCount, count));
  // what reads as one, but is of something else or impossible, is searched anew: nothing depends on it
  std::vector<std::string> images;
  for (std::size_t word = 0; word < 8; ++word) images.push_back(altered(image, kOf + 4 * word, 0xffffff00u));
  images.push_back(altered(image, kOf + 32, std::numeric_limits<double>::quiet_NaN()));
  for (const Real x : {std::numeric_limits<Real>::quiet_NaN(), kInfinity, -kInfinity, Real(1e30), Real(-1)})
    for (std::size_t k = 0; k < 4; ++k) images.push_back(altered(image, kRest + (4 * 300 + k) * sizeof(Real), x));
  std::string zeros = image, wide = image;
  for (std::size_t i = 0; i < 24 * 24; ++i) {
    for (std::size_t k = 0; k < 3; ++k) zeros = altered(zeros, kRest + (4 * i + k) * sizeof(Real), Real(0));
    wide = altered(wide, kRest + (4 * i + 3) * sizeof(Real), Real(1));
  }
  images.push_back(zeros), images.push_back(wide);
  for (std::size_t k = 0; k < images.size(); ++k) {
    CAPTURE(k);
    f.w.restore(images[k]);
    CHECK(f.run(1) > 0);
    f.run(19);
    CHECK(f.w.hash() == hash);
  }
  for (const std::uint32_t rows : {0u, ~0u}) {  // whether it is worth keeping
    f.w.restore(altered(image, kRows, rows));
    f.run(20);
    CHECK(f.w.hash() == hash);
  }
  // any bytes at all
  Rng rng(5);
  int read = 0;
  for (int k = 0; k < 300; ++k) {
    std::string bad = image;
    const std::size_t first = kept_at(image), size = kRest + 24 * 24 * 4 * sizeof(Real);
    for (int n = 1 + k % 4; n > 0; --n) {
      const std::size_t at = k % 2 ? rng.next() % kRest : rng.next() % size;
      bad[first + at] = static_cast<char>(rng.next() % 256);
    }
    try {
      f.w.restore(bad), ++read;
    } catch (const SceneError&) {
      continue;
    }
    f.run(2);
  }
  CHECK(read > 100);
  CHECK(f.w.is_finite());
}
