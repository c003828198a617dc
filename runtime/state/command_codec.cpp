#include "state/command_codec.h"

#include <cstring>

namespace feder {
namespace {

// Bit patterns, least byte first on every machine.
void put_bits(std::string& out, std::uint64_t bits) {
  for (int k = 0; k < 8; ++k) out.push_back(static_cast<char>(bits >> (8 * k) & 0xff));
}

[[noreturn]] void fail_short() { throw SceneError("recording: a command ends too early"); }

}  // namespace

void CommandBytes::whole(std::uint64_t x) {
  for (; x >= 0x80; x >>= 7) bytes_.push_back(static_cast<char>(0x80 | (x & 0x7f)));
  bytes_.push_back(static_cast<char>(x));
}

void CommandBytes::number(double x) { put_bits(bytes_, std::bit_cast<std::uint64_t>(x)); }

void CommandBytes::text(std::string_view x) {
  whole(x.size());
  bytes_.append(x);
}

// 0 and its content when it is new, else its number from 1.
void CommandBytes::shape(const ShapePtr& x) {
  if (const auto known = numbers_.find(x.get()); known != numbers_.end()) return whole(known->second);
  whole(0);
  whole(x ? 1 : 0);
  if (!x) return;
  content(*x);
  kept_.push_back(x);
  numbers_[x.get()] = kept_.size();
}

void CommandBytes::content(const Shape& x) {
  const ShapeArguments a = x.arguments();
  text(x.kind());
  command::write(*this, a.sizes), command::write(*this, a.direction);
  command::write(*this, a.points), command::write(*this, a.triangles);
  whole(a.parts.size());
  for (const CompoundPart& part : a.parts)
    shape(part.shape), command::write(*this, part.pose), command::write(*this, part.surface);
  command::write(*this, a.surfaces), command::write(*this, a.triangle_surfaces);
  command::write(*this, a.mesh_index), command::write(*this, a.content);
}

void CommandBytes::forget_shapes(std::size_t from) {
  for (; kept_.size() > from; kept_.pop_back()) numbers_.erase(kept_.back().get());
}

void CommandBytes::params(const Params& x) {
  whole(x.values().size());
  for (const auto& [key, value] : x.values()) {
    text(key);
    whole(value.index());
    std::visit([this](const auto& v) { command::write(*this, v); }, value);
  }
}

std::string_view CommandReader::view(std::uint64_t size) {
  if (size > in_.size()) fail_short();
  const std::string_view out = in_.substr(0, size);
  in_.remove_prefix(size);
  return out;
}

std::uint8_t CommandReader::byte() { return static_cast<std::uint8_t>(view(1)[0]); }

std::uint64_t CommandReader::whole() {
  std::uint64_t x = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    const std::uint8_t b = byte();
    x |= static_cast<std::uint64_t>(b & 0x7f) << shift;
    if (b < 0x80) return x;
  }
  throw SceneError("recording: a whole number is too long");
}

double CommandReader::number() {
  std::uint64_t bits = 0;
  const std::string_view v = view(8);
  for (std::size_t k = 0; k < 8; ++k) bits |= static_cast<std::uint64_t>(static_cast<unsigned char>(v[k])) << (8 * k);
  return std::bit_cast<double>(bits);
}

std::string CommandReader::text() { return std::string(view(whole())); }

std::uint64_t CommandReader::count() {
  const std::uint64_t n = whole();
  if (n > in_.size()) fail_short();
  return n;
}

ShapePtr CommandReader::shape() {
  const std::uint64_t number = whole();
  if (number > shapes_.size()) throw SceneError("recording: shape number " + std::to_string(number) + " is unknown");
  if (number > 0) return shapes_[number - 1];
  if (whole() == 0) return nullptr;
  ShapePtr made = content();
  shapes_.push_back(made);
  return made;
}

ShapePtr CommandReader::content() {
  const std::string kind = text();
  ShapeArguments a;
  command::read(*this, a.sizes), command::read(*this, a.direction);
  command::read(*this, a.points), command::read(*this, a.triangles);
  for (std::uint64_t n = count(); n > 0; --n) {
    CompoundPart part{shape(), {}};
    command::read(*this, part.pose), command::read(*this, part.surface);
    a.parts.push_back(std::move(part));
  }
  command::read(*this, a.surfaces), command::read(*this, a.triangle_surfaces);
  command::read(*this, a.mesh_index), command::read(*this, a.content);
  return make_shape(kind.c_str(), a.input());
}

Params CommandReader::params() {
  Params out;
  for (std::uint64_t n = count(); n > 0; --n) {
    std::string key = text();
    Params::Value value;
    switch (whole()) {
      case 0: command::read(*this, value.emplace<bool>()); break;
      case 1: command::read(*this, value.emplace<double>()); break;
      case 2: command::read(*this, value.emplace<std::string>()); break;
      case 3: command::read(*this, value.emplace<std::vector<double>>()); break;
      default: throw SceneError("recording: option '" + key + "' is of an unknown type");
    }
    out.set(std::move(key), std::move(value));
  }
  return out;
}

}  // namespace feder
