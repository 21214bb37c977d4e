// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/toml_table.hpp"

#include "core/error.hpp"
#include "core/text.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace twang {
namespace {

constexpr std::size_t kLongestShown = 80;

std::string written(const toml::node& node);

/// Not left to the library, whose line breaking overflows where a number is negative.
std::string written_list(const toml::array& array) {
  std::string text;
  for (const toml::node& element : array) {
    text += text.empty() ? "[ " : ", ";
    text += written(element);
    if (text.size() > kLongestShown) break;
  }
  if (text.size() <= kLongestShown) text += text.empty() ? "[]" : " ]";
  return text;
}

/// A value as a person wrote it; of a long list only the beginning.
std::string written(const toml::node& node) {
  if (node.is_table()) return "a table";
  if (const auto number = node.as_floating_point()) return exact_text(number->get());
  if (const toml::array* array = node.as_array()) return written_list(*array);
  std::ostringstream stream;
  node.visit([&](const auto& concrete) {
    if constexpr (toml::is_value<decltype(concrete)>) stream << concrete;
  });
  return std::move(stream).str();
}

/// The same in one line, cut where it gets long.
std::string shown(const toml::node& node) {
  if (const toml::array* array = node.as_array(); array && array->is_array_of_tables()) {
    return "an array of tables";
  }
  std::string text = written(node);
  std::replace(text.begin(), text.end(), '\n', ' ');
  if (text.size() > kLongestShown) text = text.substr(0, kLongestShown) + "...";
  return text;
}

/// An integer or a floating-point number, nothing for anything else.
std::optional<double> number_from(const toml::node& node) {
  if (const auto* value = node.as_floating_point()) return value->get();
  if (const auto* value = node.as_integer()) return static_cast<double>(value->get());
  return std::nullopt;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

}  // namespace

struct TomlTable::Access {
  [[nodiscard]] static const toml::table& table(const TomlTable& of) {
    return *static_cast<const toml::table*>(of.m_table);
  }
  [[nodiscard]] static const toml::node& require(const TomlTable& in, std::string_view key) {
    const toml::node* node = table(in).get(key);
    if (node) return *node;
    const auto line = table(in).source().begin.line;
    const std::string place =
        in.m_path.empty() || line == 0 ? in.m_file : fmt::format("{}:{}", in.m_file, line);
    throw InputError(fmt::format("{}: {} is missing", place, in.full_key(key)));
  }
};

TomlTable::TomlTable(const void* table, std::string file, std::string path)
    : m_table(table), m_file(std::move(file)), m_path(std::move(path)) {}

bool TomlTable::has(std::string_view key) const { return Access::table(*this).contains(key); }

bool TomlTable::is_table(std::string_view key) const {
  const toml::node* node = Access::table(*this).get(key);
  return node != nullptr && node->is_table();
}

void TomlTable::allow_only(const std::vector<std::string>& known) const {
  for (const auto& [key, node] : Access::table(*this)) {
    if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
    throw InputError(fmt::format("{}:{}: {} is not a known key, must be one of: {} (nearest: {})",
                                 m_file,
                                 key.source().begin.line,
                                 full_key(key.str()),
                                 joined(known),
                                 nearest_word(key.str(), known)));
  }
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> names;
  for (const auto& [key, node] : Access::table(*this)) names.emplace_back(key.str());
  return names;
}

double TomlTable::number(std::string_view key) const {
  const auto value = number_from(Access::require(*this, key));
  if (!value) refuse(key, "a number");
  if (!std::isfinite(*value)) refuse(key, "a finite number");
  return *value;
}

double TomlTable::positive(std::string_view key) const {
  const double value = number(key);
  if (!(value > 0.0)) refuse(key, "> 0");
  return value;
}

double TomlTable::non_negative(std::string_view key) const {
  const double value = number(key);
  if (!(value >= 0.0)) refuse(key, ">= 0");
  return value;
}

int TomlTable::count(std::string_view key) const {
  const auto* value = Access::require(*this, key).as_integer();
  if (!value || value->get() < 0 || value->get() > std::numeric_limits<int>::max()) {
    refuse(key, "a whole number >= 0");
  }
  return static_cast<int>(value->get());
}

bool TomlTable::flag(std::string_view key) const {
  const auto* value = Access::require(*this, key).as_boolean();
  if (!value) refuse(key, "true or false");
  return value->get();
}

std::string TomlTable::text(std::string_view key) const {
  const auto* value = Access::require(*this, key).as_string();
  if (!value) refuse(key, "a text in quotes");
  if (value->get().empty()) refuse(key, "a text that is not empty");
  return value->get();
}

std::string TomlTable::free_text(std::string_view key) const {
  const toml::node& node = Access::require(*this, key);
  if (const auto* value = node.as_string()) return value->get();
  if (!node.is_value()) refuse(key, "a text or a number");
  return shown(node);
}

std::vector<std::string> TomlTable::texts(std::string_view key) const {
  const toml::array* array = Access::require(*this, key).as_array();
  if (!array) refuse(key, "a list of texts");
  std::vector<std::string> values;
  for (const toml::node& node : *array) {
    if (!node.is_string()) refuse(key, "a list of texts");
    values.push_back(node.as_string()->get());
  }
  return values;
}

Eigen::Vector3d TomlTable::vector(std::string_view key) const {
  const toml::array* array = Access::require(*this, key).as_array();
  if (!array || array->size() != 3) refuse(key, "three numbers [x, y, z]");
  Eigen::Vector3d vector;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto value = number_from(*array->get(i));
    if (!value) refuse(key, "three numbers [x, y, z]");
    vector(static_cast<Eigen::Index>(i)) = *value;
  }
  if (!vector.allFinite()) refuse(key, "three finite numbers [x, y, z]");
  return vector;
}

Eigen::Vector3d TomlTable::direction(std::string_view key) const {
  const Eigen::Vector3d value = vector(key);
  if (!(value.stableNorm() > 0.0)) refuse(key, "a direction that is not zero");
  return value;
}

std::size_t TomlTable::choice(std::string_view key, const std::vector<std::string>& choices) const {
  const std::string value = text(key);
  const auto it = std::find(choices.begin(), choices.end(), value);
  if (it == choices.end()) {
    refuse(key,
           fmt::format("one of: {} (nearest: {})", joined(choices), nearest_word(value, choices)));
  }
  return static_cast<std::size_t>(it - choices.begin());
}

std::optional<TomlTable> TomlTable::table(std::string_view key) const {
  if (!has(key)) return std::nullopt;
  const toml::table* table = Access::require(*this, key).as_table();
  if (!table) refuse(key, fmt::format("a table [{}]", full_key(key)));
  return TomlTable(table, m_file, full_key(key));
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) const {
  if (!has(key)) return {};
  const toml::array* array = Access::require(*this, key).as_array();
  std::vector<TomlTable> tables;
  for (std::size_t i = 0; array && i < array->size(); ++i) {
    const toml::table* table = array->get(i)->as_table();
    if (!table) break;
    tables.push_back(TomlTable(table, m_file, fmt::format("{}.{}", full_key(key), i + 1)));
  }
  if (!array || tables.size() != array->size()) {
    refuse(key, fmt::format("an array of tables, each headed [[{}]]", full_key(key)));
  }
  return tables;
}

void TomlTable::refuse(std::string_view key, std::string_view expected) const {
  complain(key, fmt::format("is {}, must be {}", shown(*Access::table(*this).get(key)), expected));
}

void TomlTable::complain(std::string_view key, std::string_view complaint) const {
  const std::string subject = place(key);
  throw InputError(fmt::format("{}{}{}", subject, subject.ends_with(": ") ? "" : " ", complaint));
}

std::string TomlTable::place(std::string_view key) const {
  const toml::table& own = Access::table(*this);
  const toml::node* node = key.empty() ? &own : own.get(key);
  const bool at_document = key.empty() && m_path.empty();
  const auto line = node && !at_document ? node->source().begin.line : 0;
  const std::string where = line > 0 ? fmt::format("{}:{}", m_file, line) : m_file;
  return fmt::format("{}: {}", where, full_key(key));
}

std::string TomlTable::full_key(std::string_view key) const {
  if (m_path.empty() || key.empty()) return m_path + std::string(key);
  return fmt::format("{}.{}", m_path, key);
}

struct TomlDocument::Impl {
  std::string file;
  toml::table table;
};

TomlDocument::TomlDocument(const std::string& content, std::string file, std::string_view expected)
    : m_impl(std::make_unique<Impl>()) {
  if (content.find_first_not_of(" \t\r\n") == std::string::npos) {
    throw InputError(fmt::format("{}: is empty, must be {}", file, expected));
  }
  if (content.find('\0') != std::string::npos) {
    throw InputError(fmt::format("{}: is a binary file, must be {}", file, expected));
  }
  try {
    m_impl->table = toml::parse(content, file);
  } catch (const toml::parse_error& error) {
    throw InputError(
        fmt::format("{}:{}: {}", file, error.source().begin.line, error.description()));
  }
  m_impl->file = std::move(file);
}
TomlDocument::~TomlDocument() = default;

TomlTable TomlDocument::root() const { return {&m_impl->table, m_impl->file, ""}; }

}  // namespace twang
