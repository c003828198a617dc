// A system from outside the house, as an example and a test of its doors: wind socks, chains of points that trail from
// a mast. Everything that feder knows of it is in this folder: the system (wind_sock.cpp), its part of Lua
// (wind_sock_lua.cpp), what is drawn (wind_sock_view.cpp). tests/toy/test_toy.cpp.
//
// The direction of segment i follows that of the segment before it, the first one the wind, with a time constant:
//   d_i' = (d_(i-1) - d_i) / lag, kept at length 1; backward Euler.
// Kept between steps: directions. Weak spot: no mass, so nobody feels a sock.
#pragma once
#include "feder/system.h"
#include "feder/types.h"

namespace feder {

inline constexpr ObjectKind kWindSockKind{"wind_sock", "wind_socks"};
inline constexpr WakeCause kGustCause{"gust"};
inline constexpr EventKind kGust{"gust", EventKind::kSpeed};  // the wind of a sock changes; its new speed

struct WindSockDesc {
  std::string name;
  TagMask tags = 0;
  Vec3 position = Vec3::Zero();  // of the mast's top, m
  Vec3 wind = vec3(5, 0, 0);     // m/s
  Real segment = Real(0.2);      // m
  Real lag = Real(0.3);          // s
  int count = 5;                 // segments
};

class WindSocks final : public System {
 public:
  static constexpr const char* kName = "wind_socks";
  static const SystemDescriptor& descriptor();
  explicit WindSocks(SystemSetup& setup);

  void add_passes(StepPlan& plan) override;
  std::size_t count() const override { return direction_.size(); }
  void hash(Hash& h) const override;
  void save(Writer& w) const override;
  void load(Reader& r) override;
  bool finite() const override;
  void validate() const override;

  ObjectId add(const WindSockDesc& desc);
  void destroy(ObjectId sock, const std::string& where);
  void set_wind(ObjectId sock, const Vec3& wind);  // wakes it
  bool asleep(ObjectId sock) const { return socks_[objects_.index(sock)].asleep; }
  // The points of a sock from the mast to the tip, m.
  void points(ObjectId sock, std::vector<Vec3>& out) const;

 private:
  struct Sock {
    ObjectId object;
    std::uint32_t first = 0, count = 0;  // of its directions
    Vec3 position, wind;
    Real segment = 0, lag = 0, calm = 0;  // calm: s since it moved
    bool asleep = false;
  };
  void advance(StepContext& c);
  void fall_asleep(StepContext& c);
  Vec3 wanted(const Sock& s) const;  // direction of the wind, or down

  Objects& objects_;
  Events& events_;
  bool* structure_changed_;
  Array<Sock> socks_;
  Array<Vec3> direction_;
};

}  // namespace feder
