// Arguments of commands as bytes, and back: numbers as doubles, whole numbers in groups of seven bits (LEB128), shapes
// by their arguments, once each. The bytes are the same for both scalar types and on every machine. A type is written
// by its kind in a signature too, so that a reader knows whether it reads what was written.
#pragma once
#include <bit>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <unordered_map>
#include <vector>

#include "feder/error.h"
#include "feder/events.h"
#include "feder/params.h"
#include "feder/shape.h"
#include "feder/types.h"

namespace feder {

class CommandBytes {
 public:
  void whole(std::uint64_t x);
  void number(double x);
  void text(std::string_view x);
  void shape(const ShapePtr& x);  // its content when it is new
  void content(const Shape& x);   // always
  void params(const Params& x);
  const std::string& bytes() const { return bytes_; }
  void clear() { bytes_.clear(); }
  // Shapes known so far; those that came later can be forgotten again.
  std::size_t shapes() const { return kept_.size(); }
  void forget_shapes(std::size_t from);

 private:
  std::string bytes_;
  std::vector<ShapePtr> kept_;  // by number
  std::unordered_map<const Shape*, std::uint64_t> numbers_;
};

// Reads what CommandBytes has written; SceneError where that cannot be.
class CommandReader {
 public:
  explicit CommandReader(std::vector<ShapePtr>& shapes) : shapes_(shapes) {}
  void read_from(std::string_view bytes) { in_ = bytes; }
  bool at_end() const { return in_.empty(); }
  std::string_view rest() const { return in_; }

  std::uint8_t byte();
  std::uint64_t whole();
  double number();
  std::string text();
  std::string_view view(std::uint64_t size);  // so many bytes
  ShapePtr shape();
  ShapePtr content();
  Params params();
  std::uint64_t count();  // of things that follow, of a byte at least

 private:
  std::string_view in_;
  std::vector<ShapePtr>& shapes_;
};

namespace command {

template <class T>
inline constexpr bool kDescription = requires(T& x) {
  T::each_field(x, [](auto&) {});
};
template <class T>
inline constexpr bool kListed = false;
template <class T, class A>
inline constexpr bool kListed<std::vector<T, A>> = true;
template <class T, std::size_t N>
inline constexpr bool kListed<std::span<T, N>> = true;
template <class T>
inline constexpr bool kOptionTable = std::is_same_v<T, std::map<std::string, Params>>;
template <class T>
inline constexpr bool kText = std::is_convertible_v<const T&, std::string_view>;

// Letters: b boolean, u i whole number without and with sign, n number, t text, o object, v vector, q rotation, p pose,
// c cause, s shared shape, S its content, m options (*m: by names), *x list of x, ?x x or nothing, {..} description.
template <class T>
void sign(std::string& out) {
  if constexpr (std::is_same_v<T, bool>)
    out += 'b';
  else if constexpr (std::is_integral_v<T> || std::is_enum_v<T>)
    out += std::is_signed_v<T> ? 'i' : 'u';
  else if constexpr (std::is_floating_point_v<T>)
    out += 'n';
  else if constexpr (kText<T>)
    out += 't';
  else if constexpr (std::is_same_v<T, ObjectId>)
    out += 'o';
  else if constexpr (std::is_same_v<T, Vec3>)
    out += 'v';
  else if constexpr (std::is_same_v<T, const Vec3*> || std::is_same_v<T, std::optional<Vec3>>)
    out += "?v";
  else if constexpr (std::is_same_v<T, Quat>)
    out += 'q';
  else if constexpr (std::is_same_v<T, Pose>)
    out += 'p';
  else if constexpr (std::is_same_v<T, WakeCause>)
    out += 'c';
  else if constexpr (std::is_same_v<T, ShapePtr>)
    out += 's';
  else if constexpr (std::is_base_of_v<Shape, T>)
    out += 'S';
  else if constexpr (std::is_same_v<T, Params>)
    out += 'm';
  else if constexpr (kOptionTable<T>)
    out += "*m";
  else if constexpr (kListed<T>)
    out += '*', sign<std::remove_cv_t<typename T::value_type>>(out);
  else if constexpr (std::is_array_v<T>)
    for (std::size_t k = 0; k < std::extent_v<T>; ++k) sign<std::remove_extent_t<T>>(out);
  else {
    static_assert(kDescription<T>, "no bytes are known for this type");
    out += '{';
    T x{};
    T::each_field(x, [&](auto& field) { sign<std::remove_cvref_t<decltype(field)>>(out); });
    out += '}';
  }
}

template <class T>
void write(CommandBytes& out, const T& x) {
  if constexpr (std::is_enum_v<T>)
    out.whole(static_cast<std::uint64_t>(x));
  else if constexpr (std::is_integral_v<T>)
    // small numbers of both signs in few bytes
    out.whole(std::is_signed_v<T> ? (static_cast<std::uint64_t>(x) << 1) ^ (x < T{0} ? ~std::uint64_t{0} : 0)
                                  : static_cast<std::uint64_t>(x));
  else if constexpr (std::is_floating_point_v<T>)
    out.number(static_cast<double>(x));
  else if constexpr (kText<T>)
    out.text(x);
  else if constexpr (std::is_same_v<T, ObjectId>)
    out.whole(x.slot), out.whole(x.generation);
  else if constexpr (std::is_same_v<T, Vec3>)
    for (int k = 0; k < 3; ++k) write(out, x[k]);
  else if constexpr (std::is_same_v<T, const Vec3*>) {
    write(out, x != nullptr);
    if (x) write(out, *x);
  } else if constexpr (std::is_same_v<T, Quat>)
    write(out, x.vec()), write(out, x.w);
  else if constexpr (std::is_same_v<T, Pose>)
    write(out, x.position), write(out, x.rotation);
  else if constexpr (std::is_same_v<T, WakeCause>)
    out.text(x.text());
  else if constexpr (std::is_same_v<T, ShapePtr>)
    out.shape(x);
  else if constexpr (std::is_base_of_v<Shape, T>)
    out.content(x);
  else if constexpr (std::is_same_v<T, Params>)
    out.params(x);
  else if constexpr (kListed<T>) {
    out.whole(x.size());
    for (const auto& item : x) write(out, item);
  } else if constexpr (kOptionTable<T>) {
    out.whole(x.size());
    for (const auto& [name, options] : x) out.text(name), out.params(options);
  } else if constexpr (std::is_array_v<T>)
    for (const auto& item : x) write(out, item);
  else
    T::each_field(x, [&](const auto& field) { write(out, field); });
}

template <class T>
void read(CommandReader& in, T& x) {
  if constexpr (std::is_same_v<T, bool>)
    x = in.whole() != 0;
  else if constexpr (std::is_enum_v<T>)
    x = static_cast<T>(in.whole());
  else if constexpr (std::is_integral_v<T>) {
    const std::uint64_t raw = in.whole();
    x = static_cast<T>(std::is_signed_v<T> ? (raw >> 1) ^ (raw & 1 ? ~std::uint64_t{0} : 0) : raw);
  } else if constexpr (std::is_floating_point_v<T>)
    x = static_cast<T>(in.number());
  else if constexpr (std::is_same_v<T, std::string>)
    x = in.text();
  else if constexpr (std::is_same_v<T, ObjectId>)
    read(in, x.slot), read(in, x.generation);
  else if constexpr (std::is_same_v<T, Vec3>)
    for (int k = 0; k < 3; ++k) read(in, x[k]);
  else if constexpr (std::is_same_v<T, std::optional<Vec3>>) {
    bool there = false;
    read(in, there);
    if (there) read(in, x.emplace(Vec3::Zero()));
  } else if constexpr (std::is_same_v<T, Quat>)
    read(in, x.x), read(in, x.y), read(in, x.z), read(in, x.w);
  else if constexpr (std::is_same_v<T, Pose>)
    read(in, x.position), read(in, x.rotation);
  else if constexpr (std::is_same_v<T, ShapePtr>)
    x = in.shape();
  else if constexpr (std::is_same_v<T, Params>)
    x = in.params();
  else if constexpr (kListed<T>) {
    const std::uint64_t count = in.count();
    x.clear();
    for (std::uint64_t k = 0; k < count; ++k) read(in, x.emplace_back());
  } else if constexpr (kOptionTable<T>) {
    for (std::uint64_t n = in.count(); n > 0; --n) {
      const std::string name = in.text();
      x[name] = in.params();
    }
  } else if constexpr (std::is_array_v<T>)
    for (auto& item : x) read(in, item);
  else
    T::each_field(x, [&](auto& field) { read(in, field); });
}

}  // namespace command

}  // namespace feder
