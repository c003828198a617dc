// An entry is a header and the field's content as recordings have it. Written under another name first, so that two
// programs may share the folder.
#include "cli/field_cache.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "feder/error.h"
#include "feder/snapshot.h"

namespace feder::cli {
namespace {

namespace fs = std::filesystem;

struct EntryHeader {
  char magic[8] = {'f', 'e', 'd', 'e', 'r', 's', 'd', 'f'};
  std::uint64_t length = 0, sum = 0;  // of the content: bytes, and their hash
  double error = -1;                  // m
};

std::uint64_t sum_of(const std::string& content, double error) {
  Hash h;
  h.add(error);
  h.bytes(content.data(), content.size());
  return h.value();
}

ShapePtr read_entry(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  EntryHeader head;
  const EntryHeader wanted;
  if (!in.read(reinterpret_cast<char*>(&head), sizeof head)) return nullptr;
  if (std::memcmp(head.magic, wanted.magic, sizeof head.magic) != 0) return nullptr;
  const std::string content{std::istreambuf_iterator<char>(in), {}};
  if (content.size() != head.length || sum_of(content, head.error) != head.sum) return nullptr;
  try {
    return make_shape("sdf", {.sizes = {head.error}, .content = content});
  } catch (const SceneError&) {
    return nullptr;
  }
}

}  // namespace

FieldCache::FieldCache(fs::path folder, std::string stamp) : folder_(std::move(folder)), stamp_(std::move(stamp)) {}

// Two hashes of all that a field is made from: the second of the bytes in groups, so that both differ.
fs::path FieldCache::file_of(const SdfDesc& d) const {
  Hash h;
  std::uint64_t other = d.vertices.size();
  h.bytes(stamp_.data(), stamp_.size());
  h.add(sizeof(Real));
  for (const Vec3& v : d.vertices) {
    h.add(v);
    for (int k = 0; k < 3; ++k) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, &v[k], sizeof v[k]);
      other = (other ^ bits) * 0x9e3779b97f4a7c15ull, other ^= other >> 29;
    }
  }
  for (const std::uint32_t t : d.triangles) h.add(t), other = (other ^ t) * 0x9e3779b97f4a7c15ull, other ^= other >> 29;
  h.add(d.size), h.add(d.spacing), h.add(d.tolerance);
  h.add(d.adaptive), h.add(d.acquire);
  return folder_ / fmt::format("{:016x}{:016x}.sdf", h.value(), other);
}

ShapePtr FieldCache::make(const SdfDesc& desc) const {
  if (folder_.empty() || desc.triangles.empty()) return make_sdf(desc);
  const fs::path file = file_of(desc);
  std::error_code none;
  if (ShapePtr known = read_entry(file)) {
    fs::last_write_time(file, fs::file_time_type::clock::now(), none);  // the oldest go first
    return known;
  }
  const auto start = std::chrono::steady_clock::now();
  ShapePtr made = make_sdf(desc);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  if (taken.count() >= kWorthKeeping) keep(file, *made);
  return made;
}

void FieldCache::keep(const fs::path& file, const Shape& field) const {
  std::error_code failed;
  fs::create_directories(folder_, failed);
  const ShapeArguments of = field.arguments();
  EntryHeader head;
  head.length = of.content.size(), head.error = of.sizes.empty() ? -1 : of.sizes[0];
  head.sum = sum_of(of.content, head.error);
  if (head.length > kMostBytes / 4) return;
  const fs::path draft = folder_ / fmt::format("{}.{}.draft", file.stem().string(), getpid());
  {
    std::ofstream out(draft, std::ios::binary);
    out.write(reinterpret_cast<const char*>(&head), sizeof head);
    out.write(of.content.data(), static_cast<std::streamsize>(of.content.size()));
    out.close();
    if (!out) return void(fs::remove(draft, failed));
  }
  fs::rename(draft, file, failed);
  if (failed) return void(fs::remove(draft, failed));
  make_room();
}

void FieldCache::make_room() const {
  struct Entry {
    fs::path path;
    fs::file_time_type time;
    std::uint64_t bytes;
  };
  std::vector<Entry> all;
  std::uint64_t total = 0;
  std::error_code failed;
  for (fs::directory_iterator it(folder_, failed), end; !failed && it != end; it.increment(failed)) {
    std::error_code gone;
    Entry e{it->path(), it->last_write_time(gone), 0};
    if (!gone) e.bytes = it->file_size(gone);
    if (!gone) all.push_back(e), total += e.bytes;
  }
  std::sort(all.begin(), all.end(), [](const Entry& a, const Entry& b) { return a.time < b.time; });
  for (const Entry& e : all) {
    if (total <= kMostBytes) break;
    fs::remove(e.path, failed);
    total -= e.bytes;
  }
}

fs::path field_cache_folder() {
  const char* given = std::getenv("XDG_CACHE_HOME");
  if (given && fs::path(given).is_absolute()) return fs::path(given) / "feder" / "fields";
  const char* home = std::getenv("HOME");
  if (home && fs::path(home).is_absolute()) return fs::path(home) / ".cache" / "feder" / "fields";
  return {};
}

std::string program_stamp() {
  std::error_code failed;
  const fs::path self = fs::read_symlink("/proc/self/exe", failed);
  if (failed) return {};
  const auto time = fs::last_write_time(self, failed);
  const auto size = failed ? 0 : fs::file_size(self, failed);
  return failed ? std::string() : fmt::format("{} {}", time.time_since_epoch().count(), size);
}

ShapePtr sketch_field(const SdfDesc& desc) {
  if (!desc.values.empty()) return make_sdf(desc);
  SdfDesc sketch = desc;
  sketch.spacing *= 4;
  try {
    return make_sdf(sketch);
  } catch (const SceneError&) {
    return make_sdf(desc);
  }
}

}  // namespace feder::cli
