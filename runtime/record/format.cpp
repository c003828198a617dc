#include "record/format.h"

#include <cstdint>

#include "feder/record.h"

namespace feder::recording {
namespace {

constexpr std::string_view kName = "feder recording ";
constexpr std::size_t kBefore = 9, kBehind = 8;  // bytes: letter and length; checksum

void put(std::string& out, std::uint64_t x) {
  for (int k = 0; k < 8; ++k) out.push_back(static_cast<char>(x >> (8 * k) & 0xff));
}

std::uint64_t get(std::string_view in) {
  std::uint64_t x = 0;
  for (std::size_t k = 0; k < 8; ++k) x |= static_cast<std::uint64_t>(static_cast<unsigned char>(in[k])) << (8 * k);
  return x;
}

std::uint64_t checksum(std::string_view bytes) {
  Hash h;
  h.bytes(bytes.data(), bytes.size());
  return h.value();
}

}  // namespace

std::string first_line() { return std::string(kName) + std::to_string(kRecordingFormat) + "\n"; }

std::string block(char kind, std::string_view content) {
  std::string out(1, kind);
  put(out, content.size());
  out.append(content);
  put(out, checksum(out));
  return out;
}

Blocks::Blocks(std::string_view bytes) : rest_(bytes), total_(bytes.size()) {
  if (!rest_.starts_with(kName)) throw SceneError("not a recording of feder: it does not begin with 'feder recording'");
  const std::size_t line = rest_.find('\n');
  if (line == std::string_view::npos || line > 40) throw SceneError("the recording's first line is damaged");
  const std::string_view format = rest_.substr(kName.size(), line - kName.size());
  if (format != std::to_string(kRecordingFormat))
    throw SceneError("the recording is of format '" + std::string(format) + "', this build reads format " +
                     std::to_string(kRecordingFormat));
  rest_.remove_prefix(line + 1);
}

Block Blocks::next() {
  const std::string where =
      "block " + std::to_string(++count_) + " at byte " + std::to_string(total_ - rest_.size()) + " of the recording";
  if (rest_.size() < kBefore + kBehind) throw SceneError(where + " is cut off: the file is truncated");
  const std::uint64_t size = get(rest_.substr(1, 8));
  if (size > rest_.size() - kBefore - kBehind)
    throw SceneError(where + " says that it has " + std::to_string(size) + " bytes, but only " +
                     std::to_string(rest_.size() - kBefore - kBehind) + " are left: truncated or damaged");
  const std::string_view whole = rest_.substr(0, kBefore + size);
  if (get(rest_.substr(kBefore + size, 8)) != checksum(whole))
    throw SceneError(where + " is damaged: its checksum is another");
  rest_.remove_prefix(kBefore + size + kBehind);
  return {whole[0], whole.substr(kBefore)};
}

}  // namespace feder::recording
