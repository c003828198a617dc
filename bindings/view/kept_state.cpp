#include "view/kept_state.h"

#include "rigid/rigid.h"
#include "springs/springs.h"

namespace feder::view {
namespace {

bool same(const Vec3& a, const Vec3& b) { return a == b; }
bool same(const Quat& a, const Quat& b) { return a.x == b.x && a.y == b.y && a.z == b.z && a.w == b.w; }
bool same(const std::vector<Vec3>& a, const std::vector<Vec3>& b) { return a == b; }

template <class T>
const T* find_nth(const std::map<std::string, std::vector<T>>& states, const std::string& name, std::size_t n) {
  const auto found = states.find(name);
  return found != states.end() && n < found->second.size() ? &found->second[n] : nullptr;
}

// Calls f(id, name, n) for the named bodies that can move: the n-th of its name.
template <class F>
void each_body(World& world, F&& f) {
  Rigid* rigid = world.find<Rigid>();
  if (!rigid) return;
  std::map<std::string, std::size_t> seen;
  world.objects().for_each(kBodyKind, [&](ObjectId id) {
    const std::string& name = world.objects().name(id);
    const BodyType type = rigid->bodies().type[rigid->index(id)];
    if (name.empty() || (type != BodyType::dynamic && type != BodyType::kinematic)) return;
    f(*rigid, id, name, seen[name]++);
  });
}

template <class F>
void each_net(World& world, F&& f) {
  Springs* springs = world.find<Springs>();
  if (!springs) return;
  std::map<std::string, std::size_t> seen;
  world.objects().for_each(kNetKind, [&](ObjectId id) {
    const std::string& name = world.objects().name(id);
    if (!name.empty()) f(*springs, id, name, seen[name]++);
  });
}

BodyState state_of(const Rigid& rigid, ObjectId id) {
  const std::uint32_t i = rigid.index(id);
  return {rigid.pose(id), rigid.bodies().velocity[i], rigid.bodies().angular_velocity[i]};
}

NetState state_of(const Springs& springs, ObjectId id) {
  NetState s;
  for (std::size_t i = 0; i < springs.point_count(id); ++i)
    s.points.push_back(springs.point(id, i)), s.velocities.push_back(springs.velocity(id, i));
  return s;
}

bool apply_body(Rigid& rigid, ObjectId id, const BodyState& was_built, const BodyState& now) {
  const BodyState built = state_of(rigid, id);
  const bool pose =
      same(built.pose.position, was_built.pose.position) && same(built.pose.rotation, was_built.pose.rotation);
  const bool motion =
      same(built.velocity, was_built.velocity) && same(built.angular_velocity, was_built.angular_velocity);
  if (pose) rigid.set_pose(id, now.pose);
  if (motion) rigid.set_velocity(id, now.velocity), rigid.set_angular_velocity(id, now.angular_velocity);
  return pose || motion;
}

bool apply_net(Springs& springs, ObjectId id, const NetState& was_built, const NetState& now) {
  const NetState built = state_of(springs, id);
  if (built.points.size() != now.points.size() || !same(built.points, was_built.points)) return false;
  for (std::size_t i = 0; i < now.points.size(); ++i) {
    springs.set_point(id, i, now.points[i]);
    springs.set_velocity(id, i, now.velocities[i]);
  }
  return true;
}

}  // namespace

NamedStates named_states(World& world) {
  NamedStates s;
  each_body(world, [&](Rigid& rigid, ObjectId id, const std::string& name, std::size_t) {
    s.bodies[name].push_back(state_of(rigid, id));
  });
  each_net(world, [&](Springs& springs, ObjectId id, const std::string& name, std::size_t) {
    s.nets[name].push_back(state_of(springs, id));
  });
  return s;
}

int apply_kept(World& world, const KeptState& kept) {
  int count = 0;
  each_body(world, [&](Rigid& rigid, ObjectId id, const std::string& name, std::size_t n) {
    const BodyState* start = find_nth(kept.start.bodies, name, n);
    const BodyState* now = find_nth(kept.now.bodies, name, n);
    if (start && now) count += apply_body(rigid, id, *start, *now);
  });
  each_net(world, [&](Springs& springs, ObjectId id, const std::string& name, std::size_t n) {
    const NetState* start = find_nth(kept.start.nets, name, n);
    const NetState* now = find_nth(kept.now.nets, name, n);
    if (start && now) count += apply_net(springs, id, *start, *now);
  });
  return count;
}

}  // namespace feder::view
