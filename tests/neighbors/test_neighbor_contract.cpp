// Every registered neighbour search against brute force. A new variant is enrolled by its line alone.
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "base/jobs.h"
#include "base/rng.h"
#include "bounds/cell_grid.h"
#include "feder/params.h"
#include "neighbors/neighbor_search.h"
#include "support/catch.h"

using namespace feder;

namespace {

enum class Cloud { random, lattice, flat, strays, crowd, in_order, infinite };

std::vector<Real> make_points(Cloud cloud, int count) {
  Rng rng(static_cast<std::uint64_t>(count) + 3);
  std::vector<Real> p;
  for (int i = 0; i < count; ++i) {
    Real x[3];
    for (Real& c : x) c = rng.uniform(-1, 1);
    if (cloud == Cloud::lattice) {  // distances equal the radius: common, and no neighbours
      x[0] = Real(0.25) * Real(i % 8), x[1] = Real(0.25) * Real(i / 8 % 8), x[2] = Real(0.25) * Real(i / 64);
    }
    if (cloud == Cloud::flat) x[2] = 0;
    if (cloud == Cloud::strays && i % 10 == 0)
      for (Real& c : x) c *= i % 20 == 0 ? Real(1e6) : Real(300);
    if (cloud == Cloud::crowd && i % 3 != 0)
      for (Real& c : x) c *= Real(0.01);
    if (cloud == Cloud::infinite && i % 10 == 0)
      for (Real& c : x) c = i % 20 == 0 ? (c > 0 ? kInfinity : -kInfinity) : std::numeric_limits<Real>::quiet_NaN();
    p.insert(p.end(), {x[0], x[1], x[2], rng.uniform(-9, 9)});
  }
  if (cloud == Cloud::in_order && count > 0) {  // as the grid sorts them: nothing has to be moved
    Arena arena("test");
    CellGrid grid(arena);
    Array<std::uint32_t> order{&arena};
    JobPool jobs(1);
    grid.sort(p, Real(0.25), jobs, order);
    const std::vector<Real> old = p;
    for (std::size_t k = 0; k < order.size(); ++k) std::copy_n(&old[4 * order[k]], 4, &p[4 * k]);
  }
  return p;
}

std::vector<std::vector<std::uint32_t>> brute_force(const std::vector<Real>& p, Real radius) {
  const std::uint32_t count = static_cast<std::uint32_t>(p.size() / 4);
  std::vector<std::vector<std::uint32_t>> rows(count);
  for (std::uint32_t i = 0; i < count; ++i)
    for (std::uint32_t j = 0; j < count; ++j) {
      const Real dx = p[4 * j] - p[4 * i], dy = p[4 * j + 1] - p[4 * i + 1], dz = p[4 * j + 2] - p[4 * i + 2];
      if (i != j && dx * dx + dy * dy + dz * dz < radius * radius) rows[i].push_back(j);
    }
  return rows;
}

std::vector<std::vector<std::uint32_t>> rows_of(const NeighborLists& lists, std::uint32_t count) {
  std::vector<std::vector<std::uint32_t>> rows(count);
  for (std::uint32_t i = 0; i < count; ++i) rows[i].assign(lists.row(i).begin(), lists.row(i).end());
  return rows;
}

}  // namespace

TEST_CASE("neighbour searches find what brute force finds", "[neighbors][contract][threads]") {
  const int row = GENERATE(range(0, static_cast<int>(neighbor_searches().size())));
  const auto cloud =
      GENERATE(Cloud::random, Cloud::lattice, Cloud::flat, Cloud::strays, Cloud::in_order, Cloud::infinite);
  const auto& variant = neighbor_searches()[static_cast<std::size_t>(row)];
  CAPTURE(variant.name, static_cast<int>(cloud));
  Arena arena("test");
  JobPool one(1), three(3);
  const Params none;
  auto search = variant.make(arena, none);
  NeighborLists lists(arena);
  for (const int count : {300, 0, 1, 2, 700}) {  // fewer after more: nothing of the last call may shine through
    const std::vector<Real> points = make_points(cloud, count);
    const Real radius = Real(0.25);
    search->find(points, radius, one, lists);
    const auto found = rows_of(lists, static_cast<std::uint32_t>(count));
    REQUIRE(found == brute_force(points, radius));
    for (int i = 0; i < count; ++i) {
      const std::size_t at = static_cast<std::size_t>(i);
      REQUIRE(lists.rounded[at] % 8 == 0);
      for (std::uint32_t k = lists.count[at]; k < lists.rounded[at]; ++k)
        REQUIRE(lists.index[at * lists.stride + k] == static_cast<std::uint32_t>(count));
    }
    search->find(points, radius, three, lists);
    REQUIRE(rows_of(lists, static_cast<std::uint32_t>(count)) == found);
  }
}

TEST_CASE("a crowd is thinned from both sides alike", "[neighbors][contract][threads]") {
  const int row = GENERATE(range(0, static_cast<int>(neighbor_searches().size())));
  const auto& variant = neighbor_searches()[static_cast<std::size_t>(row)];
  CAPTURE(variant.name);
  Arena arena("test");
  JobPool jobs(2);
  auto search = variant.make(arena, Params());
  NeighborLists lists(arena);
  const int count = 1500;
  const std::vector<Real> points = make_points(Cloud::crowd, count);
  search->find(points, Real(0.25), jobs, lists);
  const auto all = brute_force(points, Real(0.25));
  const auto found = rows_of(lists, count);
  std::size_t crowded = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    crowded += all[i].size() > NeighborLists::kMaxNeighbors;
    REQUIRE(found[i].size() <= NeighborLists::kMaxNeighbors);
    REQUIRE(std::is_sorted(found[i].begin(), found[i].end()));
    if (all[i].size() > NeighborLists::kMaxNeighbors) REQUIRE(found[i].size() > NeighborLists::kMaxNeighbors / 2);
    for (const std::uint32_t j : found[i]) {
      REQUIRE(std::binary_search(all[i].begin(), all[i].end(), j));
      REQUIRE(std::binary_search(found[j].begin(), found[j].end(), i));
    }
  }
  REQUIRE(crowded > 900);
}

TEST_CASE("a search allocates nothing once it has seen as many points", "[neighbors][contract]") {
  const int row = GENERATE(range(0, static_cast<int>(neighbor_searches().size())));
  const auto& variant = neighbor_searches()[static_cast<std::size_t>(row)];
  CAPTURE(variant.name);
  Arena arena("test");
  JobPool jobs(1);
  auto search = variant.make(arena, Params());
  NeighborLists lists(arena);
  const std::vector<Real> points = make_points(Cloud::random, 900), fewer = make_points(Cloud::random, 800);
  search->find(points, Real(0.25), jobs, lists);
  search->find(points, Real(0.25), jobs, lists);
  const auto before = arena.allocations();
  search->find(fewer, Real(0.25), jobs, lists);
  search->find(points, Real(0.25), jobs, lists);
  CHECK(arena.allocations() == before);
}
