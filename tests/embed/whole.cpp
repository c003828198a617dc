// The whole runtime by its public headers alone: bodies, a joint, a net, a cloth, a rope, a soft body and a fluid in
// one world, with queries, events, forces, snapshots and a recording; a study; and the YAML reader handed to a script
// host.
#include <feder/cloth.h>
#include <feder/fluid.h>
#include <feder/lua.h>
#include <feder/net.h>
#include <feder/query.h>
#include <feder/record.h>
#include <feder/rigid.h>
#include <feder/rope.h>
#include <feder/soft.h>
#include <feder/study.h>
#include <feder/world.h>
#include <feder/yaml.h>

#include <cstdio>
#include <mutex>
#include <thread>
#include <vector>

namespace {

using namespace feder;

void expect(bool holds, const char* what) {
  if (!holds) throw std::runtime_error(what);
}

void make_things(World& world) {
  BodyDesc floor;
  floor.name = "floor", floor.type = BodyType::fixed, floor.shape = make_plane(Vec3(0, 1, 0), 0);
  world.need<Rigid>().add_body(floor);
  BodyDesc ball;
  ball.name = "ball", ball.shape = make_sphere(Real(0.2)), ball.position = Vec3(0, 1, 0);
  const ObjectId hung = world.need<Rigid>().add_body(ball);
  JointDesc joint;
  joint.type = "ball", joint.a = hung, joint.anchor_a = Vec3(0, 2, 0);
  world.need<Rigid>().add_joint(joint);

  NetDesc rope;
  rope.name = "rope";
  rope.points = {Vec3(3, 3, 0), Vec3(3, 2, 0)}, rope.masses = {1, 1}, rope.springs.push_back({.i = 0, .j = 1});
  world.need<Springs>().pin(world.need<Springs>().add_net(rope), 0);

  ClothDesc sheet;
  sheet.name = "sheet", sheet.nx = sheet.ny = 5, sheet.pose.position = Vec3(-3, 1, 0);
  world.need<Cloth>().add_cloth(sheet);

  RopeDesc line;
  line.name = "line", line.points = {Vec3(-6, 3, 0), Vec3(-6, 2, 0), Vec3(-6, 1, 0)}, line.pins = {0};
  world.need<Rope>().add_rope(line);

  SoftDesc jelly;
  jelly.name = "jelly", jelly.shape = make_box(Real(0.3), Real(0.3), Real(0.3)), jelly.resolution = 3;
  jelly.pose.position = Vec3(-9, 1, 0);
  world.need<Soft>().add_soft(jelly);

  FluidDesc water;
  water.name = "water";
  const ObjectId pool = world.need<Fluid>().add_fluid(water);
  world.need<Fluid>().fill(pool, *make_box(Real(0.4), Real(0.4), Real(0.4)), {Vec3(0, Real(0.2), 5), {}}, Vec3::Zero());

  Params wind;
  wind.set("velocity", std::vector<double>{1, 0, 0});
  world.add_force("wind", wind, {.all = true}, "breeze", 0);
}

void run_world() {
  std::string bytes;
  World world(WorldDesc{}, catalog());
  Recorder recorder([&bytes](std::string_view more) { bytes += more; }, {});
  recorder.add(world);
  make_things(world);
  const std::string image = world.snapshot();
  for (int i = 0; i < 30; ++i) world.step();
  const std::uint64_t hash = world.hash();
  world.restore(image);
  for (int i = 0; i < 30; ++i) world.step();
  expect(world.hash() == hash, "a restored world goes another way");
  expect(world.is_finite(), "a number is not finite");

  const ObjectId ball = world.objects().find("ball");
  expect(length(world.find<Rigid>()->velocity(ball)) < 1, "the ball hangs");
  expect(world.find<Rigid>()->type(ball) == BodyType::dynamic && !world.find<Rigid>()->asleep(ball),
         "the ball is awake");
  RaycastHit hit;
  expect(world.query<Collide>()->raycast(Vec3(0, 5, 0), Vec3(0, -10, 0), {}, hit), "the ray meets nothing");
  expect(world.objects().describe(hit.object) == "body \"ball\"", "the ray meets the ball first");
  Real top = 0;
  expect(world.query<Fluid>()->height_at(world.objects().find("water"), 0, 5, top) && top > 0,
         "the water has a surface");
  std::vector<Vec3> points;
  world.find<Cloth>()->positions(world.objects().find("sheet"), points);
  expect(points.size() == 25, "a sheet of 5 x 5");
  for (const PlanNode& node : world.plan().nodes()) expect(node.counter.calls > 0 || node.is_loop, node.name);
  std::printf("world: %zu systems\n", world.report().size());
  recorder.finish("finished");
  Replay replay(Recording(bytes), 0, catalog());
  while (replay.step()) {
  }
  expect(replay.same() && replay.world().hash() == world.hash(), "a replay goes another way");
}

// A world on threads of the host goes the same way; a helper may outlive it.
void run_on_host_threads() {
  const auto hash_after = [](const Executor& executor) {
    World world(WorldDesc{}, catalog(), executor);
    make_things(world);
    for (int i = 0; i < 30; ++i) world.step();
    return world.hash();
  };
  std::vector<std::thread> tasks;
  std::mutex lock;  // helping threads ask, too
  Executor executor;
  executor.threads = 3;
  executor.call = [&](const Helper& helper, int helpers) {
    const std::lock_guard<std::mutex> guard(lock);
    for (; helpers > 0 && tasks.size() < 50; --helpers) tasks.emplace_back([helper] { helper.help(); });
  };
  expect(hash_after(executor) == hash_after({}), "threads of the host change the way of a world");
  for (std::thread& t : tasks) t.join();
}

void run_study() {
  const std::unique_ptr<StudyProblem> problem = make_study_problem("oscillator", {});
  SweepOptions options;
  options.methods = {"rk4"}, options.timing.enabled = false;
  options.ladders = {parse_ladder("steps:100,200,400")};
  const StudyResult result = run_sweep(*problem, options);
  expect(result.points.size() == 3 && result.points[2].err_end < result.points[0].err_end, "finer is not closer");
  std::printf("study: %zu points\n", result.points.size());
}

}  // namespace

int main() try {
  run_world();
  run_on_host_threads();
  run_study();
  lua::HostOptions options;
  options.load_yaml = yaml::push;
  yaml::check("list.yaml", "[1, 2, 3]");
  std::printf("whole: %s\n", kRealName);
  return 0;
} catch (const std::exception& e) {
  return std::fprintf(stderr, "%s\n", e.what()), 1;
}
