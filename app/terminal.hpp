// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/progress.hpp"

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace twang::app {

/// Makes Ctrl-C ask running work to stop at its next progress report; a second one ends the program
/// at once.
void catch_interrupts();

/// A progress callback: a bar on stderr when that is a terminal, silent otherwise; false once
/// Ctrl-C was pressed.
/// @param prefix  asked for what is said before the stage ("film 2 of 5"); may be empty
[[nodiscard]] ProgressCallback terminal_progress(std::function<std::string()> prefix = {});

/// Wipes the bar, if one stands.
void clear_progress();

/// A line on stderr.
void say(std::string_view line);
/// Text on stdout, the result.
void print_result(std::string_view text);

/// Writes machine-readable text to a file, or to stdout when `target` is "-".
void write_json(const std::string& target, std::string_view json);

/// A folder of results under construction: files are made in a hidden folder inside it and moved
/// into place together.
///
/// Left without `commit`, it removes what it made, the folder itself included if it was not there
/// before.
class OutputFolder {
 public:
  /// @throws InputError if the folder can neither be made nor written to
  explicit OutputFolder(std::filesystem::path folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Where to make the file of that name.
  [[nodiscard]] std::filesystem::path file(const std::string& name) const {
    return m_staging / name;
  }
  /// Moves all files into place, replacing older ones of the same names.
  void commit();

 private:
  std::filesystem::path m_folder;
  std::filesystem::path m_staging;
  std::filesystem::path m_made;  ///< the outermost folder that was not there before; empty: none
  bool m_committed = false;
};

}  // namespace twang::app
