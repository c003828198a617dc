#include "toy/wind_sock.h"

#include "feder/error.h"

namespace feder {
namespace {

constexpr Real kCalm = Real(1e-4);       // change of direction per second that counts as none
constexpr Real kSleepTime = Real(0.25);  // s

}  // namespace

const SystemDescriptor& WindSocks::descriptor() {
  static constexpr ObjectKind kinds[] = {kWindSockKind};
  static constexpr WakeCause causes[] = {kGustCause};
  static constexpr EventKind events[] = {kGust};
  static const SystemDescriptor d = {.name = kName,
                                     .units = "segments",
                                     .unit = "segment",
                                     .kinds = kinds,
                                     .causes = causes,
                                     .events = events,
                                     .make = &make_system<WindSocks>};
  return d;
}

WindSocks::WindSocks(SystemSetup& s)
    : objects_(s.objects), events_(s.events), structure_changed_(s.structure_changed), socks_(&s.store.arena(kName)),
      direction_(&s.store.arena(kName)) {}

void WindSocks::add_passes(StepPlan& plan) {
  if (socks_.empty()) return;
  plan.add<&WindSocks::advance>(after(Rank::net_integrate), "trail", kName, this);
  plan.add<&WindSocks::fall_asleep>(before(Rank::finish), "fall asleep", kName, this);
}

ObjectId WindSocks::add(const WindSockDesc& d) {
  if (d.count < 1 || d.count > 1000) throw SceneError("segments: expected a whole number from 1 to 1000");
  Sock s;
  s.object = objects_.add(kWindSockKind, static_cast<std::uint32_t>(socks_.size()), d.name, d.tags);
  s.first = static_cast<std::uint32_t>(direction_.size()), s.count = static_cast<std::uint32_t>(d.count);
  s.position = d.position, s.wind = d.wind, s.segment = d.segment, s.lag = d.lag;
  direction_.resize(s.first + s.count, vec3(0, -1, 0));
  socks_.push_back(s);
  *structure_changed_ = true;
  return s.object;
}

void WindSocks::destroy(ObjectId sock, const std::string& where) {
  const std::uint32_t i = objects_.index(sock);
  const Sock gone = socks_[i];
  const auto first = direction_.begin() + static_cast<std::ptrdiff_t>(gone.first);
  direction_.erase(first, first + static_cast<std::ptrdiff_t>(gone.count));
  socks_.erase(socks_.begin() + static_cast<std::ptrdiff_t>(i));
  for (std::uint32_t k = i; k < socks_.size(); ++k)
    socks_[k].first -= gone.count, objects_.set_index(socks_[k].object, k);
  objects_.remove(sock, where);
  *structure_changed_ = true;
}

void WindSocks::set_wind(ObjectId sock, const Vec3& wind) {
  Sock& s = socks_[objects_.index(sock)];
  s.wind = wind, s.calm = 0;
  Event e;
  e.kind = kGust, e.a = sock, e.speed = length(wind);
  events_.add_pending(e);
  if (!s.asleep) return;
  s.asleep = false;
  e = {};
  e.kind = EventKind::wake, e.cause = kGustCause, e.a = sock;
  events_.add_pending(e);
}

void WindSocks::points(ObjectId sock, std::vector<Vec3>& out) const {
  const Sock& s = socks_[objects_.index(sock)];
  out.assign(1, s.position);
  for (std::uint32_t k = 0; k < s.count; ++k) out.push_back(out.back() + s.segment * direction_[s.first + k]);
}

Vec3 WindSocks::wanted(const Sock& s) const {
  const Real speed = length(s.wind);
  return speed > 0 ? Vec3(s.wind / speed) : vec3(0, -1, 0);
}

void WindSocks::advance(StepContext& c) {
  for (Sock& s : socks_) {
    if (s.asleep) continue;
    const Real share = c.h / (s.lag + c.h);
    Vec3 ahead = wanted(s);
    Real change = 0;
    for (std::uint32_t k = s.first; k < s.first + s.count; ++k) {
      Vec3 to = direction_[k] + share * (ahead - direction_[k]);
      // right against the wind there is no side to turn to: take one
      if (dot(direction_[k], ahead) < Real(-0.999)) to += share * vec3(Real(0.6), 0, Real(0.8));
      const Vec3 now = normalized_or(to, ahead);
      change = std::max(change, length(now - direction_[k]));
      ahead = direction_[k] = now;
    }
    s.calm = change < kCalm * c.h ? s.calm + c.h : 0;
  }
}

void WindSocks::fall_asleep(StepContext&) {
  for (Sock& s : socks_) {
    if (s.asleep || s.calm < kSleepTime) continue;
    s.asleep = true;
    Event e;
    e.kind = EventKind::sleep, e.a = s.object;
    events_.add(e);
  }
}

void WindSocks::hash(Hash& h) const {
  for (const Sock& s : socks_) h.add(s.object.slot), h.add(s.wind), h.add(s.calm);
  for (const Vec3& d : direction_) h.add(d);
}

void WindSocks::save(Writer& w) const { w.list(socks_), w.list(direction_); }
void WindSocks::load(Reader& r) { r.list(socks_), r.list(direction_); }

bool WindSocks::finite() const {
  bool good = true;
  for (const Vec3& d : direction_) good = good && is_finite(d);
  return good;
}

void WindSocks::validate() const {
  std::uint32_t first = 0;
  for (std::size_t n = 0; n < socks_.size(); ++n) {
    const Sock& s = socks_[n];
    FEDER_ASSERT(objects_.alive(s.object) && objects_.kind(s.object) == kWindSockKind && objects_.index(s.object) == n);
    FEDER_ASSERT(s.first == first && s.count > 0);
    first += s.count;
  }
  FEDER_ASSERT(first == direction_.size());
  for (const Vec3& d : direction_) FEDER_ASSERT(std::abs(length(d) - 1) < Real(1e-3));
}

}  // namespace feder
