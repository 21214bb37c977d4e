// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace twang {

/// The shortest decimal text that reads back as exactly `value`; "nan" and "inf" for what is not
/// finite.
[[nodiscard]] std::string exact_text(double value);

/// `value` with `digits` significant digits, without an exponent between 1e-4 and 1e7.
[[nodiscard]] std::string rounded_text(double value, int digits);

/// `value` ± `sigma`, both rounded where the second significant digit of sigma stands; `value`
/// alone with four digits if sigma is not a positive number, "–" if value is not finite.
[[nodiscard]] std::string text_with_sigma(double value, double sigma);

/// `text` as the content of an XML element or attribute: markup as entities, control characters as
/// blanks.
[[nodiscard]] std::string escape_xml(std::string_view text);

/// The candidate with the smallest edit distance (Levenshtein) to `word`; empty if there is no
/// candidate.
[[nodiscard]] std::string nearest_word(std::string_view word,
                                       std::span<const std::string> candidates);

/// A word with its indefinite article, by its first letter: "a cross", "an aruco".
[[nodiscard]] std::string with_article(std::string_view word);

}  // namespace twang
