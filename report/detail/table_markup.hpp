// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace twang::detail {

using Cells = std::vector<std::string>;

/// A table of plain texts; each row has as many cells as the head.
struct PlainTable {
  Cells head;
  std::vector<bool> is_number;  ///< a column, ranged right
  std::vector<Cells> rows;
};

/// Columns padded with blanks to the width of their widest cell, a rule under the head.
[[nodiscard]] std::string text_table(const PlainTable& table);

/// A pipe table; what Markdown would take for markup is escaped.
[[nodiscard]] std::string markdown_table(const PlainTable& table);

/// A tabular of the package booktabs; what TeX would take for markup is escaped.
[[nodiscard]] std::string latex_table(const PlainTable& table);

/// One line of RFC 4180 CSV, with its end.
[[nodiscard]] std::string csv_line(const Cells& cells);

[[nodiscard]] std::string escape_latex(std::string_view text);
[[nodiscard]] std::string escape_markdown(std::string_view text);

}  // namespace twang::detail
