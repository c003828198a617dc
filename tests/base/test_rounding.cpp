// The bits of sums and products of small vectors, which Eigen computes in packets where a processor has them: the same
// on x86-64 (where these numbers come from) and on ARM, though ARM could fuse and has narrower packets.
#include <cstring>

#include "feder/types.h"
#include "support/catch.h"

using namespace feder;

namespace {

// Numbers whose sums and products round.
template <class S>
struct Numbers {
  std::uint64_t state = 7;
  S next() {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return S(double(static_cast<std::int64_t>(state)) / 9.2e18);
  }
};

template <class S>
std::uint64_t bits_of_all() {
  using V = Eigen::Matrix<S, 3, 1, Eigen::DontAlign>;
  using M = Eigen::Matrix<S, 3, 3, Eigen::DontAlign>;
  Numbers<S> numbers;
  std::uint64_t h = 14695981039346656037ull;
  const auto add = [&](const auto& x) {
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const double d = double(x.data()[i]);
      std::uint64_t b;
      std::memcpy(&b, &d, sizeof b);
      h = (h ^ b) * 1099511628211ull;
    }
  };
  for (int k = 0; k < 500; ++k) {
    V a, b;
    M m, n;
    for (int i = 0; i < 3; ++i) {
      a[i] = numbers.next(), b[i] = numbers.next();
      for (int j = 0; j < 3; ++j) m(i, j) = numbers.next(), n(i, j) = numbers.next();
    }
    add(V(a.dot(b), a.squaredNorm(), (a - b).norm()));
    add(V(a.sum(), m.trace(), m.squaredNorm()));
    add(V(m * a)), add(V(m.transpose() * a)), add(V(b + m * (a + b))), add(V(m.transpose() * (n * a)));
    add(M(m * n)), add(M(m * n.transpose())), add(M(m * n * m.transpose())), add(M(a * b.transpose()));
    add(M(m * a.asDiagonal() * m.transpose())), add(M(m + a[0] * n));
    V c = b;
    c.noalias() -= m * a;
    add(c);
    M d = m;
    d.noalias() += m * n;
    add(d);
  }
  return h;
}

}  // namespace

TEST_CASE("sums and products of small vectors have the same bits on every processor", "[base]") {
  CHECK(bits_of_all<float>() == 0x2c130ef52d363465u);
  CHECK(bits_of_all<double>() == 0xd4f2d5575ec38834u);
}
