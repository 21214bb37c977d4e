// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

namespace twang {
namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string exact_text(double value) {
  if (std::isnan(value)) return "nan";  // whatever its sign
  return fmt::format("{}", value);
}

std::string rounded_text(double value, int digits) {
  if (!std::isfinite(value)) return exact_text(value);
  if (value == 0.0) return "0";
  // Rounded first: 0.9996 to three digits is 1.00, not 1.000, and 1234567 is 1230000.
  const std::string scientific = fmt::format("{:.{}e}", value, digits - 1);
  const int magnitude = std::stoi(scientific.substr(scientific.find('e') + 1));
  constexpr int kSmallestPlain = -4;
  constexpr int kLargestPlain = 6;
  if (magnitude < kSmallestPlain || magnitude > kLargestPlain) return scientific;
  const int decimals = std::max(0, digits - 1 - magnitude);
  return fmt::format("{:.{}f}", std::stod(scientific), decimals);
}

std::string text_with_sigma(double value, double sigma) {
  constexpr int kDigitsWithoutSigma = 4;
  if (!std::isfinite(value)) return "–";
  const std::string alone = rounded_text(value, kDigitsWithoutSigma);
  if (!std::isfinite(sigma) || sigma <= 0.0) return alone;
  // The place of sigma's second digit, after rounding sigma to two digits (0.0996 is 0.10).
  const double rounded_sigma = std::stod(fmt::format("{:.1e}", sigma));
  const int place = static_cast<int>(std::floor(std::log10(rounded_sigma) + 1e-12)) - 1;
  constexpr int kFinestPlace = -12;
  if (place >= 0) {
    const double unit = std::pow(10.0, place);
    return fmt::format("{:.0f} ± {:.0f}", std::round(value / unit) * unit, rounded_sigma);
  }
  if (place < kFinestPlace) return alone;
  return fmt::format("{0:.{2}f} ± {1:.{2}f}", value, rounded_sigma, -place);
}

std::string escape_xml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return escaped;
}

std::string nearest_word(std::string_view word, std::span<const std::string> candidates) {
  const auto nearest = std::min_element(
      candidates.begin(), candidates.end(), [&](const std::string& a, const std::string& b) {
        return edit_distance(word, a) < edit_distance(word, b);
      });
  return nearest == candidates.end() ? std::string() : *nearest;
}

std::string with_article(std::string_view word) {
  const bool vowel =
      !word.empty() && std::string_view("aeiouAEIOU").find(word.front()) != std::string_view::npos;
  std::string text = vowel ? "an " : "a ";
  text += word;
  return text;
}

}  // namespace twang
