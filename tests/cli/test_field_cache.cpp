// Fields of meshes that are kept from run to run: what is kept, what it is worth, and what happens where it cannot be.
#include "cli/program.h"
#include "support/catch.h"

using namespace feder::test;

namespace {

// A ball of triangles with a mass, so fine that its field takes a while, and one that is asked for.
const std::string kBalls = R"lua(
local v, t, n = {}, {}, 24
for i = 0, n do
  for j = 0, 2 * n - 1 do
    local a, b = math.pi * i / n, math.pi * j / n
    v[#v + 1] = { math.sin(a) * math.cos(b), math.cos(a), math.sin(a) * math.sin(b) }
  end
end
local function at(i, j) return i * 2 * n + j % (2 * n) + 1 end
for i = 0, n - 1 do
  for j = 0, 2 * n - 1 do
    t[#t + 1] = { at(i, j), at(i, j + 1), at(i + 1, j) }
    t[#t + 1] = { at(i, j + 1), at(i + 1, j + 1), at(i + 1, j) }
  end
end
local ball = feder.mesh(v, t)
scene.ball = world:body { name = "ball", shape = ball, position = { 0, 3, 0 } }
world:body { name = "other", position = { 4, 3, 0 }, shape = feder.sdf { mesh = ball, spacing = 0.04 } }
world:body { type = "static", shape = feder.plane() }
)lua";

struct Kept {
  int count = 0;
  std::filesystem::path any;
};

Kept kept(const Program& p) {
  Kept k;
  const std::filesystem::path folder = p.folder() / ".cache" / "feder" / "fields";
  if (!std::filesystem::is_directory(folder)) return k;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) ++k.count, k.any = entry.path();
  return k;
}

std::string hash_of(const Outcome& o) { return o.json().at("hash"); }

}  // namespace

TEST_CASE("fields of meshes are kept from run to run", "[cli]") {
  const Program p;
  p.write("a.lua", scene(kBalls));
  const std::string run = "run a.lua --json --steps 30";
  const Outcome anew = p.run(run + " --no-cache");
  REQUIRE(anew.status == 0);
  CHECK(kept(p).count == 0);
  CHECK(p.run("test a.lua").status == 0);
  CHECK(kept(p).count == 0);

  CHECK(hash_of(p.run(run)) == hash_of(anew));
  const Kept first = kept(p);
  REQUIRE(first.count == 2);
  CHECK(hash_of(p.run(run)) == hash_of(anew));
  CHECK(kept(p).count == 2);
  // what explain certifies is kept along
  const auto certificates = [&](const std::string& more) {
    std::istringstream words(p.run("explain a.lua" + more).out);
    std::string text;
    for (std::string word; words >> word;) text += word + " ";
    return text.substr(text.find("field of"), text.rfind("error near the surface") - text.find("field of") + 40);
  };
  const std::string told = certificates(" --no-cache");
  CHECK(says(told, "largest error near the surface"));
  CHECK(certificates("") == told);
  CHECK(kept(p).count == 2);

  SECTION("an entry that is not what was written") {
    const std::string good = read_file(first.any);
    std::string bad = good;
    bad[bad.size() / 2] ^= 1;
    for (const std::string& text : {bad, good.substr(0, good.size() / 2), std::string("x"), std::string()}) {
      std::ofstream(first.any, std::ios::binary) << text;
      CHECK(hash_of(p.run(run)) == hash_of(anew));
      CHECK(read_file(first.any) == good);
    }
  }
  SECTION("no folder can be made") {
    std::filesystem::remove_all(p.folder() / ".cache");
    p.write(".cache", "a file");
    const Outcome o = p.run(run);
    CHECK(hash_of(o) == hash_of(anew));
    CHECK(o.err == anew.err);
    CHECK(p.shell("env -u HOME XDG_CACHE_HOME= '" FEDER_BINARY_DIR "/feder' " + run).status == 0);
  }
}
