// SPDX-License-Identifier: GPL-3.0-or-later
#include "report/detail/table_markup.hpp"

#include <gtest/gtest.h>

namespace twang::detail {
namespace {

TEST(EscapeLatex, DisarmsEveryCharacterThatTexReads) {
  EXPECT_EQ(escape_latex("a_b"), "a\\_b");
  EXPECT_EQ(escape_latex("50 % & $3 #1"), "50 \\% \\& \\$3 \\#1");
  EXPECT_EQ(escape_latex("{x}"), "\\{x\\}");
  EXPECT_EQ(escape_latex("\\input{/etc}"), "\\textbackslash{}input\\{/etc\\}");
  EXPECT_EQ(escape_latex("~^<>|\""),
            "\\textasciitilde{}\\textasciicircum{}\\textless{}\\textgreater{}\\textbar{}"
            "\\textquotedbl{}");
  // At the start of a row a bracket would be the optional argument of the \\ before it.
  EXPECT_EQ(escape_latex("[1]"), "{[}1{]}");
  EXPECT_EQ(escape_latex("1 ± 2 – δ"), "1 $\\pm$ 2 -- $\\delta$");
  EXPECT_EQ(escape_latex("two\nlines"), "two lines");
}

TEST(EscapeMarkdown, DisarmsMarkupAndHtml) {
  EXPECT_EQ(escape_markdown("a|b_c*d`e"), "a\\|b\\_c\\*d\\`e");
  EXPECT_EQ(escape_markdown("[x](y) <b> & \\"), "\\[x\\](y) &lt;b&gt; &amp; \\\\");
  EXPECT_EQ(escape_markdown("two\r\nlines"), "two lines");
}

TEST(CsvLine, QuotesWhatWouldSplitACell) {
  EXPECT_EQ(csv_line({"a b", "c,d", "say \"e\"", "f\ng", ""}),
            "a b,\"c,d\",\"say \"\"e\"\"\",\"f\ng\",\n");
}

TEST(TextTable, PadsByCharactersNotBytes) {
  const PlainTable table{{"né", "n"}, {false, true}, {{"é", "1"}, {"abc", "22"}}};
  EXPECT_EQ(text_table(table), "né    n\n---  --\né     1\nabc  22\n");
}

TEST(TextTable, PutsARowOnOneLine) {
  const PlainTable table{{"a"}, {false}, {{"two\nlines"}}};
  EXPECT_EQ(text_table(table), "a\n---------\ntwo lines\n");
}

}  // namespace
}  // namespace twang::detail
