// A struct as a JSON object: one list of its fields, `fields(value, visitor, tag)`, writes it and reads it back.
//
//   void fields(auto& p, auto& visit, const Point*) {
//     visit("x", p.x)("name", p.name);
//   }
//
// NaN is null; infinity, which JSON lacks, is the text "inf". A key that is missing, or null, leaves the member as it
// is. Lists stand in feder::report, outside of unnamed namespaces: they are found by their argument.
#pragma once
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

#include "report/json.h"

namespace feder::report {

template <class T>
Json json_value(const T& v) {
  return v;
}
inline Json json_value(double v) {
  if (std::isnan(v)) return nullptr;
  if (std::isinf(v)) return v > 0 ? "inf" : "-inf";
  return v;
}
// A curve that does not apply, of NaN alone, is left out.
inline Json json_value(const std::vector<double>& values) {
  Json out = Json::array();
  if (std::ranges::all_of(values, [](double v) { return std::isnan(v); })) return out;
  for (const double v : values) out.push_back(json_value(v));
  return out;
}

template <class T>
void read_value(const Json& j, T& v) {
  if (!j.is_null()) v = j.get<T>();
}
inline void read_value(const Json& j, double& v) {
  if (j.is_null())
    v = NAN;
  else if (j.is_string())
    v = j.get<std::string>() == "-inf" ? -INFINITY : INFINITY;
  else
    v = j.get<double>();
}
inline void read_value(const Json& j, std::vector<double>& values) {
  values.assign(j.size(), 0);
  for (std::size_t k = 0; k < j.size(); ++k) read_value(j[k], values[k]);
}

template <class T>
Json written(const T& value);
template <class T>
Json written(const std::vector<T>& values);
template <class T>
void read_into(const Json& j, T& value);
template <class T>
void read_into(const Json& j, std::vector<T>& values);

// The visitors of JSON; others may ask for more, such as whether a field is a column of a table. named: an enum by its
// name, one of `all`; part: a struct, or a list of them, with fields of its own (Json::exception when it is missing);
// object: fields in an object of their own; derived: written for people, not read back.
struct JsonWriter {
  Json out = Json::object();
  template <class T>
  JsonWriter& operator()(const char* key, const T& v, bool = false) {
    out[key] = json_value(v);
    return *this;
  }
  template <class E>
  JsonWriter& named(const char* key, E v, std::initializer_list<E>) {
    return derived(key, name_of(v));
  }
  template <class T>
  JsonWriter& derived(const char* key, const T& v) {
    return (*this)(key, v);
  }
  template <class T>
  JsonWriter& part(const char* key, const T& v) {
    return derived(key, written(v));
  }
  template <class F>
  JsonWriter& object(const char* key, F&& list) {
    JsonWriter inner;
    list(inner);
    return derived(key, inner.out);
  }
};
struct JsonReader {
  const Json& in;
  template <class T>
  JsonReader& operator()(const char* key, T& v, bool = false) {
    if (in.contains(key)) read_value(in[key], v);
    return *this;
  }
  // std::runtime_error names what is unknown.
  template <class E>
  JsonReader& named(const char* key, E& v, std::initializer_list<E> all) {
    if (!in.contains(key)) return *this;
    const auto name = in[key].get<std::string>();
    const auto found = std::ranges::find_if(all, [&](E e) { return name == name_of(e); });
    if (found == all.end()) throw std::runtime_error(std::string("unknown ") + key + " '" + name + "'");
    v = *found;
    return *this;
  }
  template <class T>
  JsonReader& derived(const char*, const T&) {
    return *this;
  }
  template <class T>
  JsonReader& part(const char* key, T& v) {
    read_into(in.at(key), v);
    return *this;
  }
  template <class F>
  JsonReader& object(const char* key, F&& list) {
    if (!in.contains(key)) return *this;
    JsonReader inner{in[key]};
    list(inner);
    return *this;
  }
};

template <class T>
Json written(const T& value) {
  JsonWriter w;
  fields(value, w, &value);
  return w.out;
}
template <class T>
Json written(const std::vector<T>& values) {
  Json out = Json::array();
  for (const T& v : values) out.push_back(written(v));
  return out;
}

template <class T>
void read_into(const Json& j, T& value) {
  JsonReader r{j};
  fields(value, r, &value);
}
template <class T>
void read_into(const Json& j, std::vector<T>& values) {
  for (const Json& one : j) read_into(one, values.emplace_back());
}
template <class T>
T read_as(const Json& j) {
  T value;
  read_into(j, value);
  return value;
}

}  // namespace feder::report
