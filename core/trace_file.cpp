// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/trace_file.hpp"

#include "core/atomic_file.hpp"
#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

namespace twang {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::string_view unquoted(std::string_view text) {
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"')
    return text.substr(1, text.size() - 2);
  return text;
}

/// Where the cell that begins at `begin` ends: the next comma that no quotation marks enclose.
std::size_t end_of_cell(std::string_view line, std::size_t begin) {
  bool quoted = false;
  for (std::size_t i = begin; i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (line[i] == ',' && !quoted) return i;
  }
  return std::string_view::npos;
}

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  std::size_t begin = 0;
  for (;;) {
    const std::size_t comma = end_of_cell(line, begin);
    cells.push_back(unquoted(trimmed(line.substr(begin, comma - begin))));
    if (comma == std::string_view::npos) return cells;
    begin = comma + 1;
  }
}

/// A number, nan for a missing sample, nothing for a text that is neither.
std::optional<double> number_from(std::string_view cell) {
  if (cell.empty()) return kNaN;
  if (cell.front() == '+' && !cell.starts_with("+-")) cell.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error == std::errc::result_out_of_range) return std::nullopt;
  if (error != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
  return value;
}

/// Splits a text into lines, without their ends, and counts them from 1.
class LineReader {
 public:
  explicit LineReader(std::string_view text) : m_rest(text) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (m_rest.starts_with(kByteOrderMark)) m_rest.remove_prefix(kByteOrderMark.size());
  }
  /// The next line that is neither blank nor a comment.
  std::optional<std::string_view> next() {
    while (!m_rest.empty()) {
      ++m_number;
      const std::size_t end = m_rest.find('\n');
      const std::string_view line = trimmed(m_rest.substr(0, end));
      m_rest = end == std::string_view::npos ? std::string_view() : m_rest.substr(end + 1);
      if (!line.empty() && line.front() != '#') return line;
    }
    return std::nullopt;
  }
  [[nodiscard]] int number() const { return m_number; }

 private:
  std::string_view m_rest;
  int m_number = 0;
};

std::string printable(std::string_view cell) {
  constexpr std::size_t kLongest = 40;
  std::string text(cell.substr(0, kLongest));
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

/// Spreadsheets of many languages separate columns otherwise.
void refuse_other_separators(std::string_view header,
                             const std::filesystem::path& path,
                             int line_number) {
  if (header.find(',') != std::string_view::npos) return;
  for (const auto& [separator, name] : {std::pair{';', "semicolons"}, {'\t', "tabs"}}) {
    if (header.find(separator) == std::string_view::npos) continue;
    throw InputError(
        fmt::format("{}:{}: columns are separated by {}, must be by commas, with a "
                    "point in decimal numbers",
                    path.string(),
                    line_number,
                    name));
  }
}

/// What a cleared row of a spreadsheet leaves.
bool is_blank(const std::vector<std::string_view>& cells) {
  return std::all_of(
      cells.begin(), cells.end(), [](std::string_view cell) { return cell.empty(); });
}

}  // namespace

Trace parse_trace_csv(std::string_view content,
                      const std::filesystem::path& path,
                      const std::string& time_column) {
  LineReader lines(content);
  const auto head = lines.next();
  if (!head)
    throw InputError(
        fmt::format("{}: is empty, must be a CSV table with a header line", path.string()));
  if (content.find('\0') != std::string_view::npos) {
    const bool utf16 = content.starts_with("\xFF\xFE") || content.starts_with("\xFE\xFF");
    throw InputError(fmt::format("{}: is {}, must be a CSV table{}",
                                 path.string(),
                                 utf16 ? "UTF-16 text" : "a binary file",
                                 utf16 ? " in UTF-8" : ""));
  }
  refuse_other_separators(*head, path, lines.number());
  const std::vector<std::string_view> names = cells_of(*head);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!names[i].empty() && std::count(names.begin(), names.end(), names[i]) > 1) {
      throw InputError(fmt::format("{}:{}: the column '{}' appears twice, must be unique",
                                   path.string(),
                                   lines.number(),
                                   printable(names[i])));
    }
  }
  const auto time_it = std::find(names.begin(), names.end(), time_column);
  if (time_it == names.end()) {
    std::string first_names;
    for (std::size_t i = 0; i < std::min<std::size_t>(names.size(), 6); ++i) {
      first_names += (i ? ", " : "") + printable(names[i]);
    }
    throw InputError(
        fmt::format("{}:{}: has no time column '{}' (columns: {}); name it with --time-column",
                    path.string(),
                    lines.number(),
                    time_column,
                    first_names));
  }
  const auto time_index = static_cast<std::size_t>(time_it - names.begin());

  Trace trace;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i != time_index && !names[i].empty()) {
      trace.channels.push_back({std::string(names[i]), {}});
    }
  }
  while (const auto line = lines.next()) {
    const std::vector<std::string_view> cells = cells_of(*line);
    if (is_blank(cells)) continue;
    if (cells.size() != names.size()) {
      throw InputError(fmt::format("{}:{}: has {} cells, must be {} as in the header",
                                   path.string(),
                                   lines.number(),
                                   cells.size(),
                                   names.size()));
    }
    std::size_t channel = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (names[i].empty()) continue;
      const auto value = number_from(cells[i]);
      if (!value) {
        const bool decimal_comma = cells[i].find(',') != std::string_view::npos;
        throw InputError(fmt::format("{}:{}: {} is '{}', must be a number{} or nan",
                                     path.string(),
                                     lines.number(),
                                     names[i],
                                     printable(cells[i]),
                                     decimal_comma ? " with a decimal point" : ""));
      }
      if (i != time_index) {
        trace.channels[channel++].values.push_back(*value);
        continue;
      }
      if (!std::isfinite(*value) || (!trace.time_s.empty() && *value <= trace.time_s.back())) {
        throw InputError(
            fmt::format("{}:{}: {} is '{}', must be a finite time after the line before",
                        path.string(),
                        lines.number(),
                        time_column,
                        printable(cells[i])));
      }
      trace.time_s.push_back(*value);
    }
  }
  if (trace.time_s.empty()) {
    throw InputError(fmt::format("{}: has a header and no rows, must hold samples", path.string()));
  }
  return trace;
}

Trace read_trace_csv(const std::filesystem::path& path, const std::string& time_column) {
  return parse_trace_csv(read_file(path), path, time_column);
}

void write_trace_csv(const std::filesystem::path& path, const Trace& trace) {
  std::string text = "time_s";
  for (const Channel& channel : trace.channels) text += "," + channel.name;
  text += '\n';
  for (std::size_t row = 0; row < trace.num_samples(); ++row) {
    text += exact_text(trace.time_s[row]);
    for (const Channel& channel : trace.channels) {
      text += ',';
      text += exact_text(channel.values[row]);
    }
    text += '\n';
  }
  write_file_atomically(path, text);
}

}  // namespace twang
