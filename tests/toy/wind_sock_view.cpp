// Socks as lines from mast to tip.
#include "toy/parts.h"
#include "toy/wind_sock.h"

namespace feder::view {
namespace {

class SockSource final : public FrameSource {
 public:
  void collect(Collecting& c) override {
    const WindSocks* socks = c.world.find<WindSocks>();
    if (!socks) return;
    c.world.objects().for_each(kWindSockKind, [&](ObjectId id) {
      socks->points(id, points_);
      for (std::size_t k = 1; k < points_.size(); ++k)
        add_line(c.frame.lines, points_[k - 1], points_[k], rgb(0xd9622b), 4);
    });
  }

 private:
  std::vector<Vec3> points_;
};

}  // namespace

Row view_wind_socks() {
  return {WindSocks::kName, [] { return std::unique_ptr<FrameSource>(new SockSource); }};
}

}  // namespace feder::view
