// Recordings: whatever is altered, cut off or foreign is refused by a line; forces of hosts and snapshots are played
// again; worlds are recorded from their beginning.
#include "feder/cloth.h"
#include "feder/fluid.h"
#include "feder/net.h"
#include "feder/record.h"
#include "feder/rigid.h"
#include "record/format.h"
#include "state/command_log.h"
#include "support/catch.h"

using namespace feder;

namespace {

class Recorded {
 public:
  explicit Recorded(const WorldDesc& desc = {}) : world(desc, catalog()), recorder(sink(), {{"scene", "a test"}}) {
    recorder.add(world);
  }
  Recorder::Sink sink() {
    return [this](std::string_view more) { bytes += more; };
  }
  ObjectId add_ball(const Vec3& at) {
    BodyDesc body;
    body.shape = make_sphere(Real(0.5));
    body.position = at;
    return world.need<Rigid>().add_body(body);
  }
  void step(int n) {
    for (int i = 0; i < n; ++i) world.step();
  }
  const std::string& finish() { return recorder.finish("finished"), bytes; }

  std::string bytes;
  World world;
  Recorder recorder;
};

std::string small_recording() {
  Recorded r;
  r.add_ball(Vec3(0, 1, 0));
  r.step(3);
  return r.finish();
}

// Why a text is no recording of this build; "" when it is one, and replays.
std::string refusal(const std::string& bytes) {
  try {
    const Recording recording(bytes);
    for (std::size_t k = 0; k < recording.world_count(); ++k) {
      Replay replay(recording, k, catalog());
      while (replay.step()) {
      }
    }
  } catch (const SceneError& e) {
    return e.what();
  }
  return "";
}

// Blocks of another content, with checksums that are right.
std::string with_block(const std::string& bytes, std::size_t number, char kind, const std::string& content) {
  std::string out = recording::first_line();
  recording::Blocks blocks(bytes);
  for (std::size_t k = 0; !blocks.at_end(); ++k) {
    const recording::Block b = blocks.next();
    out += k == number ? recording::block(kind, content) : recording::block(b.kind, b.content);
  }
  return out;
}

std::string replay_hashes(const std::string& bytes, int threads = 0) {
  const Recording recording(bytes);
  std::string text;
  for (std::size_t k = 0; k < recording.world_count(); ++k) {
    Replay replay(recording, k, catalog(), threads);
    while (replay.step()) text += std::to_string(replay.world().hash()) + " ";
    CHECK(replay.same());
  }
  return text;
}

// A spring to the origin whose answers are not those of a formula: a replay cannot know them.
class HostForce final : public Force {
 public:
  void add(const MassPoint* points, std::size_t count, double, Vec3* out) const override {
    for (std::size_t i = 0; i < count; ++i) out[i] += Real(-5 - 0.01 * calls++) * points[i].position;
  }
  bool derivative(const MassPoint*, std::size_t count, double, bool by_velocity, Mat3* out) const override {
    for (std::size_t i = 0; !by_velocity && i < count; ++i) out[i] += Real(-5 - 0.001 * calls) * Mat3::Identity();
    return true;
  }
  mutable int calls = 0;
};

}  // namespace

TEST_CASE("each byte of a recording that is altered is noticed", "[record]") {
  const std::string good = small_recording();
  REQUIRE(refusal(good) == "");
  for (std::size_t k = 0; k < good.size(); ++k)
    for (const int flip : {1, 0x80}) {
      std::string bad = good;
      bad[k] = static_cast<char>(bad[k] ^ flip);
      const std::string why = refusal(bad);
      CAPTURE(k, why);
      CHECK(why.find("recording") != std::string::npos);
    }
}

TEST_CASE("a recording that is cut off anywhere is refused", "[record]") {
  const std::string good = small_recording();
  for (std::size_t k = 0; k < good.size(); ++k) {
    const std::string why = refusal(good.substr(0, k));
    CAPTURE(k, why);
    CHECK((why.find("truncated") != std::string::npos || why.find("recording's first line") != std::string::npos ||
           why.find("not a recording") != std::string::npos));
  }
  CHECK(refusal(good + "x").find("truncated") != std::string::npos);
}

TEST_CASE("each class of bytes is refused by its name", "[record]") {
  const std::string good = small_recording();
  const std::size_t line = recording::first_line().size();
  const auto altered = [&](std::size_t at) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x20);
    return refusal(bad);
  };
  CHECK(altered(0) == "not a recording of feder: it does not begin with 'feder recording'");
  CHECK(altered(line - 2).find("this build reads format 4") != std::string::npos);                    // the format
  CHECK(altered(line) == "block 1 at byte 18 of the recording is damaged: its checksum is another");  // kind
  CHECK(altered(line + 8).find("bytes, but only") != std::string::npos);                              // length
  CHECK(altered(line + 12).find("block 1 at byte 18 of the recording is damaged") == 0);              // content
  CHECK(altered(good.size() - 1).find("is damaged: its checksum is another") != std::string::npos);   // checksum
  CHECK(refusal("") == "not a recording of feder: it does not begin with 'feder recording'");
  CHECK(refusal("return { title = \"a scene\" }").find("not a recording") == 0);
  CHECK(refusal("feder recording 5\n") == "the recording is of format '5', this build reads format 4");
  // checksums that are right
  CHECK(refusal(with_block(good, 1, 'X', "")).find("of an unknown kind") != std::string::npos);
  CHECK(refusal(with_block(good, 1, recording::kItems, std::string(2, '\0'))).find("a world that is not there") !=
        std::string::npos);
  CHECK(refusal(with_block(good, 0, recording::kWorld, "")).find("should be its header") != std::string::npos);
  CHECK(refusal(with_block(good, 1, recording::kHeader, "")).find("second header") != std::string::npos);
  CommandBytes other;
  other.text(kRealName == std::string("float") ? "double" : "float"), other.whole(0);
  CHECK(refusal(with_block(good, 0, recording::kHeader, other.bytes())).find("of the scalar type") !=
        std::string::npos);
  CommandBytes end;
  end.text("finished"), end.whole(9);
  CHECK(refusal(with_block(good, 3, recording::kEnd, end.bytes())) == "the recording lacks blocks before its end");
  CHECK(refusal(recording::first_line()).find("truncated") != std::string::npos);
}

TEST_CASE("commands of another build are refused by name", "[record]") {
  const std::string good = small_recording();
  const auto with_items = [&](const auto& write) {
    CommandBytes items;
    items.whole(0), items.whole(1);
    write(items);
    return refusal(with_block(good, 2, recording::kItems, items.bytes()));
  };
  const auto name = [](CommandBytes& out, const char* command, const char* signature) {
    out.whole(1), out.text(command), out.text(signature);
  };
  CHECK(with_items([&](CommandBytes& o) { name(o, "rigid.fly", "o"); }) ==
        "recording: this build has no command 'rigid.fly'");
  CHECK(with_items([&](CommandBytes& o) { name(o, "rigid.set_velocity", "ot"); }) ==
        "recording: its command 'rigid.set_velocity' has the arguments ot, that of this build ov");
  CHECK(with_items([&](CommandBytes& o) { o.whole(2), o.whole(3), o.text(""); }) ==
        "recording: command number 3 is unknown");
  CHECK(with_items([&](CommandBytes& o) { name(o, "rigid.sleep", "o"), o.whole(2), o.whole(0), o.text("\1\1"); }) ==
        "recording: a command for rigid comes before the system");
  CHECK(with_items([&](CommandBytes& o) { name(o, "world.restore", "u"), o.whole(2), o.whole(0), o.text("\5"); }) ==
        "recording: it restores a snapshot that it has not taken");
  CHECK(with_items([&](CommandBytes& o) {
          name(o, "world.set_gravity", "v"), o.whole(2), o.whole(0), o.text("123");
        }) == "recording: a command ends too early");
  CHECK(with_items([&](CommandBytes& o) { o.whole(99); }) == "recording: an item of an unknown kind");
}

// One of everything, and an edit of each.
std::string large_recording() {
  Recorded r;
  Rigid& rigid = r.world.need<Rigid>();
  const ObjectId ball = r.add_ball(Vec3(0, 1, 0)), other = r.add_ball(Vec3(3, 1, 0));
  JointDesc joint;
  joint.type = "hinge", joint.a = ball, joint.anchor_a = Vec3(0, 2, 0);
  rigid.set_motor(rigid.add_joint(joint), 1, 5);
  NetDesc net;
  net.points = {Vec3(6, 3, 0), Vec3(7, 3, 0)}, net.masses = {1, 1}, net.springs = {{0, 1}};
  Springs& springs = r.world.need<Springs>();
  const ObjectId rope = springs.add_net(net);
  springs.attach(rope, 0, ball, Vec3(0, 0, 0));
  ClothDesc sheet;
  sheet.nx = sheet.ny = 4, sheet.pose.position = Vec3(-4, 2, 0);
  Cloth& cloth = r.world.need<Cloth>();
  cloth.pin(cloth.add_cloth(sheet), 1);
  FluidDesc water;
  Fluid& fluid = r.world.need<Fluid>();
  const ObjectId pool = fluid.add_fluid(water);
  fluid.fill(pool, *make_box(Real(0.2), Real(0.2), Real(0.2)), Pose{}, Vec3::Zero());
  fluid.set_running(fluid.add_emitter(pool, {}), false);
  fluid.add_drain(pool, "drain", 0, make_sphere(1), Pose{Vec3(0, -9, 0), {}});
  Params wind;
  wind.set("velocity", std::vector<double>{1, 0, 0});
  ForceEntry all;
  all.all = true;
  r.world.add_force("wind", wind, all, "breeze", r.world.objects().tag_bit("air"));
  r.step(2);
  rigid.set_pose(ball, {Vec3(0, 1, 1), {}}), rigid.apply_impulse(other, Vec3(1, 0, 0), nullptr);
  springs.pin(rope, 1), springs.set_point(rope, 1, Vec3(7, 2, 0));
  rigid.destroy_body(other, "");
  r.step(1);
  return r.finish();
}

TEST_CASE("random contents with right checksums end in a line, or are another run", "[record]") {
  const std::string good = large_recording();
  REQUIRE(refusal(good) == "");
  recording::Blocks blocks(good);
  std::string content;
  for (int k = 0; k < 3; ++k) content = blocks.next().content;
  std::uint64_t random = 7;
  int refused = 0;
  for (int k = 0; k < 200; ++k) {
    std::string bad = content;
    random = random * 6364136223846793005ull + 1442695040888963407ull;
    bad[(random >> 33) % bad.size()] = static_cast<char>(random >> 24);
    refused += refusal(with_block(good, 2, recording::kItems, bad)) != "";
  }
  CHECK(refused > 40);
}

TEST_CASE("a host's forces are played again", "[record]") {
  for (const char* integrator : {"rk4", "implicit_euler", "symplectic_euler"}) {
    CAPTURE(integrator);
    Recorded r;
    NetDesc net;
    net.points = {Vec3(1, 0, 0), Vec3(2, 1, 0)};
    net.masses = {1, 1};
    net.springs = {{0, 1}};
    net.integrator = integrator;
    r.world.need<Springs>().add_net(net);
    r.add_ball(Vec3(0, 3, 0));
    ForceEntry entry;
    entry.force = std::make_shared<HostForce>();
    entry.all = true;
    const ObjectId force = r.world.add_force(std::move(entry), "host", 0);
    r.step(20);
    r.world.set_force_enabled(force, false);
    r.step(5);
    r.world.set_force_enabled(force, true);
    r.step(5);
    replay_hashes(r.finish());
  }
}

TEST_CASE("snapshots that are restored are taken again", "[record]") {
  Recorded r;
  const ObjectId ball = r.add_ball(Vec3(0, 3, 0));
  r.step(5);
  const std::string image = r.world.snapshot(), unused = r.world.snapshot();
  r.step(5);
  const ObjectId late = r.add_ball(Vec3(4, 3, 0));
  r.step(2);
  r.world.restore(image);
  CHECK(!r.world.objects().alive(late));
  r.world.need<Rigid>().set_velocity(ball, Vec3(0, 0, 3));
  r.step(5);
  r.world.restore(image);
  r.step(5);
  CHECK_THROWS_AS(r.world.restore("no image"), SceneError);
  r.step(1);
  replay_hashes(r.finish());
}

TEST_CASE("several worlds, one that ends early, in one recording; threads change nothing", "[record]") {
  std::string bytes;
  Recorder recorder([&](std::string_view more) { bytes += more; }, {});
  auto first = std::make_unique<World>(WorldDesc{}, catalog()),
       second = std::make_unique<World>(WorldDesc{}, catalog());
  recorder.add(*first), recorder.add(*second);
  for (World* w : {second.get(), first.get()}) {
    BodyDesc body;
    body.shape = make_box(1, 1, 1);
    w->need<Rigid>().add_body(body);
  }
  for (int k = 0; k < 8; ++k) first->step(), second->step(), second->step();
  second->need<Rigid>();
  second.reset();
  first->step();
  recorder.add_facts({{"late", "fact"}});
  recorder.finish("stopped");
  const Recording recording(bytes);
  REQUIRE(recording.world_count() == 2);
  CHECK((recording.steps(0) == 9 && recording.steps(1) == 16));
  CHECK((recording.how() == "stopped" && recording.fact("late") == "fact" && recording.fact("none").empty()));
  CHECK(replay_hashes(bytes) == replay_hashes(bytes, 2));
}

TEST_CASE("a world is recorded from its beginning, and once", "[record]") {
  Recorded r;
  CHECK_THROWS_WITH(r.recorder.add(r.world), Catch::Contains("recorded already"));
  World used(WorldDesc{}, catalog());
  used.step();
  CHECK_THROWS_WITH(r.recorder.add(used), Catch::Contains("without steps"));
}

TEST_CASE("a replay outlives its recording", "[record]") {
  Replay replay(Recording(small_recording()), 0, catalog());
  while (replay.step()) {
  }
  CHECK((replay.same() && replay.world().step_count() == 3));
}

TEST_CASE("a replay that parts from its recording says from which step", "[record]") {
  Recorded r;
  r.add_ball(Vec3(0, 1, 0));
  r.step(6);
  const std::string good = r.finish();
  recording::Blocks blocks(good);
  std::string content;
  for (int k = 0; k < 3; ++k) content = blocks.next().content;
  // the hash of step 6 is the last number
  content.back() = static_cast<char>(content.back() ^ 1);
  const Recording recording(with_block(good, 2, recording::kItems, content));
  Replay replay(recording, 0, catalog());
  while (replay.step()) {
  }
  CHECK(!replay.same());
  CHECK(replay.parted() == 6);
}
