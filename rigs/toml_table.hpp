// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace twang {

/// One table of a TOML document, with the place it stands at: every complaint begins with file,
/// line and full key ("rigs/arm.toml:31: marker.3.size_mm is -2, must be > 0").
///
/// Tables of an array are counted from 1, as a person counts them.
class TomlTable {
 public:
  /// @throws InputError if a key of the table is not among `known`
  void allow_only(const std::vector<std::string>& known) const;
  [[nodiscard]] bool has(std::string_view key) const;
  [[nodiscard]] bool is_table(std::string_view key) const;  ///< false too if there is none
  [[nodiscard]] std::vector<std::string> keys() const;

  // The value of a key; each throws InputError if it is missing, of another type or out of range.
  [[nodiscard]] double number(std::string_view key) const;        ///< finite
  [[nodiscard]] double positive(std::string_view key) const;      ///< finite, > 0
  [[nodiscard]] double non_negative(std::string_view key) const;  ///< finite, >= 0
  [[nodiscard]] int count(std::string_view key) const;            ///< whole, >= 0
  [[nodiscard]] bool flag(std::string_view key) const;
  [[nodiscard]] std::string text(std::string_view key) const;       ///< not empty
  [[nodiscard]] std::string free_text(std::string_view key) const;  ///< any scalar, as text
  [[nodiscard]] std::vector<std::string> texts(std::string_view key) const;
  [[nodiscard]] Eigen::Vector3d vector(std::string_view key) const;     ///< finite
  [[nodiscard]] Eigen::Vector3d direction(std::string_view key) const;  ///< finite, not zero
  /// A text that is one of `choices`: its index.
  [[nodiscard]] std::size_t choice(std::string_view key,
                                   const std::vector<std::string>& choices) const;

  /// The table at `key`, nothing if there is none.
  [[nodiscard]] std::optional<TomlTable> table(std::string_view key) const;
  /// The tables of the array at `key`, none if there is no such key.
  [[nodiscard]] std::vector<TomlTable> tables(std::string_view key) const;

  /// "FILE:LINE: KEY is VALUE, must be EXPECTED"
  [[noreturn]] void refuse(std::string_view key, std::string_view expected) const;
  /// "FILE:LINE: KEY COMPLAINT", at the table itself if `key` is empty.
  [[noreturn]] void complain(std::string_view key, std::string_view complaint) const;
  /// "FILE:LINE: KEY", for complaints that can only be made later.
  [[nodiscard]] std::string place(std::string_view key) const;

 private:
  friend class TomlDocument;
  struct Access;  // the library's own table

  TomlTable(const void* table, std::string file, std::string path);
  [[nodiscard]] std::string full_key(std::string_view key) const;

  const void* m_table;  // toml::table, which the source file alone sees; outlives this
  std::string m_file;
  std::string m_path;  // full key of the table, empty for the document
};

/// A TOML document; its tables live as long as it does.
class TomlDocument {
 public:
  /// Parses `content`, the text of `file`.
  /// @param expected  what it must be, for messages: "a rig file (twang-rig/1)"
  /// @throws InputError "FILE:LINE: ..." if it is empty, binary or not TOML
  TomlDocument(const std::string& content, std::string file, std::string_view expected);
  ~TomlDocument();
  TomlDocument(const TomlDocument&) = delete;
  TomlDocument& operator=(const TomlDocument&) = delete;

  [[nodiscard]] TomlTable root() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> m_impl;
};

}  // namespace twang
