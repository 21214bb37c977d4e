// SPDX-License-Identifier: GPL-3.0-or-later
#include "report/detail/table_markup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace twang::detail {
namespace {

using Replacement = std::pair<std::string_view, std::string_view>;

/// `text` with the first replacement that fits at each place; lines become one.
template <std::size_t N>
std::string replace_all(std::string_view text, const std::array<Replacement, N>& replacements) {
  std::string result;
  while (!text.empty()) {
    const auto fits = std::find_if(replacements.begin(), replacements.end(), [&](const auto& r) {
      return text.starts_with(r.first);
    });
    if (fits != replacements.end()) {
      result += fits->second;
      text.remove_prefix(fits->first.size());
    } else {
      result += text.front() == '\n' || text.front() == '\r' ? ' ' : text.front();
      text.remove_prefix(1);
    }
  }
  return result;
}

/// Characters of UTF-8, each taken as one column wide.
std::size_t width_of(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char byte) {
    return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U;
  }));
}

std::string padded(const std::string& text, std::size_t width, bool to_the_right) {
  const std::string blanks(width - std::min(width, width_of(text)), ' ');
  return to_the_right ? blanks + text : text + blanks;
}

std::vector<std::size_t> column_widths(const PlainTable& table) {
  std::vector<std::size_t> widths;
  for (const std::string& cell : table.head) widths.push_back(width_of(cell));
  for (const Cells& row : table.rows) {
    for (std::size_t i = 0; i < widths.size(); ++i)
      widths[i] = std::max(widths[i], width_of(row[i]));
  }
  return widths;
}

template <std::size_t N>
PlainTable escaped(const PlainTable& table, const std::array<Replacement, N>& replacements) {
  PlainTable result = table;
  for (std::string& cell : result.head) cell = replace_all(cell, replacements);
  for (Cells& row : result.rows) {
    for (std::string& cell : row) cell = replace_all(cell, replacements);
  }
  return result;
}

/// The cells of a row, padded, with `separator` between them.
std::string aligned_row(const PlainTable& table,
                        const Cells& row,
                        const std::vector<std::size_t>& widths,
                        std::string_view separator) {
  std::string line;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (i > 0) line += separator;
    line += padded(row[i], widths[i], table.is_number[i]);
  }
  return line;
}

std::string without_trailing_blanks(std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  return line;
}

constexpr std::array<Replacement, 2> kPlain = {{{"\r\n", " "}, {"\t", " "}}};

constexpr std::array<Replacement, 15> kMarkdown = {{{"\r\n", " "},
                                                    {"\\", "\\\\"},
                                                    {"|", "\\|"},
                                                    {"*", "\\*"},
                                                    {"_", "\\_"},
                                                    {"`", "\\`"},
                                                    {"[", "\\["},
                                                    {"]", "\\]"},
                                                    {"<", "&lt;"},
                                                    {">", "&gt;"},
                                                    {"&", "&amp;"},
                                                    {"~", "\\~"},
                                                    {"$", "\\$"},
                                                    {"#", "\\#"},
                                                    {"\t", " "}}};

constexpr std::array<Replacement, 22> kLatex = {{{"\r\n", " "},
                                                 {"ₙ", "$_n$"},
                                                 {"\\", "\\textbackslash{}"},
                                                 {"{", "\\{"},
                                                 {"}", "\\}"},
                                                 {"&", "\\&"},
                                                 {"%", "\\%"},
                                                 {"$", "\\$"},
                                                 {"#", "\\#"},
                                                 {"_", "\\_"},
                                                 {"~", "\\textasciitilde{}"},
                                                 {"^", "\\textasciicircum{}"},
                                                 {"<", "\\textless{}"},
                                                 {">", "\\textgreater{}"},
                                                 {"|", "\\textbar{}"},
                                                 {"\"", "\\textquotedbl{}"},
                                                 {" ± ", " $\\pm$ "},
                                                 {"±", "$\\pm$"},
                                                 {"δ", "$\\delta$"},
                                                 {"–", "--"},
                                                 {"[", "{[}"},
                                                 {"]", "{]}"}}};

}  // namespace

std::string escape_latex(std::string_view text) { return replace_all(text, kLatex); }
std::string escape_markdown(std::string_view text) { return replace_all(text, kMarkdown); }

std::string text_table(const PlainTable& table) {
  const PlainTable plain = escaped(table, kPlain);
  const std::vector<std::size_t> widths = column_widths(plain);
  constexpr std::string_view kSeparator = "  ";
  std::string text =
      without_trailing_blanks(aligned_row(plain, plain.head, widths, kSeparator)) + "\n";
  Cells rule;
  for (const std::size_t width : widths) rule.push_back(std::string(width, '-'));
  text += aligned_row(plain, rule, widths, kSeparator) + "\n";
  for (const Cells& row : plain.rows)
    text += without_trailing_blanks(aligned_row(plain, row, widths, kSeparator)) + "\n";
  return text;
}

std::string markdown_table(const PlainTable& table) {
  const PlainTable safe = escaped(table, kMarkdown);
  const std::vector<std::size_t> widths = column_widths(safe);
  std::string text = "| " + aligned_row(safe, safe.head, widths, " | ") + " |\n|";
  for (std::size_t i = 0; i < widths.size(); ++i)
    text += fmt::format(" {}{} |", std::string(widths[i] - 1, '-'), safe.is_number[i] ? ":" : "-");
  text += "\n";
  for (const Cells& row : safe.rows) text += "| " + aligned_row(safe, row, widths, " | ") + " |\n";
  return text;
}

std::string latex_table(const PlainTable& table) {
  const PlainTable safe = escaped(table, kLatex);
  const std::vector<std::size_t> widths = column_widths(safe);
  std::string columns;
  for (const bool number : safe.is_number) columns += number ? 'r' : 'l';
  const auto line = [&](const Cells& row) {
    return "  " + aligned_row(safe, row, widths, " & ") + " \\\\\n";
  };
  std::string text = "% needs \\usepackage{booktabs}\n\\begin{tabular}{" + columns +
                     "}\n  \\toprule\n" + line(safe.head) + "  \\midrule\n";
  for (const Cells& row : safe.rows) text += line(row);
  return text + "  \\bottomrule\n\\end{tabular}\n";
}

std::string csv_line(const Cells& cells) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) line += ',';
    const bool plain = cells[i].find_first_of(",\"\r\n") == std::string::npos;
    if (plain) {
      line += cells[i];
      continue;
    }
    line += '"';
    for (const char character : cells[i]) {
      if (character == '"') line += '"';
      line += character;
    }
    line += '"';
  }
  return line + "\n";
}

}  // namespace twang::detail
