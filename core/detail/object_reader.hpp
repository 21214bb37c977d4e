// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/constants.hpp"
#include "core/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

namespace twang::detail {

using Json = nlohmann::ordered_json;

/// Reads the keys of one JSON object and says which of them is wrong.
class ObjectReader {
 public:
  ObjectReader(const Json& object, std::string file, std::string prefix)
      : m_object(object), m_file(std::move(file)), m_prefix(std::move(prefix)) {}

  [[nodiscard]] double number(const char* key) const {
    const Json& value = require(key);
    if (value.is_null()) return kNaN;
    if (!value.is_number()) fail(key, value, "a number");
    return value.get<double>();
  }
  [[nodiscard]] double positive(const char* key) const {
    const double value = number(key);
    if (!(value > 0.0) || !std::isfinite(value)) fail(key, m_object.at(key), "a number > 0");
    return value;
  }
  [[nodiscard]] double non_negative(const char* key) const {
    const double value = number(key);
    if (!(value >= 0.0) || !std::isfinite(value)) fail(key, m_object.at(key), "a number >= 0");
    return value;
  }
  [[nodiscard]] double finite(const char* key) const {
    const double value = number(key);
    if (!std::isfinite(value)) fail(key, m_object.at(key), "a finite number");
    return value;
  }
  [[nodiscard]] int count(const char* key) const {
    const Json& value = require(key);
    const double rounded = value.is_number_integer() ? value.get<double>() : -1.0;
    if (rounded < 0.0 || rounded > std::numeric_limits<int>::max()) {
      fail(key, value, "a whole number >= 0");
    }
    return value.get<int>();
  }
  [[nodiscard]] double poissons_ratio(const char* key) const {
    const double value = number(key);
    if (!(value > -1.0 && value < 0.5)) {
      fail(key, m_object.at(key), "between -1 and 0.5, both excluded");
    }
    return value;
  }
  [[nodiscard]] const Json& array(const char* key) const {
    const Json& value = require(key);
    if (!value.is_array()) fail(key, value, "an array");
    return value;
  }
  [[nodiscard]] std::map<std::string, std::string> texts(const char* key) const {
    std::map<std::string, std::string> texts;
    for (const auto& [name, value] : object(key).m_object.items()) {
      texts[name] = value.is_string() ? value.get<std::string>() : value.dump();
    }
    return texts;
  }
  [[nodiscard]] std::string text(const char* key) const {
    const Json& value = require(key);
    if (!value.is_string()) fail(key, value, "a text");
    return value.get<std::string>();
  }
  [[nodiscard]] ObjectReader object(const char* key) const {
    const Json& value = require(key);
    if (!value.is_object()) fail(key, value, "an object");
    return {value, m_file, m_prefix + key + "."};
  }
  [[nodiscard]] bool has(const char* key) const {
    return m_object.contains(key) && !m_object.at(key).is_null();
  }
  [[nodiscard]] const Json& require(const char* key) const {
    if (!m_object.contains(key))
      throw InputError(fmt::format("{}: {}{} is missing", m_file, m_prefix, key));
    return m_object.at(key);
  }
  [[noreturn]] void fail(const char* key, const Json& value, const char* expected) const {
    constexpr std::size_t kLongest = 80;
    std::string shown = value.dump();
    if (shown.size() > kLongest) shown = shown.substr(0, kLongest) + "...";
    throw InputError(
        fmt::format("{}: {}{} is {}, must be {}", m_file, m_prefix, key, shown, expected));
  }

 private:
  const Json& m_object;
  std::string m_file;
  std::string m_prefix;
};

}  // namespace twang::detail
