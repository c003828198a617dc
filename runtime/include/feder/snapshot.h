// Snapshots: byte images of state, and its hash. Same build only: raw bytes in the order they are written. Reading past
// the end, or an image of another build, is a SceneError.
#pragma once
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "feder/error.h"
#include "feder/types.h"

namespace feder {

class Writer {
 public:
  explicit Writer(std::string& out) : out_(out) {}
  template <class T>
  void add(const T& x) {
    static_assert(std::is_trivially_copyable_v<T>);
    out_.append(reinterpret_cast<const char*>(&x), sizeof(T));
  }
  template <class Container>
  void list(const Container& v) {
    using T = typename Container::value_type;
    static_assert(std::is_standard_layout_v<T>);
    add(static_cast<std::uint64_t>(v.size()));
    if (!v.empty()) out_.append(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(T));
  }
  void text(const std::string& s) { list(s); }

 private:
  std::string& out_;
};

class Reader {
 public:
  explicit Reader(std::string_view in) : in_(in) {}
  template <class T>
  void get(T& x) {
    take(&x, sizeof(T));
  }
  template <class T>
  T get() {
    T x{};
    get(x);
    return x;
  }
  template <class Container>
  void list(Container& v) {
    using T = typename Container::value_type;
    std::uint64_t n = 0;
    get(n);
    if (n > in_.size() / sizeof(T)) throw SceneError("snapshot: truncated or of another build");
    v.resize(n);
    if (n) take(v.data(), n * sizeof(T));
  }
  void text(std::string& s) { list(s); }
  bool at_end() const { return in_.empty(); }

 private:
  void take(void* to, std::size_t n) {
    if (n > in_.size()) throw SceneError("snapshot: truncated or of another build");
    std::memcpy(to, in_.data(), n);
    in_.remove_prefix(n);
  }
  std::string_view in_;
};

// 64-bit FNV-1a over bytes: the state hash. Same bytes, same hash, on every machine of the same byte order.
class Hash {
 public:
  void bytes(const void* data, std::size_t count) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < count; ++i) value_ = (value_ ^ p[i]) * 0x100000001b3ull;
  }
  template <class T>
  void add(const T& x) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    bytes(&x, sizeof x);
  }
  void add(const Vec3& v) { add(v[0]), add(v[1]), add(v[2]); }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ull;
};

}  // namespace feder
