// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/trace.hpp"

#include <filesystem>
#include <string>
#include <string_view>

namespace twang {

/// Reads a CSV file with a header line, a time column and any number of named numeric channels.
///
/// Commas separate; `nan`, `NaN` and empty cells are missing samples; lines that are blank or hold
/// empty cells alone are passed over, and so are columns without a header; a UTF-8 byte order mark,
/// CRLF line ends, cells in quotation marks and lines that begin with `#` are accepted.
///
/// @param time_column  header of the column that holds the time [s]
/// @return  time and channels in file order; rows keep their order and their number
/// @throws InputError naming file and line if the file cannot be read, is empty, lacks the time
/// column, repeats a
///         header, has a row of another length, a cell that is no number, or a time that is missing
///         or does not increase
[[nodiscard]] Trace read_trace_csv(const std::filesystem::path& path,
                                   const std::string& time_column = "time_s");

/// The same from the text of a file.
/// @param file  its name, for messages
[[nodiscard]] Trace parse_trace_csv(std::string_view content,
                                    const std::filesystem::path& file,
                                    const std::string& time_column = "time_s");

/// Writes a trace as CSV, `time_s` first, so that every double reads back exactly; the file appears
/// whole or not at all.
/// @throws InputError if the file cannot be written
void write_trace_csv(const std::filesystem::path& path, const Trace& trace);

}  // namespace twang
